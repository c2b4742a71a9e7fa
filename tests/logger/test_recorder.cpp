// Recordings: start and stop by number, stalls, a card that fails, and power cuts at every block.
#include <random>
#include <vector>

#include "../../firmware/teensy_logger/src/core/recorder.h"
#include "card_image.h"
#include "check.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::FakeCard;
using tfsat_test::Recording;

namespace {

constexpr uint32_t kFileBlocks = 4096;

struct Bench {
  explicit Bench(uint32_t ring_blocks = kRingBlocks)
      : memory(ring_blocks), recorder(memory.data(), ring_blocks, card) {}

  ErrorCode start(uint32_t number, uint32_t session, uint32_t file_blocks = kFileBlocks) {
    LogHeader header = {};
    header.who_am_i[0] = 0x68;
    return recorder.start(number, session, header, file_blocks);
  }
  // One sampling period: the interrupt, then some passes of the main loop.
  void tick(uint32_t period_us = 3571) {
    t_us += period_us;
    Event event;
    while (recorder.take_card_event(event)) events.push(event);
    recorder.capture(t_us, Sample(), events);
    for (uint32_t pass = 0; pass < 4; ++pass) recorder.poll(t_us + pass * period_us / 5);
  }
  void run_us(uint64_t duration_us, uint32_t period_us = 3571) {
    for (const uint64_t end_us = t_us + duration_us; t_us < end_us;) tick(period_us);
  }
  Recording stop_and_read() {
    CHECK(recorder.stop() == ErrorCode::kNone);
    for (int i = 0; i < 2000 && recorder.state() == LoggerState::kStopping; ++i) tick();
    CHECK(recorder.state() == LoggerState::kStopped);
    return tfsat_test::read_recording(card.blocks, card.blocks.size());
  }

  std::vector<Block> memory;
  FakeCard card;
  Recorder recorder;
  EventQueue events;
  uint64_t t_us = 1000000;
};

}  // namespace

TEST_CASE(a_recording_has_header_samples_and_footer) {
  Bench bench;
  CHECK(bench.recorder.state() == LoggerState::kIdle);
  CHECK(bench.start(7, 0xABCD) == ErrorCode::kNone);
  bench.run_us(1000000);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.heads.size() == bench.card.blocks.size());
  CHECK(recording.heads.front().kind == BlockKind::kHeader);
  CHECK(recording.heads.back().kind == BlockKind::kFooter);
  CHECK(recording.headers[0].who_am_i[0] == 0x68);
  CHECK(recording.samples.size() == bench.recorder.samples() && recording.samples.size() > 275);
  CHECK(recording.footers[0].samples == recording.samples.size());
  CHECK(recording.footers[0].blocks == bench.card.blocks.size());
  CHECK(recording.footers[0].interval_min_us == 3571);
  CHECK(recording.footers[0].interval_max_us == 3571);
  CHECK(bench.recorder.samples_dropped() == 0 && bench.card.writes_while_busy == 0);
  for (const BlockHeader& head : recording.heads) CHECK(head.session == 0xABCD);
}

TEST_CASE(start_is_idempotent_by_number) {
  Bench bench;
  CHECK(bench.recorder.stop() == ErrorCode::kNotRecording);
  CHECK(!bench.recorder.knows(0));
  CHECK(bench.start(0, 11) == ErrorCode::kNone);
  bench.tick();
  CHECK(bench.start(0, 12) == ErrorCode::kNone);
  CHECK(bench.card.opens == 1 && bench.recorder.session() == 11);
  CHECK(bench.start(1, 13) == ErrorCode::kWrongState);
  CHECK(bench.recorder.session() == 11 && bench.recorder.state() == LoggerState::kRecording);
  bench.stop_and_read();
  CHECK(bench.recorder.stop() == ErrorCode::kNone);
  CHECK(bench.start(0, 14) == ErrorCode::kNone);  // a late copy of the first start
  CHECK(bench.recorder.state() == LoggerState::kStopped && bench.card.opens == 1);
  CHECK(bench.start(2, 15) == ErrorCode::kNone);
  CHECK(bench.recorder.session() == 15 && bench.recorder.state() == LoggerState::kRecording);
  bench.run_us(100000);
  const Recording second = bench.stop_and_read();
  CHECK(second.heads.front().block_number == 0 && second.heads.front().session == 15);
  CHECK(bench.card.closes == 2);
}

TEST_CASE(a_start_that_the_card_refuses_uses_up_no_number) {
  Bench bench;
  bench.card.open_error = ErrorCode::kNoCard;
  CHECK(bench.start(5, 50) == ErrorCode::kNoCard);
  CHECK(bench.recorder.state() == LoggerState::kFailed);
  CHECK(bench.recorder.error() == ErrorCode::kNoCard);
  bench.card.open_error = ErrorCode::kNone;
  CHECK(bench.start(5, 51) == ErrorCode::kNone);
  CHECK(bench.recorder.state() == LoggerState::kRecording);
  CHECK(bench.recorder.error() == ErrorCode::kNone);
}

TEST_CASE(stalls_cost_no_sample_and_are_logged) {
  std::mt19937 random(20240917);
  for (const uint32_t period_us : {3571u, 1000u}) {
    Bench bench;
    bench.start(1, 1, 65536);
    for (int i = 0; i < 20000; ++i) {
      if (random() % 600 == 0) bench.card.busy_until_us = bench.t_us + 50000 + random() % 450000;
      bench.tick(period_us);
    }
    const Recording recording = bench.stop_and_read();
    CHECK(bench.recorder.samples_dropped() == 0);
    CHECK(recording.samples.size() == bench.recorder.samples());
    CHECK(bench.recorder.ring_peak_blocks() > 8);
    size_t stalls = 0;
    for (const Event& event : recording.events) {
      if (event.code != EventCode::kCardStall) continue;
      ++stalls;
      CHECK(event.value >= 50 && event.value < 600);
    }
    CHECK(stalls >= 10);
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

TEST_CASE(the_card_is_synced_while_blocks_go_out) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(3000000);
  const std::vector<uint64_t>& syncs = bench.card.sync_times_us;
  CHECK(syncs.size() >= 10 && syncs.size() <= 13);
  for (size_t i = 1; i < syncs.size(); ++i) {
    CHECK(syncs[i] - syncs[i - 1] < 1000 * kCardSyncMs + 30000);
  }
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

// The jolt of the release may part the card from its contacts: what the ring can hold, 10.9 s at
// 280 Hz, must reach the card, what the card had taken and not yet programmed included.
TEST_CASE(a_card_without_contact_for_a_while_costs_no_sample) {
  for (const bool busy_when_gone : {false, true}) {
    for (const uint32_t gone_us : {300000u, 3000000u, 9000000u}) {
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
        uint32_t stalls = 0;
        for (const Event& event : recording.events) {
          if (event.code != EventCode::kCardStall) continue;
          ++stalls;
          CHECK(event.time_us + 30000 > gone_at_us && event.time_us < gone_at_us + 30000);
          const uint32_t noticed_ms = busy_when_gone ? 1150 : 150;
          CHECK(event.value * 1000 >= static_cast<int>(gone_us));
          CHECK(event.value < static_cast<int>(gone_us / 1000 + noticed_ms));
        }
        CHECK(stalls == 1);
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
  bench.card.poll_error = ErrorCode::kCardWriteFailed;
  bench.run_us(2000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording && bench.card.writes == 0);
  bench.card.poll_error = ErrorCode::kNone;
  CHECK(bench.stop_and_read().samples.size() == bench.recorder.samples());
}

TEST_CASE(a_card_gone_for_good_does_not_stop_sampling) {
  for (const bool busy_when_gone : {false, true}) {
    Bench bench;
    bench.card.busy_when_gone = busy_when_gone;
    bench.start(1, 21);
    bench.run_us(2000000);
    bench.card.gone_until_us = UINT64_MAX;
    bench.run_us(10000000);
    CHECK(bench.recorder.state() == LoggerState::kRecording);  // the ring has room
    bench.run_us(2000000);
    CHECK(bench.recorder.state() == LoggerState::kFailed);
    CHECK(bench.recorder.error() == ErrorCode::kNoCard);
    CHECK(bench.recorder.samples() > 3900);
    CHECK(bench.recorder.ring_blocks() == kRingBlocks);
    const Recording recording = tfsat_test::read_recording(bench.card.blocks, kFileBlocks);
    CHECK(recording.samples.size() > 480);  // all but what was not yet synced
    const size_t kept = recording.samples.size() + kRingBlocks * kSamplesPerBlock;
    CHECK(kept + bench.recorder.samples_dropped() >= bench.recorder.samples());
    CHECK(bench.recorder.stop() == ErrorCode::kNone);
    CHECK(bench.recorder.state() == LoggerState::kFailed);
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

TEST_CASE(a_full_file_is_closed_cleanly) {
  Bench bench;
  bench.start(1, 1, 20);
  bench.run_us(1000000);
  CHECK(bench.recorder.state() == LoggerState::kStopped);
  CHECK(bench.recorder.error() == ErrorCode::kCardFull);
  const Recording recording = tfsat_test::read_recording(bench.card.blocks, 20);
  CHECK(recording.heads.size() == 20 && recording.footers.size() == 1);
}

TEST_CASE(every_cut_leaves_a_readable_beginning) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(400000);
  const Recording complete = bench.stop_and_read();
  CHECK(complete.heads.size() > 15);
  for (size_t n = 1; n <= bench.card.blocks.size(); ++n) {
    std::vector<Block> cut(bench.card.blocks);
    cut.resize(n);
    cut.resize(kFileBlocks);  // the rest of the file is zeros
    std::memset(cut[n - 1].bytes + 256, 0, 256);  // and the last block is torn
    const Recording recording = tfsat_test::read_recording(cut, cut.size());
    CHECK(recording.heads.size() == n - 1);
    for (size_t i = 0; i < recording.sample_indices.size(); ++i) {
      CHECK(recording.sample_indices[i] == i);
    }
    CHECK(n == 1 || !recording.headers.empty());
  }
}

TEST_CASE(events_of_a_chattering_input_all_arrive_and_samples_stay) {
  Bench bench;
  bench.start(1, 1);
  bench.tick();
  for (int i = 0; i < 60; ++i) {
    Event event = {};
    event.time_us = bench.t_us;
    event.code = EventCode::kSwitchEdge;
    event.value = i;
    CHECK(bench.events.push(event));
  }
  bench.tick();
  const Recording recording = bench.stop_and_read();
  CHECK(recording.events.size() == 60);
  for (size_t i = 0; i < recording.events.size(); ++i) {
    CHECK(recording.events[i].value == static_cast<int>(i));
  }
  CHECK(recording.samples.size() == bench.recorder.samples());
}
