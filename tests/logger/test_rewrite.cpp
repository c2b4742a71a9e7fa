// After the landing the fall is written a second time, and after a while the recording closes by
// itself; whatever the card does, at no sample's cost.
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

constexpr uint64_t kFallenUs = 2500000;

// Which blocks of a file stand there twice, byte by byte the same, and what is in them.
struct Copies {
  uint32_t blocks = 0;
  std::vector<uint64_t> sample_times_us;
  bool without_gap = true;
  bool from(uint64_t t_us) const { return !sample_times_us.empty() && sample_times_us[0] <= t_us; }
  bool to(uint64_t t_us) const {
    return !sample_times_us.empty() && sample_times_us.back() >= t_us;
  }
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

// Lift, release, fall, landing, and some seconds more; the release's time.
uint64_t drop(Bench& bench, uint64_t lift_us = 3000000, uint64_t then_us = 4000000) {
  const uint64_t released_us = bench.release_after_us(lift_us);
  bench.run_us(kFallenUs);
  bench.land();
  bench.run_us(then_us);
  return released_us;
}

}  // namespace

TEST_CASE(the_fall_is_on_the_card_twice) {
  for (const uint32_t period_us : {1000u, 3571u, 100000u}) {
    Bench bench;
    bench.period_us = period_us;
    bench.card.write_us = 250;
    bench.card.sync_us = 1000;
    bench.start(1, 1);
    const uint64_t released_us = drop(bench);
    const Recording recording = bench.stop_and_read();
    const Copies copies = copies_in(bench.card.blocks);
    CHECK(copies.without_gap);
    CHECK(copies.from(released_us - kRewriteBeforeReleaseUs));
    CHECK(!copies.from(released_us - 2 * kRewriteBeforeReleaseUs));
    CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 2 * kPartialBlockMs * 1000));
    CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
    CHECK(recording.samples.size() == bench.recorder.samples());
    CHECK(bench.recorder.samples_dropped() == 0 && bench.card.writes_while_busy == 0);
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
  CHECK(copies_in(bench.card.blocks).to(released_us + kRewriteAfterReleaseUs - 50000));
}

// At 1 kHz the ring has lost the beginning by the time that is taken for the landing.
TEST_CASE(a_landing_that_nothing_shows_is_not_waited_for_until_it_is_too_late) {
  for (const uint32_t period_us : {1000u, 3571u}) {
    Bench bench;
    bench.period_us = period_us;
    bench.card.write_us = 250;
    bench.start(1, 1);
    const uint64_t released_us = bench.release_after_us(3000000);
    bench.run_us(9000000);
    bench.stop_and_read();
    const Copies copies = copies_in(bench.card.blocks);
    CHECK(copies.from(released_us - kRewriteBeforeReleaseUs) && copies.without_gap);
    CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 50000));
  }
}

// At 1 kHz the ring holds the drop and 0.3 s, so a stall then may cost some of the second before
// the release.
TEST_CASE(stalls_cost_the_second_copy_no_more_than_what_was_before_the_release) {
  std::mt19937 random(20260301);
  for (const uint32_t period_us : {1000u, 3571u}) {
    for (int round = 0; round < 12; ++round) {
      Bench bench;
      bench.period_us = period_us;
      bench.card.write_us = 250;
      bench.start(1, 1);
      const uint64_t released_us = bench.release_after_us(2000000);
      const uint64_t end_us = released_us + 8000000;
      for (bool landed = false; bench.t_us < end_us; bench.tick()) {
        if (random() % 200 == 0) bench.card.busy_until_us = bench.t_us + 50000 + random() % 450000;
        if (landed || bench.t_us < released_us + kFallenUs) continue;
        bench.land();
        landed = true;
      }
      const Recording recording = bench.stop_and_read();
      const Copies copies = copies_in(bench.card.blocks);
      CHECK(copies.from(period_us == 1000 ? released_us : released_us - kRewriteBeforeReleaseUs));
      CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 50000));
      CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
      CHECK(bench.recorder.samples_dropped() == 0);
      CHECK(recording.samples.size() == bench.recorder.samples());
    }
  }
}

TEST_CASE(a_card_that_loses_contact_in_the_second_copy_gets_it_whole) {
  for (const uint32_t period_us : {1000u, 3571u}) {
    for (uint32_t after_us = 0; after_us < 900000; after_us += 53000) {
      Bench bench;
      bench.period_us = period_us;
      bench.card.write_us = 250;
      bench.start(1, 1);
      const uint64_t released_us = bench.release_after_us(2000000);
      bench.run_us(kFallenUs);
      bench.land();
      bench.run_us(released_us + kRewriteAfterReleaseUs + after_us - bench.t_us);
      bench.card.gone_until_us = bench.t_us + 700000;
      bench.run_us(3000000);
      const Recording recording = bench.stop_and_read();
      const Copies copies = copies_in(bench.card.blocks);
      CHECK(copies.without_gap && copies.from(released_us - 700000));
      CHECK(copies.to(released_us + kRewriteAfterReleaseUs - 50000));
      CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
      CHECK(recording.samples.size() == bench.recorder.samples());
      CHECK(bench.recorder.samples_dropped() == 0);
    }
  }
}

TEST_CASE(a_stop_in_the_second_copy_lets_it_end) {
  for (uint32_t after_us = 0; after_us < 600000; after_us += 31000) {
    Bench bench;
    bench.card.write_us = 900;
    bench.start(1, 1);
    const uint64_t released_us = bench.release_after_us(2000000);
    bench.run_us(kFallenUs);
    bench.land();
    bench.run_us(released_us + kRewriteAfterReleaseUs + 10000 + after_us - bench.t_us);
    const Recording recording = bench.stop_and_read();
    const Copies copies = copies_in(bench.card.blocks);
    CHECK(copies.without_gap && copies.from(released_us - kRewriteBeforeReleaseUs));
    CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
    CHECK(recording.samples.size() == bench.recorder.samples());
  }
}

// The interrupt may fill blocks while the main loop copies: only whole ones are copied.
TEST_CASE(blocks_that_are_overwritten_meanwhile_are_passed_over) {
  Bench bench(64);  // 1.3 s at 280 Hz
  bench.card.write_us = 250;
  bench.start(1, 1);
  bench.release_after_us(500000);
  bench.tick();
  for (int i = 0; i < 4000; ++i) {
    bench.interrupt();  // the main loop has less time than it would need
    if (i % 2 == 0) bench.recorder.poll(bench.t_us);
    if (i == 700) bench.peak_counts = Bench::kShockCounts;
  }
  const Recording recording = bench.stop_and_read();
  const Copies copies = copies_in(bench.card.blocks);  // checks that every block is whole
  CHECK(recording.footers.at(0).blocks_rewritten == copies.blocks);
  CHECK(recording.samples.size() + bench.recorder.samples_dropped() == bench.recorder.samples());
}

// The lift ends ever later: with room for all, then with less than a drop needs.
TEST_CASE(where_the_file_ends_the_fall_comes_first) {
  constexpr uint32_t kFile = 2048;  // 1 MiB
  bool both = false, full = false;
  for (uint64_t lift_us = 1000000; lift_us < 7000000; lift_us += 187000) {
    Bench bench;
    bench.period_us = 1000;
    bench.after_landing_s = 5;
    bench.start(1, 1, kFile);
    const uint64_t released_us = drop(bench, lift_us, 6000000);
    if (bench.recorder.phase() == DropPhase::kWaiting) break;  // full before the release
    const Recording recording = bench.wait_and_read();
    const LogFooter& footer = recording.footers.at(0);
    const Copies copies = copies_in(bench.card.blocks);
    CHECK(bench.card.blocks.size() <= kFile && footer.blocks_rewritten == copies.blocks);
    CHECK(recording.sample_times_us.back() >= released_us + kFallenUs + 1000000);
    CHECK(recording.samples.size() == bench.recorder.samples() - footer.samples_dropped);
    const auto& times_us = recording.sample_times_us;
    CHECK(times_us.back() - times_us.front() == (times_us.size() - 1) * 1000);  // no gap
    both |= copies.from(released_us - kRewriteBeforeReleaseUs);
    full |= footer.stop_reason == StopReason::kFileFull;
  }
  CHECK(both && full);
}

TEST_CASE(the_factory_s_file_has_room_for_both) {
  Bench bench;
  bench.start(1, 1, 65536);
  const uint64_t released_us = drop(bench, 60000000, 6000000);
  bench.stop_and_read();
  CHECK(copies_in(bench.card.blocks).from(released_us - kRewriteBeforeReleaseUs));
}

TEST_CASE(a_recording_closes_by_itself_after_the_landing_and_not_before) {
  for (const uint16_t after_s : {uint16_t{5}, uint16_t{30}, uint16_t{600}}) {
    Bench bench;
    bench.period_us = 10000;
    bench.after_landing_s = after_s;
    bench.start(1, 1);
    bench.release_after_us(2000000);
    bench.run_us(kFallenUs);
    bench.land();
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

TEST_CASE(a_knock_closes_nothing_and_a_reseated_robot_is_recorded_on) {
  for (const bool reseated : {false, true}) {
    Bench bench;
    bench.after_landing_s = 5;
    bench.start(1, 1);
    bench.release_after_us(2000000);
    bench.set_switches(0);  // a knock
    bench.run_us(20000000);
    CHECK(bench.recorder.state() == LoggerState::kRecording);
    drop(bench, 0, 1000000);
    CHECK(bench.recorder.phase() == DropPhase::kLanded);
    if (reseated) bench.set_switches(0);
    bench.run_us(8000000);
    CHECK(bench.recorder.state() == LoggerState::kStopped);
    CHECK(bench.recorder.wants_next_file() == reseated);
  }
}
