// Recordings: start and stop by number, full files, events; cards that refuse, lose their contact for a while or
// for good.
#include <initializer_list>
#include <vector>

#include "recorder_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::RecorderBench;

TEST_CASE(a_recording_has_header_samples_and_footer) {
  Bench bench;
  CHECK(bench.recorder.state() == LoggerState::kIdle);
  CHECK(bench.start(7, 0xABCD) == ErrorCode::kNone);
  bench.run_us(1000000);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.heads.size() == bench.card.blocks().size());
  CHECK(recording.heads.front().kind == BlockKind::kHeader);
  CHECK(recording.heads.back().kind == BlockKind::kFooter);
  CHECK(recording.headers[0].who_am_i[0] == 0x68);
  CHECK(recording.samples.size() == bench.recorder.samples() && recording.samples.size() > 275);
  CHECK(recording.footers[0].samples == recording.samples.size());
  CHECK(recording.footers[0].blocks == bench.card.blocks().size());
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

TEST_CASE(a_start_that_the_card_refuses_records_in_ram_and_the_next_one_starts_anew) {
  Bench bench;
  bench.card.open_error = ErrorCode::kNoCard;
  CHECK(bench.start(5, 50) == ErrorCode::kNone);
  CHECK(bench.recorder.state() == LoggerState::kFailed && bench.recorder.session() == 50);
  CHECK(bench.recorder.error() == ErrorCode::kNoCard && bench.recorder.capturing());
  bench.run_us(100000);
  CHECK(bench.start(5, 51) == ErrorCode::kNone);  // a late copy
  CHECK(bench.recorder.session() == 50 && bench.card.opens == 1);
  bench.card.open_error = ErrorCode::kNone;
  CHECK(bench.start(6, 52) == ErrorCode::kNone);
  CHECK(bench.recorder.state() == LoggerState::kRecording);
  CHECK(bench.recorder.error() == ErrorCode::kNone);
  bench.run_us(100000);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.heads.front().session == 52 && recording.heads.front().block_number == 0);
  CHECK(recording.samples.size() == bench.recorder.samples());
}

TEST_CASE(the_card_is_synced_while_blocks_go_out) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(3000000);
  const std::vector<uint64_t>& syncs = bench.card.sync_times_us;
  CHECK(syncs.size() >= 10 && syncs.size() <= 13);
  int longer = 0;
  for (size_t i = 1; i < syncs.size(); ++i) {
    const uint64_t apart_us = syncs[i] - syncs[i - 1];
    longer += apart_us >= 1000 * kCardSyncMs + 30000;
    CHECK(apart_us < 1750 * kCardSyncMs + 30000);
  }
  CHECK(longer <= 1);  // where the file's preparation ends, its last turn comes before the blocks
}

TEST_CASE(a_full_file_is_closed_cleanly) {
  Bench bench;
  bench.start(1, 1, 40);  // half of it is kept for a second copy of a fall
  bench.run_us(1000000);
  CHECK(bench.recorder.state() == LoggerState::kStopped);
  CHECK(bench.recorder.error() == ErrorCode::kCardFull);
  const Recording recording = tfsat_test::read_recording(bench.card.blocks(), 40);
  CHECK(recording.heads.size() <= 20 && recording.heads.size() > 9);
  CHECK(recording.footers.size() == 1 && recording.footers[0].samples_dropped == 0);
  CHECK(recording.footers[0].stop_reason == StopReason::kFileFull);
}

// Events of a closing that the interrupt has not seen belong to no later recording.
TEST_CASE(nothing_of_a_recording_reaches_the_next) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(300000);
  bench.recorder.stop();
  bench.interrupt();
  bench.card.gone_until_us = bench.t_us + 200000;
  for (uint32_t t = 0; bench.recorder.state() == LoggerState::kStopping && t < 900000; t += 1000) {
    bench.recorder.poll(bench.t_us + t);
  }
  CHECK(bench.recorder.state() == LoggerState::kStopped);
  bench.start(2, 2);
  bench.t_us += 1000000;
  bench.run_us(300000);
  CHECK(bench.stop_and_read().events.empty());
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

TEST_CASE(a_file_is_prepared_ahead_of_its_blocks_and_in_a_fall_no_further) {
  Bench bench;
  bench.start(1, 1);
  bench.release_after_us(300000);
  bench.run_us(20000);
  const uint32_t prepared = bench.card.prepared_blocks();
  CHECK(prepared > 1000 && prepared < Bench::kFileBlocks);
  bench.run_us(2000000);
  CHECK(bench.card.prepared_blocks() == prepared);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.samples.size() == bench.recorder.samples());
  CHECK(bench.card.writes_unprepared == 0);
}

TEST_CASE(a_fall_right_after_the_start_is_given_the_room_that_it_needs) {
  Bench bench;
  bench.release_after_us(10000);
  bench.start(1, 1);
  bench.set_switches(0);
  bench.run_us(10000);
  bench.set_switches(3);
  bench.run_us(2000000);
  CHECK(bench.recorder.ring_blocks() < 64 && bench.card.writes > 64);
  CHECK(bench.card.writes_unprepared == 0 && bench.card.prepared_blocks() < 600);
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

// The jolt of the release may part the card from its contacts: what the ring can hold, 16 s at 280 Hz, must reach
// the card, what the card had taken and not yet programmed included.
TEST_CASE(a_card_without_contact_for_a_while_costs_no_sample) {
  for (const bool busy_when_gone : {false, true}) {
    for (const uint32_t gone_us : {300000u, 16000000u}) {
      for (const uint32_t before_us : {999000u, 1203000u}) {  // after the last sync
        Bench bench;
        bench.card.port.set_busy_when_gone(busy_when_gone);
        bench.start(1, 1);
        bench.run_us(before_us);
        const uint64_t gone_at_us = bench.t_us;
        bench.card.gone_until_us = gone_at_us + gone_us;
        bench.run_us(gone_us + 3000000);
        CHECK(bench.recorder.state() == LoggerState::kRecording && bench.card.recoveries > 0);
        const Recording recording = bench.stop_and_read();
        CHECK(bench.recorder.samples() > 280 * (before_us + gone_us + 2900000.0) / 1e6);
        CHECK(bench.kept_all(recording) && bench.card.writes_while_busy == 0);
        CHECK(recording.footers.size() == 1 && recording.heads.size() == bench.card.blocks().size());
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
  bench.card.device.stall_until(UINT64_MAX);
  bench.run_us(16000000);
  CHECK(bench.recorder.state() == LoggerState::kRecording);
  bench.run_us(1500000);
  CHECK(bench.recorder.state() == LoggerState::kFailed && bench.recorder.capturing());
  CHECK(bench.recorder.error() == ErrorCode::kCardWriteFailed);
  CHECK(bench.recorder.samples_dropped() == 0);
}

TEST_CASE(a_card_gone_for_good_does_not_stop_sampling_and_ram_keeps_the_newest) {
  for (const bool busy_when_gone : {false, true}) {
    Bench bench(1000);
    bench.card.port.set_busy_when_gone(busy_when_gone);
    bench.start(1, 21);
    bench.run_us(2000000);
    bench.card.gone_until_us = UINT64_MAX;
    bench.run_us(4000000);
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
    bench.card.gone_until_us = 0;
    CHECK(bench.start(2, 22) == ErrorCode::kNone);
    bench.run_us(100000);
    CHECK(bench.stop_and_read().heads.front().session == 22);
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
