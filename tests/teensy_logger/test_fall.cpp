// After the landing the fall is written a second time, and what no card has stays in RAM; whatever the card
// does, at no sample's cost.
#include <initializer_list>
#include <map>
#include <random>

#include "recorder_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::RecorderBench;

namespace {

constexpr uint64_t kLongUs = 60000000;

// Which blocks of a file stand there twice, byte by byte the same, and what is in them.
struct Copies {
  uint32_t blocks = 0;
  std::vector<uint64_t> sample_times_us;
  bool without_gap = true;
  bool from(uint64_t t_us) const { return !sample_times_us.empty() && sample_times_us[0] <= t_us; }
  bool to(uint64_t t_us) const { return !sample_times_us.empty() && sample_times_us.back() >= t_us; }
};

Copies copies_in(const std::vector<Block>& file) {
  Copies copies;
  std::map<uint32_t, const Block*> first;
  uint32_t before = 0;
  std::vector<Block> again;
  for (const Block& block : file) {
    BlockHeader head = {};
    CHECK(tfsat_test::whole(block, head));
    const auto added = first.emplace(head.block_number, &block);
    if (added.second) continue;
    CHECK(std::memcmp(added.first->second->bytes, block.bytes, sizeof block.bytes) == 0);
    if (copies.blocks++ > 0 && head.block_number != before + 1) copies.without_gap = false;
    before = head.block_number;
    again.push_back(block);
  }
  copies.sample_times_us = tfsat_test::read_recording(again, again.size()).sample_times_us;
  return copies;
}

// The recording is whole, and the fall is in it twice from `from_us` on.
Copies check_twice(const Bench& bench, const Recording& recording, uint64_t from_us) {
  const Copies copies = copies_in(bench.card.blocks());
  CHECK(bench.kept_all(recording) && recording.footers.at(0).blocks_rewritten == copies.blocks);
  CHECK(copies.from(from_us));
  return copies;
}

Recording ram_of(const Bench& bench) {
  const std::vector<Block> blocks = bench.ram();
  const Recording ram = tfsat_test::read_recording(blocks, blocks.size());
  CHECK(ram.heads.size() == blocks.size());  // each is whole
  return ram;
}

// From a second before the release to four after it, without a gap, and with what it takes to read it.
void check_ram_holds_drop(const Bench& bench, uint64_t released_us) {
  const Recording ram = ram_of(bench);
  const std::vector<uint64_t>& times_us = ram.sample_times_us;
  CHECK(!ram.headers.empty() && !times_us.empty());
  if (times_us.empty()) return;
  CHECK(ram.headers[0].accel_lsb_per_g == 2048.0f);
  CHECK(times_us.front() <= released_us - kRewriteBeforeReleaseUs);
  CHECK(times_us.back() >= released_us + kRewriteAfterReleaseUs);
  CHECK(times_us.back() - times_us.front() == (times_us.size() - 1) * bench.period_us);
  const std::vector<Event> releases = events_of(ram, EventCode::kRelease);
  CHECK(releases.size() == 1 && releases[0].time_us == released_us);
}

void check_ram_is_kept_until_erased(Bench& bench) {
  CHECK(bench.recorder.ram_holds_drop() && !bench.recorder.capturing());
  const uint32_t samples = bench.recorder.samples();
  const uint32_t session = bench.recorder.session();
  bench.set_switches(0);
  bench.run_us(1000000);
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

// A recorder at this period whose card takes a block in `write_us`; or that has none.
struct WithCard : Bench {
  explicit WithCard(uint32_t with_period_us, uint32_t write_us = 250) : Bench(with_period_us) {
    card.device.set_busy_us(write_us, 0);
    start(1, 11);
  }
};
struct Cardless : Bench {
  explicit Cardless(uint32_t with_period_us = kPeriodUs, ErrorCode error = ErrorCode::kNoCard)
      : Bench(with_period_us) {
    card.open_error = error;
    CHECK(start(1, 11) == ErrorCode::kNone);
    CHECK(recorder.state() == LoggerState::kFailed && recorder.error() == error);
  }
};

}  // namespace

TEST_CASE(the_fall_is_on_the_card_twice) {
  for (const uint32_t period_us : {1000u, 3571u, 100000u}) {
    WithCard bench(period_us);
    bench.card.device.set_busy_us(250, 1000);
    const uint64_t released_us = bench.drop(3000000, 4000000);
    const Recording recording = bench.stop_and_read();
    const Copies copies = check_twice(bench, recording, released_us - kRewriteBeforeReleaseUs);
    CHECK(copies.without_gap && !copies.from(released_us - 2 * kRewriteBeforeReleaseUs));
    CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 2 * kPartialBlockMs * 1000));
    CHECK(bench.card.writes_while_busy == 0);
    const std::vector<Event> told = events_of(recording, EventCode::kRewritten);
    CHECK(told.size() == 1 && told[0].value == static_cast<int>(copies.blocks));
    CHECK(recording.footers[0].stop_reason == StopReason::kHost);
    CHECK(events_of(recording, EventCode::kRelease).size() == 1);
    CHECK(events_of(recording, EventCode::kLanding).size() == 1);
  }
}

TEST_CASE(the_copy_waits_until_the_blow_is_over) {
  Bench bench;
  bench.start(1, 1);
  const uint64_t released_us = bench.release_after_us(2000000);
  bench.run_us(500000);
  bench.land();  // a shock in the fall, taken for the landing
  while (bench.t_us + bench.period_us < released_us + kRewriteAfterReleaseUs) {
    bench.tick();
    CHECK(bench.recorder.blocks_written() <= bench.recorder.samples() / 6 + 40);
  }
  const uint32_t before = bench.recorder.blocks_written();
  bench.run_us(1000000);
  CHECK(bench.recorder.blocks_written() > before + 200);
  bench.stop_and_read();
  CHECK(copies_in(bench.card.blocks()).to(released_us + kRewriteAfterReleaseUs - 50000));
}

// At 1 kHz the ring holds the drop and 0.3 s, so a stall then may cost some of the second before the release.
TEST_CASE(stalls_cost_the_second_copy_no_more_than_what_was_before_the_release) {
  std::mt19937 random(20260301);
  for (const uint32_t period_us : {1000u, 3571u}) {
    for (int round = 0; round < 6; ++round) {
      WithCard bench(period_us);
      const uint64_t released_us = bench.release_after_us(2000000);
      bool landed = false;
      for (const uint64_t end_us = released_us + 8000000; bench.t_us < end_us; bench.tick()) {
        if (random() % 200 == 0) bench.card.device.stall_until(bench.t_us + 50000 + random() % 450000);
        if (landed || bench.t_us < released_us + Bench::kFallenUs) continue;
        bench.land();
        landed = true;
      }
      const uint64_t from_us = period_us == 1000 ? released_us : released_us - kRewriteBeforeReleaseUs;
      const Copies copies = check_twice(bench, bench.stop_and_read(), from_us);
      CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 50000));
    }
  }
}

// The contact is lost, or the host stops, at any moment of the second copy.
TEST_CASE(a_second_copy_that_is_disturbed_is_whole_all_the_same) {
  for (const bool stopped : {false, true}) {
    for (const uint32_t period_us : {1000u, 3571u}) {
      for (uint32_t after_us = 0; after_us < 800000; after_us += 103000) {
        WithCard bench(period_us, stopped ? 900 : 250);
        const uint64_t released_us = bench.drop(2000000, 0);
        bench.run_to(released_us + kRewriteAfterReleaseUs + after_us);
        if (!stopped) {
          bench.card.gone_until_us = bench.t_us + 700000;
          bench.run_us(3000000);
        }
        const Copies copies = check_twice(bench, bench.stop_and_read(), released_us - 700000);
        CHECK(copies.without_gap);
        CHECK(stopped || copies.to(released_us + kRewriteAfterReleaseUs - 50000));
      }
    }
  }
}

// The interrupt may fill blocks while the main loop copies: only whole ones are copied.
TEST_CASE(blocks_that_are_overwritten_meanwhile_are_passed_over) {
  Bench bench(Bench::kPeriodUs, 64);  // 1.3 s at 280 Hz
  bench.card.device.set_busy_us(250, 0);
  bench.start(1, 1);
  bench.release_after_us(500000);
  bench.tick();
  for (int i = 0; i < 4000; ++i) {
    bench.interrupt();  // the main loop has less time than it would need
    if (i % 2 == 0) bench.recorder.poll(bench.t_us);
    if (i == 700) bench.peak_counts = Bench::kShockCounts;
  }
  const Recording recording = bench.stop_and_read();
  const Copies copies = copies_in(bench.card.blocks());  // checks that every block is whole
  CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
  CHECK(recording.samples.size() + bench.recorder.samples_dropped() == bench.recorder.samples());
}

// The lift ends ever later: with room for all, then with less than a drop needs.
TEST_CASE(where_the_file_ends_the_fall_comes_first) {
  constexpr uint32_t kFile = 2048;  // 1 MiB
  bool both = false, full = false;
  for (uint64_t lift_us = 1000000; lift_us < 7000000; lift_us += 187000) {
    Bench bench(1000);
    bench.after_landing_s = 5;
    bench.start(1, 1, kFile);
    const uint64_t released_us = bench.drop(lift_us, 6000000);
    if (bench.recorder.phase() == DropPhase::kWaiting) break;  // full before the release
    const Recording recording = bench.wait_and_read();
    const LogFooter& footer = recording.footers.at(0);
    const Copies copies = copies_in(bench.card.blocks());
    CHECK(bench.card.blocks().size() <= kFile && footer.blocks_rewritten == copies.blocks);
    const auto& times_us = recording.sample_times_us;
    CHECK(times_us.back() >= released_us + Bench::kFallenUs + 1000000);
    CHECK(recording.samples.size() == bench.recorder.samples() - footer.samples_dropped);
    CHECK(times_us.back() - times_us.front() == (times_us.size() - 1) * 1000);  // no gap
    both |= copies.from(released_us - kRewriteBeforeReleaseUs);
    full |= footer.stop_reason == StopReason::kFileFull;
  }
  CHECK(both && full);
}

TEST_CASE(a_recording_closes_by_itself_after_the_landing_and_not_before) {
  for (const uint16_t after_s : {uint16_t{5}, uint16_t{30}, uint16_t{600}}) {
    Bench bench(10000);
    bench.after_landing_s = after_s;
    bench.start(1, 1);
    bench.drop(2000000, 0);
    const uint64_t landed_us = bench.t_us;
    bench.run_us(after_s * 1000000u - 50000);
    CHECK(bench.recorder.state() == LoggerState::kRecording);
    bench.run_us(150000);
    CHECK(bench.recorder.state() != LoggerState::kRecording);
    const Recording recording = bench.wait_and_read();
    CHECK(recording.footers.at(0).stop_reason == StopReason::kLanding);
    CHECK(recording.sample_times_us.back() >= landed_us + after_s * 1000000u);
    CHECK(bench.recorder.error() == ErrorCode::kNone);
  }
}

// Whether or not a shock shows the landing.
TEST_CASE(a_drop_without_a_card_stays_in_ram) {
  for (const ErrorCode error : {ErrorCode::kNoCard, ErrorCode::kCardUnreadable}) {
    for (const uint32_t period_us : {1000u, 3571u, 100000u}) {
      for (const bool felt : {false, true}) {
        Cardless bench(period_us, error);
        const uint64_t released_us = bench.release_after_us(30000000);
        CHECK(!bench.recorder.ram_holds_drop());
        bench.run_us(Bench::kFallenUs);
        CHECK(bench.recorder.ram_holds_drop() && bench.recorder.capturing());
        CHECK(bench.start(2, 12) == ErrorCode::kRamHoldsDrop);
        if (felt) bench.land();
        bench.run_us(kLongUs);
        check_ram_holds_drop(bench, released_us);
        check_ram_is_kept_until_erased(bench);
      }
    }
  }
}

TEST_CASE(a_card_pulled_in_flight_that_comes_back_gets_everything) {
  for (const uint32_t period_us : {1000u, 3571u}) {
    WithCard bench(period_us, 0);
    const uint64_t released_us = bench.release_after_us(2000000);
    bench.run_us(100000);
    bench.card.gone_until_us = bench.t_us + 12000000;
    bench.run_us(Bench::kFallenUs - 100000);
    bench.land();
    bench.run_us(20000000);
    if (bench.recorder.state() == LoggerState::kRecording) bench.recorder.stop();
    const Recording recording = bench.wait_and_read();
    CHECK(bench.kept_all(recording) && recording.footers.at(0).samples_dropped == 0);
    CHECK(recording.footers[0].blocks_rewritten > 200);
    CHECK(recording.sample_times_us.back() >= released_us + kRewriteAfterReleaseUs);
    CHECK(!bench.recorder.ram_holds_drop());
    // At 1 kHz the recording ended so that RAM could keep the drop.
    const StopReason reason = period_us == 1000 ? StopReason::kCardGone : StopReason::kHost;
    CHECK(recording.footers[0].stop_reason == reason);
  }
}

TEST_CASE(a_card_that_fails_once_the_fall_is_on_it_twice_ends_nothing_early) {
  WithCard bench(1000, 0);
  bench.drop(2000000, 8000000);
  bench.card.gone_until_us = bench.t_us + 2000000;
  bench.run_us(4000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording && bench.recorder.capturing());
  CHECK(bench.stop_and_read().footers.at(0).samples_dropped == 0);
}

TEST_CASE(a_release_that_was_none_costs_no_ram) {
  Cardless bench;
  bench.release_after_us(2000000);
  bench.run_us(500000);
  CHECK(bench.recorder.ram_holds_drop());
  bench.set_switches(0);
  bench.run_us(kLongUs);
  CHECK(!bench.recorder.ram_holds_drop() && bench.recorder.capturing());
  const uint64_t released_us = bench.drop(1000000, kLongUs);
  check_ram_holds_drop(bench, released_us);
  check_ram_is_kept_until_erased(bench);
}

TEST_CASE(a_stop_while_only_ram_records_keeps_what_there_is) {
  for (const bool released : {false, true}) {
    Cardless bench;
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

TEST_CASE(a_main_loop_that_is_away_for_seconds_costs_ram_nothing) {
  for (const uint32_t away_ms : {1000u, 2000u}) {
    Cardless bench(1000);
    const uint64_t released_us = bench.release_after_us(10000000);
    for (uint32_t i = 0; i < 10000; ++i) {
      i % away_ms != 0 ? bench.interrupt() : bench.tick();
      if (i == 2500) bench.peak_counts = Bench::kShockCounts;
    }
    check_ram_holds_drop(bench, released_us);
  }
}

// The loop meets a card that does not answer; meanwhile a knock ends and the robot is released.
TEST_CASE(a_release_behind_a_knock_that_the_main_loop_never_saw_is_the_one_that_is_kept) {
  for (const uint32_t knock_ms : {1000u, 3000u}) {
    Cardless bench(1000);
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
