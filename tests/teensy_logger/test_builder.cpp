// Blocks: the golden bytes, filling, partial blocks, headers again and again, drops, the file's
// end.
#include <cstring>
#include <vector>

#include "../../firmware/teensy_logger/src/core/block_builder.h"
#include "check.h"
#include "golden_blocks.h"
#include "recording.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::Recording;

namespace {

constexpr uint32_t kSession = 0xC0FFEE;
constexpr uint64_t kUnixAtZeroUs = 1790000000000000u;

struct Bench {
  explicit Bench(uint32_t capacity, uint32_t max_blocks = 100000)
      : memory(capacity), ring(memory.data(), capacity), builder(ring) {
    LogHeader header = {};
    header.rate_hz = 280.0f;
    builder.begin(kSession, header, kUnixAtZeroUs, max_blocks);
  }
  void sample() {
    Sample sample = {};
    sample.flags = static_cast<uint16_t>(builder.samples());
    builder.add_sample(t_us, sample);
    t_us += 1000;
  }
  void drain() {
    for (; ring.front() != nullptr; ring.release()) card.push_back(*ring.front());
  }
  Recording recording() {
    drain();
    Recording result = tfsat_test::read_recording(card, card.size());
    CHECK(result.heads.size() == card.size());
    for (size_t i = 0; i < result.heads.size(); ++i) {
      CHECK(result.heads[i].block_number == i && result.heads[i].session == kSession);
    }
    return result;
  }

  std::vector<Block> memory;
  BlockRing ring;
  BlockBuilder builder;
  std::vector<Block> card;
  uint64_t t_us = 5000000000u;  // past 32 bits
};

Event event_at(uint64_t t_us, int32_t value) {
  Event event = {};
  event.time_us = t_us;
  event.code = EventCode::kStroke;
  event.value = value;
  return event;
}

}  // namespace

TEST_CASE(layout_gives_the_golden_blocks) {
  for (const tfsat_test::GoldenBlock& golden : tfsat_test::kGoldenBlocks) {
    Block block = {};
    golden.fill(block);
    CHECK(std::memcmp(block.bytes, golden.bytes, sizeof block.bytes) == 0);
  }
}

TEST_CASE(six_samples_fill_a_block_after_the_header) {
  Bench bench(8);
  for (int i = 0; i < 5; ++i) bench.sample();
  CHECK(bench.ring.waiting() == 1);  // the header; the samples are still being gathered
  bench.sample();
  const Recording recording = bench.recording();
  CHECK(recording.heads.size() == 2);
  CHECK(recording.heads[0].kind == BlockKind::kHeader);
  CHECK(recording.heads[1].kind == BlockKind::kData);
  CHECK(recording.headers[0].rate_hz == 280.0f);
  CHECK(recording.samples.size() == 6);
  for (uint16_t i = 0; i < 6; ++i) {
    CHECK(recording.samples[i].flags == i && recording.sample_indices[i] == i);
    CHECK(recording.sample_times_us[i] == 5000000000u + 1000u * i);
  }
}

TEST_CASE(a_partial_block_is_written_after_the_time_limit) {
  Bench bench(8);
  const uint64_t began_us = bench.t_us;
  bench.sample();
  bench.builder.flush_if_due(began_us + kPartialBlockMs * 1000 - 1);
  CHECK(bench.ring.waiting() == 1);
  bench.builder.flush_if_due(began_us + kPartialBlockMs * 1000);
  CHECK(bench.ring.waiting() == 2);
  bench.sample();
  bench.builder.flush();
  bench.builder.flush();  // nothing gathered: no empty block
  const Recording recording = bench.recording();
  CHECK(recording.heads.size() == 3);
  CHECK(recording.heads[1].sample_count == 1 && recording.heads[2].sample_count == 1);
  CHECK(recording.sample_indices[1] == 1);
}

TEST_CASE(a_third_event_begins_another_block) {
  Bench bench(8);
  bench.sample();
  for (int i = 0; i < 3; ++i) CHECK(bench.builder.add_event(event_at(bench.t_us + i, i)));
  bench.builder.flush();
  const Recording recording = bench.recording();
  CHECK(recording.heads.size() == 3);
  CHECK(recording.heads[1].event_count == 2 && recording.heads[2].event_count == 1);
  CHECK(recording.heads[2].sample_count == 0 && recording.heads[2].time_us == bench.t_us + 2);
  for (int i = 0; i < 3; ++i) CHECK(recording.events[static_cast<size_t>(i)].value == i);
}

TEST_CASE(the_header_comes_again) {
  Bench bench(8);
  while (bench.builder.blocks() < 3 * kHeaderRepeatBlocks + 2) {
    bench.sample();
    bench.drain();
  }
  const Recording recording = bench.recording();
  for (const BlockHeader& head : recording.heads) {
    const bool early = head.block_number == BlockBuilder::kEarlyHeaderBlock;
    const bool copy = early || head.block_number % kHeaderRepeatBlocks == 0;
    CHECK((head.kind == BlockKind::kHeader) == copy);
  }
  CHECK(recording.headers.size() == 5);
  size_t copy = 0;
  for (const BlockHeader& head : recording.heads) {
    if (head.kind != BlockKind::kHeader) continue;
    CHECK(recording.headers[copy++].wall_clock_us == kUnixAtZeroUs + head.time_us);
  }
}

TEST_CASE(a_clock_that_nobody_set_tells_nothing) {
  Bench bench(8);
  bench.builder.begin(kSession, LogHeader(), 0, 100);
  bench.sample();
  CHECK(bench.recording().headers[0].wall_clock_us == 0);
}

TEST_CASE(samples_that_find_no_room_are_counted_and_noted) {
  Bench bench(4);
  for (int i = 0; i < 18 + 10; ++i) bench.sample();  // header and three data blocks fit
  CHECK(bench.builder.samples() == 28 && bench.builder.samples_dropped() == 10);
  CHECK(!bench.builder.add_event(event_at(bench.t_us, 0)));
  const uint64_t first_lost_us = 5000000000u + 18 * 1000;
  bench.drain();
  for (int i = 0; i < 6; ++i) bench.sample();
  const Recording recording = bench.recording();
  CHECK(recording.samples.size() == 24);
  CHECK(recording.heads.back().first_sample == 28 && recording.heads.back().samples_dropped == 10);
  CHECK(recording.sample_indices[17] == 17 && recording.sample_indices[18] == 28);
  CHECK(recording.events.size() == 1);
  CHECK(recording.events[0].code == EventCode::kSamplesDropped && recording.events[0].value == 10);
  CHECK(recording.events[0].time_us == first_lost_us);
}

TEST_CASE(the_footer_always_finds_room_in_the_file) {
  Bench bench(64, 10);
  for (int i = 0; i < 100; ++i) bench.sample();
  CHECK(bench.builder.file_full() && bench.builder.blocks() == 9);
  bench.t_us += 77000;
  LogFooter known = {};
  known.card_stall_max_ms = 71;
  known.blocks_rewritten = 5;
  known.stop_reason = StopReason::kFileFull;
  CHECK(bench.builder.add_footer(bench.t_us, known));
  const Recording recording = bench.recording();
  CHECK(recording.heads.size() == 10 && recording.heads.back().kind == BlockKind::kFooter);
  CHECK(recording.samples.size() == 7 * 6 && recording.headers.size() == 2);
  const LogFooter& footer = recording.footers.at(0);
  CHECK(footer.samples == 100 && footer.samples_dropped == 58 && footer.blocks == 10);
  CHECK(footer.interval_min_us == 1000 && footer.interval_max_us == 1000);
  CHECK(footer.ring_peak_blocks == 9 && footer.ring_blocks == 64);
  CHECK(footer.card_stall_max_ms == 71 && footer.blocks_rewritten == 5);
  CHECK(footer.stop_reason == StopReason::kFileFull && footer.late_ticks == 0);
  CHECK_NEAR(footer.jitter_rms_us, 1e6 / 280 - 1000, 0.01);  // the bench samples at 1 kHz
}

TEST_CASE(room_in_the_file_is_given_away_but_not_what_is_needed_next) {
  Bench bench(64, 40);
  for (int i = 0; i < 60; ++i) bench.sample();
  const uint32_t made = bench.builder.blocks();
  CHECK(bench.builder.room() == 40 - made - 1);
  CHECK(bench.builder.give_room(5) == 5 && bench.builder.room() == 40 - made - 1 - 5);
  CHECK(bench.builder.give_room(100) == 40u - made - 1 - 5 - 4 && bench.builder.room() == 4);
  CHECK(bench.builder.give_room(100) == 0);
  for (int i = 0; i < 100; ++i) bench.sample();
  CHECK(bench.builder.file_full() && bench.builder.blocks() == made + 4);
  bench.builder.add_room(1);
  for (int i = 0; i < 100; ++i) bench.sample();
  CHECK(bench.builder.blocks() == made + 5);
}
