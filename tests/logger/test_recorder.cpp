// Recordings: start and stop by number, full files, events, and power cuts at every block.
#include <vector>

#include "recorder_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::Recording;
using Bench = tfsat_test::RecorderBench;

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
  for (size_t i = 1; i < syncs.size(); ++i) {
    CHECK(syncs[i] - syncs[i - 1] < 1000 * kCardSyncMs + 30000);
  }
}

TEST_CASE(a_full_file_is_closed_cleanly) {
  Bench bench;
  bench.start(1, 1, 40);  // half of it is kept for a second copy of a fall
  bench.run_us(1000000);
  CHECK(bench.recorder.state() == LoggerState::kStopped);
  CHECK(bench.recorder.error() == ErrorCode::kCardFull);
  const Recording recording = tfsat_test::read_recording(bench.card.blocks, 40);
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

TEST_CASE(every_cut_leaves_a_readable_beginning) {
  Bench bench;
  bench.start(1, 1);
  bench.run_us(400000);
  const Recording complete = bench.stop_and_read();
  CHECK(complete.heads.size() > 15);
  for (size_t n = 1; n <= bench.card.blocks.size(); ++n) {
    std::vector<Block> cut(bench.card.blocks);
    cut.resize(n);
    cut.resize(256);                              // the rest of the file is zeros
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

TEST_CASE(a_file_is_prepared_ahead_of_its_blocks_and_in_a_fall_no_further) {
  Bench bench;
  bench.card.prepare_step = 16;
  bench.start(1, 1);
  bench.release_after_us(300000);
  bench.run_us(20000);
  const uint32_t prepared = bench.card.prepared;
  CHECK(prepared > 1000 && prepared < Bench::kFileBlocks);
  bench.run_us(2000000);
  CHECK(bench.card.prepared == prepared);
  const Recording recording = bench.stop_and_read();
  CHECK(recording.samples.size() == bench.recorder.samples());
  CHECK(bench.card.writes_unprepared == 0);
}

TEST_CASE(a_fall_right_after_the_start_is_given_the_room_that_it_needs) {
  Bench bench;
  bench.card.prepare_step = 16;
  bench.release_after_us(10000);
  bench.start(1, 1);
  bench.set_switches(0);
  bench.run_us(10000);
  bench.set_switches(3);
  bench.run_us(2000000);
  CHECK(bench.recorder.ring_blocks() < 64 && bench.card.writes > 64);
  CHECK(bench.card.writes_unprepared == 0 && bench.card.prepared < 600);
}
