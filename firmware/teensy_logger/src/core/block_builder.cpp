#include "block_builder.h"

#include <string.h>

#include "block_layout.h"

namespace tfsat {
namespace logger {

using protocol::BlockHeader;
using protocol::BlockKind;
using protocol::Event;
using protocol::kEventsPerBlock;
using protocol::kSamplesPerBlock;
using protocol::Sample;

namespace {

// Only the producer counts, so a plain load and store make an increment.
void increment(std::atomic<uint32_t>& counter) {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

void BlockBuilder::begin(uint32_t session, const protocol::LogHeader& header,
                         uint64_t unix_at_zero_us, uint32_t max_blocks) {
  ring_.reset();
  session_ = session;
  header_ = header;
  unix_at_zero_us_ = unix_at_zero_us;
  max_blocks_ = max_blocks;
  block_ = nullptr;
  drops_to_note_ = 0;
  intervals_.reset(header.rate_hz);
  samples_ = 0;
  dropped_ = 0;
  blocks_ = 0;
}

// The interrupt may be about to fill a block, and a header before it.
uint32_t BlockBuilder::give_room(uint32_t wanted) {
  constexpr uint32_t kSoon = 4;
  const uint32_t free = room() > kSoon ? room() - kSoon : 0;
  const uint32_t given = wanted < free ? wanted : free;
  max_blocks_ = max_blocks_ - given;
  return given;
}

void BlockBuilder::add_sample(uint64_t t_us, Sample sample) {
  intervals_.add(t_us);
  if (block_ == nullptr && open(t_us) == nullptr) {
    drop_sample(t_us);
    return;
  }
  if (block_samples_ == 0) {
    block_time_us_ = t_us;
    first_sample_ = samples();
  }
  sample.time_offset_us = static_cast<uint32_t>(t_us - block_time_us_);
  put_sample(*block_, block_samples_++, sample);
  increment(samples_);
  if (block_samples_ == kSamplesPerBlock) flush();
}

void BlockBuilder::drop_sample(uint64_t t_us) {
  if (drops_to_note_++ == 0) first_dropped_us_ = t_us;
  increment(samples_);
  increment(dropped_);
}

bool BlockBuilder::add_event(const Event& event) {
  if (block_ != nullptr && block_events_ == kEventsPerBlock) flush();
  if (block_ == nullptr && open(event.time_us) == nullptr) return false;
  append_event(event);
  return true;
}

void BlockBuilder::append_event(const Event& event) {
  if (block_samples_ == 0 && block_events_ == 0) block_time_us_ = event.time_us;
  put_event(*block_, block_events_++, event);
}

void BlockBuilder::flush_if_due(uint64_t t_us) {
  if (block_ != nullptr && t_us - opened_us_ >= protocol::kPartialBlockMs * 1000) flush();
}

void BlockBuilder::flush() {
  if (block_ == nullptr) return;
  close(*block_, BlockKind::kData, block_time_us_);
  block_ = nullptr;
}

bool BlockBuilder::add_footer(uint64_t t_us, protocol::LogFooter footer) {
  Block* block = ring_.acquire();
  if (block == nullptr) return false;
  first_sample_ = samples();
  block_samples_ = 0;
  block_events_ = 0;
  footer.samples = samples();
  footer.samples_dropped = samples_dropped();
  footer.blocks = blocks() + 1;
  footer.ring_peak_blocks = ring_.peak();
  footer.ring_blocks = ring_.capacity();
  footer.interval_min_us = intervals_.min_us();
  footer.interval_max_us = intervals_.max_us();
  footer.jitter_rms_us = intervals_.rms_us();
  footer.late_ticks = intervals_.late();
  put_whole(*block, BlockKind::kFooter, footer, t_us);
  return true;
}

// Begins a data block; nullptr when the ring or the file has no room.
Block* BlockBuilder::open(uint64_t t_us) {
  if (!put_header_if_due(t_us) || file_full()) return nullptr;
  block_ = ring_.acquire();
  if (block_ == nullptr) return nullptr;
  memset(block_->bytes, 0, sizeof block_->bytes);
  opened_us_ = t_us;
  block_time_us_ = t_us;
  first_sample_ = samples();
  block_samples_ = 0;
  block_events_ = 0;
  note_drops();
  return block_;
}

void BlockBuilder::note_drops() {
  if (drops_to_note_ == 0) return;
  Event event = {};
  event.time_us = first_dropped_us_;
  event.code = protocol::EventCode::kSamplesDropped;
  event.value = static_cast<int32_t>(drops_to_note_);
  append_event(event);
  drops_to_note_ = 0;
}

// Block 0, kEarlyHeaderBlock and each multiple of kHeaderRepeatBlocks. False when it found no room:
// without a header at its front, a recording could not be read, so nothing else is written before
// it. Every data block begins here, so no number is passed over.
bool BlockBuilder::put_header_if_due(uint64_t t_us) {
  const bool due = blocks() == kEarlyHeaderBlock || blocks() % protocol::kHeaderRepeatBlocks == 0;
  if (!due) return true;
  if (file_full()) return false;
  Block* block = ring_.acquire();
  if (block == nullptr) return false;
  first_sample_ = samples();
  block_samples_ = 0;
  block_events_ = 0;
  header_.wall_clock_us = unix_at_zero_us_ == 0 ? 0 : unix_at_zero_us_ + t_us;
  put_whole(*block, BlockKind::kHeader, header_, t_us);
  return true;
}

template <typename Payload>
void BlockBuilder::put_whole(Block& block, BlockKind kind, const Payload& payload, uint64_t t_us) {
  memset(block.bytes, 0, sizeof block.bytes);
  put_payload(block, payload);
  close(block, kind, t_us);
}

void BlockBuilder::close(Block& block, BlockKind kind, uint64_t t_us) {
  BlockHeader head;
  head.magic = protocol::kBlockMagic;
  head.version = protocol::kBlockVersion;
  head.kind = kind;
  head.sample_count = block_samples_;
  head.event_count = block_events_;
  head.session = session_;
  head.block_number = blocks();
  head.first_sample = first_sample_;
  head.samples_dropped = samples_dropped();
  head.time_us = t_us;
  seal(block, head);
  ring_.commit();
  increment(blocks_);
}

}  // namespace logger
}  // namespace tfsat
