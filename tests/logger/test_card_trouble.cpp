// Cards that stall, refuse, lose their contact for a while or for good: what the ring holds is not
// lost.
#include <initializer_list>
#include <random>
#include <vector>

#include "recorder_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::RecorderBench;

TEST_CASE(stalls_cost_no_sample_and_are_logged) {
  std::mt19937 random(20240917);
  for (const uint32_t period_us : {3571u, 1000u}) {
    Bench bench;
    bench.period_us = period_us;
    bench.start(1, 1);
    for (int i = 0; i < 20000; ++i) {
      if (random() % 600 == 0) bench.card.busy_until_us = bench.t_us + 50000 + random() % 450000;
      bench.tick();
    }
    const Recording recording = bench.stop_and_read();
    CHECK(bench.recorder.samples_dropped() == 0);
    CHECK(recording.samples.size() == bench.recorder.samples());
    CHECK(bench.recorder.ring_peak_blocks() > 8);
    const std::vector<Event> stalls = events_of(recording, EventCode::kCardStall);
    CHECK(stalls.size() >= 10);
    int32_t longest_ms = 0;
    for (const Event& stall : stalls) {
      CHECK(stall.value >= 50 && stall.value < 600);
      longest_ms = stall.value > longest_ms ? stall.value : longest_ms;
    }
    CHECK(recording.footers[0].card_stall_max_ms == static_cast<uint32_t>(longest_ms));
  }
}

TEST_CASE(a_stall_longer_than_the_ring_drops_and_says_so) {
  Bench bench(8);
  bench.start(1, 1);
  bench.run_us(100000);
  bench.card.busy_until_us = bench.t_us + 900000;
  bench.run_us(1500000);
  const Recording recording = bench.stop_and_read();
  const uint32_t dropped = bench.recorder.samples_dropped();
  CHECK(dropped > 100);
  CHECK(recording.samples.size() + dropped == bench.recorder.samples());
  CHECK(recording.footers[0].samples_dropped == dropped);
  uint32_t noted = 0;
  for (const Event& event : recording.events) {
    if (event.code == EventCode::kSamplesDropped) noted += static_cast<uint32_t>(event.value);
  }
  CHECK(noted == dropped);
}

TEST_CASE(refused_writes_are_tried_again) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(200000);
  bench.card.failures_left = 5;
  bench.run_us(1000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording && bench.card.recoveries == 5);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.samples.size() == bench.recorder.samples());
}

// The jolt of the release may part the card from its contacts: what the ring can hold, 16 s at
// 280 Hz, must reach the card, what the card had taken and not yet programmed included.
TEST_CASE(a_card_without_contact_for_a_while_costs_no_sample) {
  for (const bool busy_when_gone : {false, true}) {
    for (const uint32_t gone_us : {300000u, 3000000u, 16000000u}) {
      for (const uint32_t before_us : {999000u, 1100000u, 1203000u}) {  // after the last sync
        Bench bench;
        bench.card.busy_when_gone = busy_when_gone;
        bench.start(1, 1);
        bench.run_us(before_us);
        const uint64_t gone_at_us = bench.t_us;
        bench.card.gone_until_us = gone_at_us + gone_us;
        bench.run_us(gone_us + 3000000);
        CHECK(bench.recorder.state() == LoggerState::kRecording && bench.card.recoveries > 0);
        const Recording recording = bench.stop_and_read();
        CHECK(bench.recorder.samples_dropped() == 0);
        CHECK(bench.recorder.samples() > 280 * (before_us + gone_us + 2900000.0) / 1e6);
        CHECK(recording.samples.size() == bench.recorder.samples());
        CHECK(recording.footers.size() == 1 && recording.heads.size() == bench.card.blocks.size());
        CHECK(bench.card.writes_while_busy == 0);
        const std::vector<Event> stalls = events_of(recording, EventCode::kCardStall);
        const std::vector<Event> lost = events_of(recording, EventCode::kCardLost);
        const std::vector<Event> back = events_of(recording, EventCode::kCardBack);
        CHECK(stalls.size() == 1 && lost.size() == 1 && back.size() == 1);
        const uint32_t noticed_ms = busy_when_gone ? 1150 : 150;
        CHECK(stalls[0].time_us + 30000 > gone_at_us && stalls[0].time_us < gone_at_us + 30000);
        CHECK(stalls[0].value * 1000 >= static_cast<int>(gone_us));
        CHECK(stalls[0].value < static_cast<int>(gone_us / 1000 + noticed_ms));
        CHECK(lost[0].time_us >= gone_at_us && lost[0].time_us < gone_at_us + noticed_ms * 1000);
        CHECK(lost[0].arg == static_cast<uint16_t>(ErrorCode::kCardWriteFailed));
        const uint64_t back_us = lost[0].time_us + 1000u * static_cast<uint32_t>(back[0].value);
        CHECK(back_us + 1000 > gone_at_us + gone_us && back[0].time_us < back_us + 1000);
        CHECK(recording.footers[0].card_stall_max_ms == static_cast<uint32_t>(stalls[0].value));
      }
    }
  }
}

TEST_CASE(a_card_without_contact_at_the_end_is_closed_when_it_is_back) {
  for (const uint32_t wait_ticks : {0u, 40u}) {  // before the stop, and before the closing
    Bench bench;
    bench.start(1, 1);
    bench.run_us(1000000);
    for (uint32_t i = 0; i < wait_ticks; ++i) bench.tick();
    bench.card.gone_until_us = bench.t_us + 2000000;
    const Recording recording = bench.stop_and_read();
    CHECK(recording.samples.size() == bench.recorder.samples());
    CHECK(recording.footers.size() == 1 && bench.card.closes == 1);
    CHECK(bench.recorder.ring_blocks() == 0);
  }
}

TEST_CASE(a_card_that_does_not_come_back_ends_the_closing_too) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(1000000);
  bench.card.gone_until_us = UINT64_MAX;
  CHECK(bench.recorder.stop() == ErrorCode::kNone);
  bench.run_us(CardWriter::kGiveUpUs + 200000);
  CHECK(bench.recorder.state() == LoggerState::kFailed);
}

TEST_CASE(a_card_that_refuses_the_preparation_is_tried_again) {
  Bench bench;
  bench.start(1, 1);
  bench.card.prepare_error = ErrorCode::kCardWriteFailed;
  bench.run_us(2000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording && bench.card.writes == 0);
  bench.card.prepare_error = ErrorCode::kNone;
  CHECK(bench.stop_and_read().samples.size() == bench.recorder.samples());
}

TEST_CASE(a_card_that_never_gets_ready_is_given_up_before_the_ring_is_full) {
  Bench bench;
  bench.start(1, 1);
  bench.card.busy_until_us = UINT64_MAX;
  bench.run_us(16000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording);
  bench.run_us(1500000);
  CHECK(bench.recorder.state() == LoggerState::kFailed && bench.recorder.capturing());
  CHECK(bench.recorder.error() == ErrorCode::kCardWriteFailed);
  CHECK(bench.recorder.samples_dropped() == 0);
}

TEST_CASE(a_card_gone_for_good_does_not_stop_sampling_and_ram_keeps_the_newest) {
  for (const uint32_t period_us : {3571u, 1000u}) {
    for (const bool busy_when_gone : {false, true}) {
      Bench bench;
      bench.period_us = period_us;
      bench.card.busy_when_gone = busy_when_gone;
      bench.start(1, 21);
      bench.run_us(2000000);
      bench.card.gone_until_us = UINT64_MAX;
      bench.run_us(period_us == 1000 ? 4000000 : 15000000);
      CHECK(bench.recorder.state() == LoggerState::kRecording);  // the ring has room
      bench.run_us(3000000);
      CHECK(bench.recorder.state() == LoggerState::kFailed && bench.recorder.capturing());
      CHECK(bench.recorder.error() == ErrorCode::kNoCard);
      bench.run_us(30000000);
      CHECK(bench.recorder.samples_dropped() == 0 && !bench.recorder.ram_holds_drop());
      CHECK(bench.recorder.stop() == ErrorCode::kNone);
      bench.tick();
      CHECK(bench.recorder.state() == LoggerState::kFailed && !bench.recorder.capturing());
      const std::vector<Block> kept = bench.ram();
      const Recording ram = tfsat_test::read_recording(kept, kept.size());
      CHECK(kept.size() == kRingBlocks - 1 && ram.heads.size() == kept.size());
      CHECK(ram.sample_indices.back() + 1 == bench.recorder.samples());
      const uint32_t samples = bench.recorder.samples();
      bench.run_us(100000);
      CHECK(bench.recorder.samples() == samples);
      bench.card.gone_until_us = 0;
      bench.card.lost_contact = false;
      CHECK(bench.start(2, 22) == ErrorCode::kNone);
      bench.run_us(100000);
      CHECK(bench.stop_and_read().heads.front().session == 22);
    }
  }
}

TEST_CASE(a_card_that_waits_for_the_ring_tells_of_each_quarter_once) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(500000);
  for (const uint32_t stall_us : {5000000u, 12000000u}) {
    bench.card.gone_until_us = bench.t_us + stall_us;
    bench.run_us(stall_us + 2000000);
  }
  const std::vector<Event> highs = events_of(bench.stop_and_read(), EventCode::kRingHighWater);
  CHECK(highs.size() == 2);
  for (uint16_t i = 0; i < highs.size(); ++i) {
    CHECK(highs[i].arg == i + 1);
    CHECK(highs[i].value == static_cast<int>(kRingBlocks / 4 * (i + 1)));
  }
}
