// The release detector judges by when the edges came, not by how often the main loop came round.
#include <random>

#include "../../firmware/arduino_sequencer/src/core/release_detector.h"
#include "fake_ports.h"

using namespace tfsat::sequencer;
using tfsat_test::FakeSwitches;

namespace {

constexpr tick_t kAfterwards = 60 * kTicksPerMs;

struct Contact {
  tick_t at;
  uint8_t index;
  bool open;
};

struct Verdict {
  bool released;
  tick_t at;
  uint16_t knocks, bounces;
};

using Random = std::mt19937;

tick_t draw(Random& random, tick_t least, tick_t most) {
  return std::uniform_int_distribution<tick_t>(least, most)(random);
}

// Watches until the release or long after the last contact; the loop comes round every `least` to
// `most` ticks. The time of the release is told since `start`.
Verdict watch(const std::vector<Contact>& contacts, tick_t start, tick_t least, tick_t most,
              unsigned seed) {
  Random random(seed);
  FakeSwitches switches;
  ReleaseDetector detector;
  detector.reset(start, 0);
  const tick_t end = contacts.back().at + kAfterwards;
  size_t next = 0;
  for (tick_t passed = 0; passed < end;) {
    passed += draw(random, least, most);
    for (; next < contacts.size() && contacts[next].at <= passed; ++next) {
      switches.set(contacts[next].index, contacts[next].open, start + contacts[next].at);
    }
    SwitchEdge edge;
    while (switches.take_edge(edge)) detector.on_edge(edge);
    if (detector.poll(start + passed, switches.levels())) {
      return {true, detector.released_at() - start, detector.knocks(), detector.bounces()};
    }
  }
  return {false, 0, detector.knocks(), 0};
}

Verdict polled_every_ms(const std::vector<Contact>& contacts, tick_t ms) {
  return watch(contacts, 0, ms * kTicksPerMs, ms * kTicksPerMs, 0);
}

Contact at_us(uint32_t us, uint8_t index, bool open) { return {us * kTicksPerUs, index, open}; }

bool same(const Verdict& a, const Verdict& b) {
  return a.released == b.released && a.at == b.at && a.knocks == b.knocks && a.bounces == b.bounces;
}

}  // namespace

TEST_CASE(a_knock_just_before_the_release_is_not_the_release_however_slow_the_loop) {
  const std::vector<Contact> knock_and_release = {
      at_us(4000, 0, true),   at_us(4100, 1, true),   // 3 ms open
      at_us(7000, 0, false),  at_us(7100, 1, false),  // 6 ms closed
      at_us(13000, 0, true),  at_us(13100, 1, true)};
  for (const tick_t ms : {1, 10, 15}) {
    const Verdict verdict = polled_every_ms(knock_and_release, ms);
    CHECK(verdict.released && verdict.at == 13100 * kTicksPerUs);
    CHECK(verdict.knocks == 1);
  }
}

TEST_CASE(both_open_for_the_debounce_is_a_release_though_they_close_before_the_loop_looks) {
  const std::vector<Contact> brief = {at_us(4000, 0, true), at_us(4100, 1, true),
                                      at_us(12100, 0, false), at_us(12200, 1, false)};
  for (const tick_t ms : {1, 10, 15}) {
    const Verdict verdict = polled_every_ms(brief, ms);
    CHECK(verdict.released && verdict.at == 4100 * kTicksPerUs);
  }
}

// Each time the loop looks, the next edge is there already, and its stamp comes a moment later.
TEST_CASE(levels_that_are_ahead_of_their_edges_again_and_again_are_not_taken_for_a_missed_edge) {
  ReleaseDetector detector;
  detector.reset(0, 0);
  const Contact contacts[] = {at_us(0, 1, true),    at_us(400, 0, true),   at_us(800, 0, false),
                              at_us(1200, 0, true), at_us(1600, 0, false), at_us(2000, 0, true)};
  uint8_t level = 0;
  for (const Contact& contact : contacts) {
    const uint8_t bit = static_cast<uint8_t>(1 << contact.index);
    level = static_cast<uint8_t>(contact.open ? level | bit : level & ~bit);
    CHECK(!detector.poll(contact.at + 10, level));
    detector.on_edge({contact.at, contact.index, contact.open});
  }
  CHECK(detector.poll(20 * kTicksPerMs, 3));
  CHECK(detector.released_at() == at_us(400, 0, true).at);
  CHECK(detector.bounces() == 5);
}

TEST_CASE(slow_loops_and_fast_ones_judge_the_same_contacts_the_same) {
  Random random(313);
  int releases = 0, knocks = 0;
  for (unsigned round = 0; round < 20000; ++round) {
    std::vector<Contact> contacts;
    bool open[2] = {false, false};
    tick_t at = 0;
    for (tick_t left = draw(random, 1, 24); left > 0; --left) {
      const tick_t longest = draw(random, 0, 1) == 0 ? kTicksPerMs : 9 * kTicksPerMs;
      at += draw(random, 1, longest);
      const uint8_t index = static_cast<uint8_t>(draw(random, 0, 1));
      open[index] = !open[index];
      contacts.push_back({at, index, open[index]});
    }
    const tick_t start = draw(random, 0, 0xFFFFFFFF);
    const Verdict fast = watch(contacts, start, kTicksPerMs / 2, kTicksPerMs / 2, round);
    const Verdict slow = watch(contacts, start, kTicksPerMs, 15 * kTicksPerMs, round);
    CHECK(same(fast, slow));
    releases += fast.released ? 1 : 0;
    knocks += fast.knocks;
  }
  std::printf("  %d of 20000 released, %d knocks\n", releases, knocks);
  CHECK(releases > 5000 && releases < 15000 && knocks > 5000);
}
