// What no card has is in RAM: a drop without a card, and one whose card was pulled in flight.
#include <initializer_list>

#include "recorder_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::RecorderBench;

namespace {

constexpr uint64_t kFallenUs = 2500000;
constexpr uint64_t kLongUs = 60000000;

Recording ram_of(const Bench& bench) {
  const std::vector<Block> blocks = bench.ram();
  const Recording ram = tfsat_test::read_recording(blocks, blocks.size());
  CHECK(ram.heads.size() == blocks.size());  // each is whole
  return ram;
}

// From a second before the release to four after it, without a gap, and with what it takes to read
// it.
void check_holds_drop(const Recording& ram, uint64_t released_us, uint32_t period_us) {
  const std::vector<uint64_t>& times_us = ram.sample_times_us;
  CHECK(!ram.headers.empty() && !times_us.empty());
  if (times_us.empty()) return;
  CHECK(ram.headers[0].accel_lsb_per_g == 2048.0f);
  CHECK(times_us.front() <= released_us - kRewriteBeforeReleaseUs);
  CHECK(times_us.back() >= released_us + kRewriteAfterReleaseUs);
  CHECK(times_us.back() - times_us.front() == (times_us.size() - 1) * period_us);
  const std::vector<Event> releases = events_of(ram, EventCode::kRelease);
  CHECK(releases.size() == 1 && releases[0].time_us == released_us);
}

void check_ram_is_kept_until_erased(Bench& bench) {
  CHECK(bench.recorder.ram_holds_drop() && !bench.recorder.capturing());
  const uint32_t samples = bench.recorder.samples();
  const uint32_t session = bench.recorder.session();
  bench.set_switches(0);
  bench.run_us(1000000);
  bench.card.gone_until_us = 0;
  bench.card.lost_contact = false;
  bench.card.open_error = ErrorCode::kNone;
  CHECK(bench.start(77, 700) == ErrorCode::kRamHoldsDrop);
  CHECK(bench.recorder.stop() == ErrorCode::kNone);
  bench.run_us(1000000);
  CHECK(bench.recorder.samples() == samples && bench.recorder.session() == session);
  CHECK(bench.recorder.state() == LoggerState::kFailed);
  bench.recorder.release_ram();
  CHECK(!bench.recorder.ram_holds_drop());
  CHECK(bench.start(78, 701) == ErrorCode::kNone);
  CHECK(bench.recorder.state() == LoggerState::kRecording);
  CHECK(bench.recorder.phase() == DropPhase::kWaiting);
  bench.run_us(500000);
  CHECK(bench.stop_and_read().heads.front().session == 701);
}

}  // namespace

TEST_CASE(a_drop_without_a_card_stays_in_ram) {
  for (const ErrorCode error : {ErrorCode::kNoCard, ErrorCode::kCardWriteProtected,
                                ErrorCode::kCardFull, ErrorCode::kCardUnreadable}) {
    for (const uint32_t period_us : {1000u, 3571u, 100000u}) {
      Bench bench;
      bench.period_us = period_us;
      bench.card.open_error = error;
      CHECK(bench.start(1, 11) == ErrorCode::kNone);
      CHECK(bench.recorder.state() == LoggerState::kFailed && bench.recorder.error() == error);
      const uint64_t released_us = bench.release_after_us(30000000);
      CHECK(!bench.recorder.ram_holds_drop());
      bench.run_us(kFallenUs);
      CHECK(bench.recorder.ram_holds_drop() && bench.recorder.capturing());
      CHECK(bench.start(2, 12) == ErrorCode::kRamHoldsDrop);
      bench.land();
      bench.run_us(kLongUs);
      check_holds_drop(ram_of(bench), released_us, period_us);
      check_ram_is_kept_until_erased(bench);
    }
  }
}

TEST_CASE(a_landing_that_nothing_shows_keeps_the_beginning_of_the_fall) {
  for (const uint32_t period_us : {1000u, 3571u}) {
    Bench bench;
    bench.period_us = period_us;
    bench.card.open_error = ErrorCode::kNoCard;
    bench.start(1, 11);
    const uint64_t released_us = bench.release_after_us(30000000);
    bench.run_us(kLongUs);
    check_holds_drop(ram_of(bench), released_us, period_us);
    CHECK(bench.recorder.ram_holds_drop() && !bench.recorder.capturing());
  }
}

// Before the release, in the fall and after it. What the card had taken safely may be gone from RAM
// when it was pulled after the landing.
TEST_CASE(a_card_pulled_in_flight_leaves_the_drop_in_ram) {
  for (const bool busy_when_gone : {false, true}) {
    for (const uint32_t period_us : {1000u, 3571u}) {
      for (int64_t pulled_us = -20000000; pulled_us < 4000000; pulled_us += 617000) {
        Bench bench;
        bench.period_us = period_us;
        bench.card.busy_when_gone = busy_when_gone;
        bench.card.write_us = 250;
        bench.start(1, 11);
        const uint64_t release_us = bench.t_us + 25000000;
        const auto run_to = [&bench](uint64_t end_us) {
          if (end_us > bench.t_us) bench.run_us(end_us - bench.t_us);
        };
        const auto pull_before = [&](uint64_t end_us) {
          const uint64_t pull_us = release_us + static_cast<uint64_t>(pulled_us);
          if (pull_us >= bench.t_us && pull_us < end_us) {
            run_to(pull_us);
            bench.card.gone_until_us = UINT64_MAX;
          }
          run_to(end_us);
        };
        pull_before(release_us);
        bench.set_switches(3);
        const uint64_t released_us = bench.t_us;
        pull_before(release_us + kFallenUs);
        bench.land();
        pull_before(release_us + 4000000);
        bench.run_us(kLongUs);
        CHECK(bench.recorder.state() == LoggerState::kFailed);
        CHECK(bench.recorder.samples_dropped() == 0);
        const bool notices_late = busy_when_gone && pulled_us > 3000000;
        if (notices_late && period_us == 1000) continue;
        check_holds_drop(ram_of(bench), released_us, period_us);
        CHECK(bench.recorder.ram_holds_drop() && !bench.recorder.capturing());
      }
    }
  }
}

TEST_CASE(a_card_pulled_in_flight_that_comes_back_gets_everything) {
  for (const uint32_t period_us : {1000u, 3571u}) {
    Bench bench;
    bench.period_us = period_us;
    bench.start(1, 11);
    const uint64_t released_us = bench.release_after_us(2000000);
    bench.run_us(100000);
    bench.card.gone_until_us = bench.t_us + 12000000;
    bench.run_us(kFallenUs - 100000);
    bench.land();
    bench.run_us(20000000);
    if (bench.recorder.state() == LoggerState::kRecording) bench.recorder.stop();
    const Recording recording = bench.wait_and_read();
    CHECK(recording.samples.size() == bench.recorder.samples());
    CHECK(recording.footers.at(0).samples_dropped == 0);
    CHECK(recording.footers[0].blocks_rewritten > 200);
    CHECK(recording.sample_times_us.back() >= released_us + kRewriteAfterReleaseUs);
    CHECK(!bench.recorder.ram_holds_drop());
    // At 1 kHz the recording ended so that RAM could keep the drop.
    const StopReason reason = period_us == 1000 ? StopReason::kCardGone : StopReason::kHost;
    CHECK(recording.footers[0].stop_reason == reason);
  }
}

TEST_CASE(a_card_that_fails_once_the_fall_is_on_it_twice_ends_nothing_early) {
  Bench bench;
  bench.period_us = 1000;
  bench.start(1, 11);
  bench.release_after_us(2000000);
  bench.run_us(kFallenUs);
  bench.land();
  bench.run_us(8000000);
  bench.card.gone_until_us = bench.t_us + 2000000;
  bench.run_us(4000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording && bench.recorder.capturing());
  CHECK(bench.stop_and_read().footers.at(0).samples_dropped == 0);
}

TEST_CASE(a_release_that_was_none_costs_no_ram) {
  Bench bench;
  bench.card.open_error = ErrorCode::kNoCard;
  bench.start(1, 11);
  bench.release_after_us(2000000);
  bench.run_us(500000);
  CHECK(bench.recorder.ram_holds_drop());
  bench.set_switches(0);
  bench.run_us(kLongUs);
  CHECK(!bench.recorder.ram_holds_drop() && bench.recorder.capturing());
  const uint64_t released_us = bench.release_after_us(1000000);
  bench.run_us(kFallenUs);
  bench.land();
  bench.run_us(kLongUs);
  check_holds_drop(ram_of(bench), released_us, bench.period_us);
  check_ram_is_kept_until_erased(bench);
}

TEST_CASE(a_stop_while_only_ram_records_keeps_what_there_is) {
  for (const bool released : {false, true}) {
    Bench bench;
    bench.card.open_error = ErrorCode::kNoCard;
    bench.start(1, 11);
    bench.run_us(3000000);
    if (released) bench.set_switches(3);
    bench.run_us(1000000);
    CHECK(bench.recorder.stop() == ErrorCode::kNone);
    bench.tick();
    CHECK(!bench.recorder.capturing() && bench.recorder.state() == LoggerState::kFailed);
    const Recording ram = ram_of(bench);
    CHECK(ram.samples.size() == bench.recorder.samples() && ram.footers.empty());
    CHECK(bench.recorder.ram_holds_drop() == released);
    CHECK(bench.start(2, 12) == (released ? ErrorCode::kRamHoldsDrop : ErrorCode::kNone));
  }
}

TEST_CASE(a_main_loop_that_is_away_for_a_second_costs_ram_nothing) {
  for (const uint32_t away_ms : {0u, 1000u, 2000u}) {
    Bench bench;
    bench.period_us = 1000;
    bench.card.open_error = ErrorCode::kNoCard;
    bench.start(1, 11);
    const uint64_t released_us = bench.release_after_us(10000000);
    for (uint32_t i = 0; i < 10000; ++i) {
      if (away_ms > 0 && i % away_ms != 0) {
        bench.interrupt();
      } else {
        bench.tick();
      }
      if (i == 2500) bench.peak_counts = Bench::kShockCounts;
    }
    check_holds_drop(ram_of(bench), released_us, 1000);
  }
}

// The loop meets a card that does not answer; meanwhile a knock ends and the robot is released.
TEST_CASE(a_release_behind_a_knock_that_the_main_loop_never_saw_is_the_one_that_is_kept) {
  for (const uint32_t knock_ms : {1000u, 3000u}) {
    Bench bench;
    bench.period_us = 1000;
    bench.card.open_error = ErrorCode::kNoCard;
    bench.start(1, 11);
    bench.release_after_us(5000000);
    bench.run_us(knock_ms * 1000);
    bench.set_switches(0);
    for (int i = 0; i < 500; ++i) bench.interrupt();
    bench.set_switches(3);
    const uint64_t released_us = bench.t_us;
    for (int i = 0; i < 100; ++i) bench.interrupt();
    bench.run_us(2500000);
    bench.land();
    bench.run_us(10000000);
    const Recording ram = ram_of(bench);
    CHECK(ram.sample_times_us.front() + kRewriteBeforeReleaseUs <= released_us);
    CHECK(ram.sample_times_us.back() >= released_us + kRewriteAfterReleaseUs);
  }
}
