// Inputs that change faster than the log has room for: the release is known all the same.
#include <algorithm>
#include <random>

#include "../../firmware/teensy_logger/src/release/release_detector.h"
#include "board_bench.h"

using namespace tfsat;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::BoardBench;
using Random = std::mt19937;

namespace {

constexpr uint64_t kChatterUs = 50000;
// The debounce, a sample, and another one if a contact moved between the edges and the levels.
constexpr uint64_t kCertainUs = kReleaseDebounceUs + 2 * 3572;

struct Contact {
  uint64_t at_us;
  int index;
  bool open;
};

uint64_t draw(Random& random, uint64_t least, uint64_t most) {
  return std::uniform_int_distribution<uint64_t>(least, most)(random);
}

// Worn contacts: both open at once, and close and open again for 50 ms; some 130 edges.
std::vector<Contact> release(Random& random, uint64_t from_us) {
  std::vector<Contact> contacts;
  for (int index = 0; index < 2; ++index) {
    uint64_t at_us = from_us + static_cast<uint64_t>(index);
    contacts.push_back({at_us, index, true});
    while (at_us < from_us + kChatterUs) {
      at_us += draw(random, 50, 1500);
      contacts.push_back({at_us, index, false});
      at_us += draw(random, 50, 1500);
      contacts.push_back({at_us, index, true});
    }
  }
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.at_us < b.at_us; });
  return contacts;
}

// By the rule, which test_release_detector.cpp tests: contacts that chatter for so long are dated by the last
// of it.
uint64_t ruled_us(const std::vector<Contact>& contacts) {
  sequencer::ReleaseDetector detector{};
  detector.reset(0, 0);
  const uint64_t first_us = contacts.front().at_us;
  for (const Contact& contact : contacts) {
    detector.on_edge({sequencer::ticks_from_us(static_cast<uint32_t>(contact.at_us - first_us)),
                      static_cast<uint8_t>(contact.index), contact.open, false});
  }
  return first_us + sequencer::us_from_ticks(detector.released_at());
}

// The pins move up to half a millisecond before the board can have taken their edges.
void play(Bench& bench, const std::vector<Contact>& contacts) {
  for (const Contact& contact : contacts) {
    while (bench.t_us + 500 <= contact.at_us) bench.run_until(bench.t_us + 500);
    bench.board.set_switch(contact.index, !contact.open, contact.at_us);
  }
}

}  // namespace

TEST_CASE(the_release_is_told_at_once_and_by_the_rule_however_long_contacts_chatter) {
  for (unsigned seed = 0; seed < 15; ++seed) {
    Random random(seed);
    Bench bench;
    bench.start(1);
    bench.run_ms(300 + seed % 5);
    const uint64_t from_us = bench.t_us + draw(random, 10, 4000);
    const std::vector<Contact> contacts = release(random, from_us);
    play(bench, contacts);
    bench.run_until(contacts.back().at_us + kCertainUs);
    CHECK(bench.status().phase == DropPhase::kFalling);
    bench.run_ms(500);
    bench.stop();
    const Recording log = bench.log();
    const std::vector<Event> releases = events_of(log, EventCode::kRelease);
    CHECK(releases.size() == 1 && releases[0].time_us == ruled_us(contacts));
    CHECK(events_of(log, EventCode::kSwitchEdge).size() == contacts.size());
  }
}

// A broken wire of the stroke line: its edges fill the log's queue, and those that it cannot keep
// are counted.
TEST_CASE(a_line_that_hums_hides_no_release) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    Random random(seed);
    Bench bench;
    bench.start(1);
    bench.run_ms(300);
    size_t strokes = 0;
    const auto hum_until = [&](uint64_t end_us) {
      for (; bench.t_us < end_us; bench.run_until(bench.t_us + 500), strokes += 2) {
        bench.board.stroke_edge(bench.t_us + 100);
        bench.board.stroke_edge(bench.t_us + 350);
      }
    };
    hum_until(bench.t_us + 400000);
    const std::vector<Contact> contacts = release(random, bench.t_us + draw(random, 10, 4000));
    std::vector<Contact> stamped;
    for (const Contact& contact : contacts) {
      hum_until(contact.at_us);
      bench.board.set_switch(contact.index, !contact.open, bench.t_us);
      stamped.push_back({bench.t_us, contact.index, contact.open});
    }
    hum_until(bench.t_us + kCertainUs);
    CHECK(bench.status().phase == DropPhase::kFalling);
    bench.run_ms(1000);
    bench.board.stroke_edge(bench.t_us);  // tells what was not kept before it
    bench.run_ms(100);
    bench.stop();
    const Recording log = bench.log();
    const std::vector<Event> releases = events_of(log, EventCode::kRelease);
    CHECK(releases.size() == 1 && releases[0].time_us == ruled_us(stamped));
    size_t told = 0;
    for (const EventCode code : {EventCode::kSwitchEdge, EventCode::kStroke}) {
      for (const Event& event : events_of(log, code)) told += 1 + static_cast<size_t>(event.value);
    }
    CHECK(told == contacts.size() + strokes + 1);
    CHECK(events_of(log, EventCode::kStroke).back().index == strokes % 256);
  }
}
