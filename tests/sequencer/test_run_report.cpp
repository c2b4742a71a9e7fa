// The report of the last run: the release on the board's own clock, bounces, the strokes' onsets.
#include "bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Bench;

namespace {

// A release at `now` whose second contact closes and opens `bounces` times more, 0.3 ms apart.
tick_t drop(Bench& bench, int bounces) {
  bench.switches.set(0, true, bench.now);
  bench.switches.set(1, true, bench.now);
  const tick_t released_at = bench.now;
  for (int i = 0; i < 2 * bounces; ++i) {
    bench.now += 600;
    bench.switches.set(1, i % 2 != 0, bench.now);
    bench.poll();
  }
  bench.run_ms(10);
  CHECK(bench.core.state() == SequencerState::kRunning);
  return released_at;
}

void check_report(const Bench& bench, uint64_t release_us, int bounces, uint8_t strokes) {
  const RunReportReply& report = bench.core.run_report();
  const Maneuver maneuver = Maneuver::factory();
  CHECK(report.released == 1 && report.bounces == 1 + 2 * bounces);
  CHECK(report.release_us < 1000);
  CHECK_NEAR(1000.0 * report.release_ms + report.release_us, static_cast<double>(release_us), 1);
  CHECK(report.stroke_count == maneuver.stroke_count);
  for (uint8_t i = 0; i < kMaxStrokes; ++i) {
    CHECK(report.start_us[i] == (i < strokes ? maneuver.strokes[i].start_us : kStrokeNotBegunUs));
  }
}

std::vector<uint8_t> told(const Bench& bench) {
  std::vector<uint8_t> payload(RunReportReply::kSize);
  bench.core.run_report().encode(payload.data());
  return payload;
}

bool tells_of_no_run(const Bench& bench) {
  const RunReportReply& report = bench.core.run_report();
  for (const uint32_t start_us : report.start_us) {
    if (start_us != kStrokeNotBegunUs) return false;
  }
  return report.released == 0 && report.bounces == 0 && report.release_ms == 0 &&
         report.release_us == 0 && report.stroke_count == 0;
}

// A run in which two strokes have begun.
void fly(Bench& bench) {
  bench.wait_armed();
  drop(bench, 3);
  bench.first_strokes_begin(2);
  bench.run_ms(1);
}

}  // namespace

TEST_CASE(a_run_is_reported_until_the_next) {
  Bench bench;
  bench.wait_armed();
  bench.now += 1234;  // between two polls
  drop(bench, 3);
  check_report(bench, 20617, 3, 0);
  bench.first_strokes_begin(2);
  bench.run_ms(1);
  check_report(bench, 20617, 3, 2);
  bench.first_strokes_begin(4);
  bench.run_ms(2400);
  CHECK(bench.core.state() == SequencerState::kDone);
  bench.close_both();
  bench.run_ms(20);
  CHECK(bench.arm() == ErrorCode::kNone);
  check_report(bench, 20617, 3, 4);
  bench.core.disarm();
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.run_ms(1000);
  check_report(bench, 20617, 3, 4);
  bench.now += 777;
  const tick_t again_at = drop(bench, 0);
  check_report(bench, us_from_ticks(again_at), 0, 0);
}

// At any tick of a millisecond, on any clock: the report and uptime_ms tell the same time.
TEST_CASE(the_release_is_told_on_the_clock_of_uptime) {
  for (tick_t offset = 0; offset < kTicksPerMs; offset += 37) {
    for (const int32_t before_turn_ms : {0, 10, 25, 60000}) {
      Bench bench(static_cast<tick_t>(-before_turn_ms * static_cast<int32_t>(kTicksPerMs)));
      bench.wait_armed();
      bench.now += offset;
      drop(bench, 2);
      check_report(bench, 20000 + us_from_ticks(offset), 2, 0);
    }
  }
}

TEST_CASE(the_report_survives_resets_in_any_state_and_no_power_cut) {
  for (const uint32_t after_ms : {0u, 100u, 2500u}) {  // running, running, strokes missed
    for (const bool disarmed : {false, true}) {
      Bench flown;
      fly(flown);
      flown.run_ms(after_ms);
      if (disarmed) flown.core.disarm();
      check_report(flown, 20000, 3, 2);
      Bench once(flown, ResetCause::kWatchdog);
      once.run_ms(20);
      Bench twice(once, ResetCause::kBrownOut);
      CHECK(told(once) == told(flown) && told(twice) == told(flown));
      Bench dark(twice, ResetCause::kPowerOn);
      CHECK(tells_of_no_run(dark));
      Bench after_the_dark(dark, ResetCause::kExternal);
      CHECK(tells_of_no_run(after_the_dark));
    }
  }
}

TEST_CASE(a_run_that_was_finished_is_reported_after_a_reset_until_the_next) {
  Bench flown;
  fly(flown);
  flown.first_strokes_begin(4);
  flown.run_ms(2500);
  CHECK(flown.core.state() == SequencerState::kDone);
  flown.close_both();
  Bench bench(flown, ResetCause::kWatchdog);
  bench.run_ms(20);
  CHECK(bench.core.state() == SequencerState::kSafe && told(bench) == told(flown));
  bench.wait_armed();
  CHECK(told(bench) == told(flown));
  drop(bench, 1);
  check_report(bench, 40000, 1, 0);
}

// Its checksum is its own: neither the report's damage nor the state's takes the other along.
TEST_CASE(a_report_with_a_flipped_bit_is_no_report) {
  Bench flown;
  fly(flown);
  const size_t size = sizeof(RunReportReply) + sizeof(uint16_t);
  for (size_t bit = 0; bit < 8 * size; ++bit) {
    Bench damaged(flown, ResetCause::kWatchdog);
    damaged.retained = flown.retained;
    uint8_t* bytes = reinterpret_cast<uint8_t*>(&damaged.retained.run);
    bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ (1u << (bit % 8)));
    Bench bench(damaged, ResetCause::kWatchdog);
    // The strokes that the interrupts marked are known all the same, but not when they began.
    CHECK(bench.core.run_report().released == 0);
    CHECK(bench.core.fault() == ErrorCode::kResetWhileRunning);
    CHECK(bench.core.strokes_started() == 2);
    CHECK(bench.core.run_report().start_us[1] == kStrokeTimeUnknownUs);
    Bench again(bench, ResetCause::kWatchdog);
    CHECK(again.core.run_report().released == 0 && again.core.strokes_started() == 2);
  }
  Bench forgetful(flown, ResetCause::kWatchdog);
  forgetful.retained = flown.retained;
  forgetful.retained.crc = static_cast<uint16_t>(~forgetful.retained.crc);
  Bench bench(forgetful, ResetCause::kWatchdog);
  CHECK(bench.core.state() == SequencerState::kSafe && told(bench) == told(flown));
}
