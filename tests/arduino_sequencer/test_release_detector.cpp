// The release detector judges by when the edges came, not by how often the main loop came round. What the rule makes
// of edges is held against the decoder's in tests/sdlog/test_release.py; here: loops, clocks, levels, counts.
#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Contact;
using tfsat_test::draw;
using tfsat_test::ScriptedSwitches;
using tfsat_test::Random;

namespace {

constexpr tick_t kAfterwards = 300 * kTicksPerMs;

struct Told {
  bool released;
  tick_t at;
  uint32_t earlier, later;
  uint16_t knocks, bounces;
  std::vector<tick_t> false_at;  // when it was told, to a loop
};

using Verdict = ReleaseDetector::Verdict;

// Watches until long after the last contact; the loop comes round every `least` to `most` ticks. The last
// release that was no false one, told since `start`.
Told watch(const std::vector<Contact>& contacts, tick_t start, tick_t least, tick_t most,
           unsigned seed) {
  Random random(seed);
  ScriptedSwitches switches;
  ReleaseDetector detector{};
  detector.reset(start, 0);
  Told told = {};
  const auto heed = [&](Verdict verdict, tick_t now) {
    if (verdict == Verdict::kReleased) {
      CHECK(!told.released);
      told.released = true;
      told.at = detector.released_at() - start;
      told.bounces = detector.bounces();
    } else if (verdict == Verdict::kFalseRelease) {
      CHECK(told.released);
      told.released = false;
      told.false_at.push_back(now);
    }
  };
  const tick_t end = contacts.back().at + kAfterwards;
  size_t next = 0;
  for (tick_t passed = 0; passed < end;) {
    passed += draw(random, least, most);
    for (; next < contacts.size() && contacts[next].at <= passed; ++next) {
      switches.set(contacts[next].index, contacts[next].open, start + contacts[next].at);
    }
    SwitchEdge edge;
    while (switches.take_edge(edge)) heed(detector.on_edge(edge), passed);
    heed(detector.poll(start + passed, switches.levels()), passed);
  }
  told.knocks = detector.knocks();
  if (told.released) {
    CHECK(detector.released_at() - start == told.at);
    told.earlier = detector.earlier_ticks();
    told.later = detector.later_ticks();
  } else {
    told.at = told.bounces = 0;
  }
  return told;
}

Contact at_us(uint32_t us, uint8_t index, bool open) { return {us * kTicksPerUs, index, open}; }

bool same(const Told& a, const Told& b) {
  return a.released == b.released && a.at == b.at && a.earlier == b.earlier && a.later == b.later &&
         a.knocks == b.knocks && a.bounces == b.bounces && a.false_at.size() == b.false_at.size();
}

}  // namespace

TEST_CASE(sound_contacts_are_dated_by_their_first_edge_and_certain) {
  std::vector<Contact> contacts = {at_us(4000, 0, true), at_us(4100, 1, true)};
  for (uint32_t us = 4600; us < 9000; us += 1000) {
    contacts.push_back(at_us(us, 1, false));
    contacts.push_back(at_us(us + 500, 1, true));
  }
  const Told told = watch(contacts, 0, kTicksPerMs, kTicksPerMs, 0);
  CHECK(told.released && told.at == 4100 * kTicksPerUs && told.earlier == 0 && told.later == 0);
  CHECK(told.bounces == 11);
}

// Each time the loop looks, the next edge is there already, and its stamp comes a moment later.
TEST_CASE(levels_that_are_ahead_of_their_edges_again_and_again_are_not_taken_for_a_missed_edge) {
  ReleaseDetector detector{};
  detector.reset(0, 0);
  const Contact contacts[] = {at_us(0, 1, true),    at_us(400, 0, true),   at_us(800, 0, false),
                              at_us(1200, 0, true), at_us(1600, 0, false), at_us(2000, 0, true)};
  uint8_t level = 0;
  for (const Contact& contact : contacts) {
    const uint8_t bit = static_cast<uint8_t>(1 << contact.index);
    level = static_cast<uint8_t>(contact.open ? level | bit : level & ~bit);
    CHECK(detector.poll(contact.at + 10, level) == Verdict::kNone);
    CHECK(detector.on_edge({contact.at, contact.index, contact.open, false}) == Verdict::kNone);
  }
  CHECK(detector.poll(20 * kTicksPerMs, 3) == Verdict::kReleased);
  CHECK(detector.released_at() == at_us(400, 0, true).at);
  CHECK(detector.bounces() == 5);
}

TEST_CASE(slow_loops_and_fast_ones_judge_the_same_contacts_the_same) {
  Random random(313);
  size_t releases = 0, knocks = 0, false_releases = 0, doubtful = 0;
  for (unsigned round = 0; round < 6000; ++round) {
    std::vector<Contact> contacts;
    bool open[2] = {false, false};
    tick_t at = 0;
    for (tick_t left = draw(random, 1, 24); left > 0; --left) {
      const tick_t longest[] = {kTicksPerMs, 9 * kTicksPerMs, 300 * kTicksPerMs};
      at += draw(random, 1, longest[draw(random, 0, 8) * 2 / 8]);
      const uint8_t index = static_cast<uint8_t>(draw(random, 0, 1));
      open[index] = !open[index];
      contacts.push_back({at, index, open[index]});
    }
    const tick_t start = draw(random, 0, 0xFFFFFFFF);
    const Told fast = watch(contacts, start, kTicksPerMs / 2, kTicksPerMs / 2, round);
    const Told slow = watch(contacts, start, kTicksPerMs, 15 * kTicksPerMs, round);
    CHECK(same(fast, slow));
    releases += fast.released ? 1 : 0;
    knocks += fast.knocks;
    false_releases += fast.false_at.size();
    doubtful += fast.earlier + fast.later > 0 ? 1 : 0;
  }
  std::printf("  %zu of 6000 released, %zu of them doubtful; %zu knocks, %zu false releases\n", releases,
              doubtful, knocks, false_releases);
  CHECK(releases > 1500 && releases < 4500 && knocks > 1500 && false_releases > 60 && doubtful > 300);
}

// A wire that rattles for minutes: the count stops at its end and does not start anew.
TEST_CASE(knocks_are_counted_up_to_65535) {
  ReleaseDetector detector{};
  tick_t t = 0;
  detector.reset(t, 65533);
  for (int knock = 0; knock < 4; ++knock) {
    for (const bool open : {true, false}) {
      t += kTicksPerMs;
      SwitchEdge edge;
      edge.at = t;
      edge.index = 0;
      edge.open = open;
      edge.lost = false;
      detector.on_edge(edge);
    }
    t += ticks_from_us(kReleaseDebounceUs + 1000);
    detector.poll(t, 0);
  }
  CHECK(detector.knocks() == 65535);
}

// A board that was blind says so with the next edge.
namespace {

Verdict edge_at(ReleaseDetector& detector, tick_t us, uint8_t index, bool open, bool lost = false) {
  return detector.on_edge({us * kTicksPerUs, index, open, lost});
}

}  // namespace

TEST_CASE(a_release_among_lost_edges_is_within_its_interval) {
  ReleaseDetector detector{};
  detector.reset(0, 0);
  edge_at(detector, 100000, 0, true);
  // Until here the second switch may have opened at any time.
  edge_at(detector, 103000, 1, true, true);
  CHECK(detector.poll(109000 * kTicksPerUs, 3) == Verdict::kReleased);
  CHECK(detector.released_at() == 103000 * kTicksPerUs);
  CHECK(detector.earlier_ticks() == 3000 * kTicksPerUs && detector.later_ticks() == 0);
  CHECK(detector.knocks() == 0);
}

TEST_CASE(a_release_may_be_later_by_as_long_as_both_may_have_been_closed_again) {
  for (const bool long_enough : {false, true}) {
    ReleaseDetector detector{};
    detector.reset(0, 0);
    edge_at(detector, 100000, 0, true);
    edge_at(detector, 100010, 1, true);
    edge_at(detector, 100020, 1, false);
    edge_at(detector, 100020 + kReleaseHungUs - !long_enough, 1, true, true);
    CHECK(detector.poll(110000 * kTicksPerUs, 3) == Verdict::kReleased);
    CHECK(detector.released_at() == 100010 * kTicksPerUs);
    CHECK(detector.earlier_ticks() == 0);
    CHECK(detector.later_ticks() == (long_enough ? (10 + kReleaseHungUs) * kTicksPerUs : 0));
  }
}

TEST_CASE(time_without_edges_is_no_knock_and_is_forgotten_once_both_stay_closed) {
  ReleaseDetector detector{};
  detector.reset(0, 0);
  edge_at(detector, 100000, 0, true);
  edge_at(detector, 100005, 0, false);
  // No change: the board looks again after 14 ms. Nobody knows that both were closed meanwhile.
  edge_at(detector, 114000, 0, false, true);
  detector.poll(115000 * kTicksPerUs, 0);
  CHECK(detector.knocks() == 0);
  detector.poll(120000 * kTicksPerUs, 0);
  CHECK(detector.knocks() == 1);
  edge_at(detector, 130000, 0, true);
  edge_at(detector, 130100, 1, true);
  CHECK(detector.poll(140000 * kTicksPerUs, 3) == Verdict::kReleased);
  CHECK(detector.released_at() == 130100 * kTicksPerUs);
  CHECK(detector.earlier_ticks() == 0 && detector.later_ticks() == 0);
}
