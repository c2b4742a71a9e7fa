// A card that keeps what it is given and misbehaves on demand, and a reader of recordings.
#pragma once

#include <cstring>
#include <set>
#include <vector>

#include "../../firmware/teensy_logger/src/core/block_layout.h"
#include "../../firmware/teensy_logger/src/core/ports.h"

namespace tfsat_test {

using tfsat::logger::Block;
using tfsat::protocol::BlockHeader;
using tfsat::protocol::BlockKind;
using tfsat::protocol::ErrorCode;

// Unlike a real one it is only gone when told: until `gone_until_us` it has no contact, which costs
// what was written since the last sync, and then it must be started anew. Meanwhile it refuses, or
// looks busy as SdFat has it for a card that does not answer.
class FakeCard final : public tfsat::logger::BlockSink {
 public:
  ErrorCode open(uint32_t n_blocks) override {
    ++opens;
    if (open_error != ErrorCode::kNone) return open_error;
    blocks.assign(n_blocks, Block());
    prepared = 0;
    return ErrorCode::kNone;
  }
  bool busy(uint64_t now_us) override {
    t_us = now_us;
    notice_loss();
    return is_busy();
  }
  ErrorCode prepare() override {
    if (lost_contact) return ErrorCode::kCardWriteFailed;
    if (prepare_error != ErrorCode::kNone) return prepare_error;
    const uint32_t step = prepare_step == 0 ? n_blocks() : prepare_step;
    prepared = prepared + step < n_blocks() ? prepared + step : n_blocks();
    return ErrorCode::kNone;
  }
  uint32_t prepared_blocks() override { return prepared; }
  ErrorCode recover(uint64_t now_us) override {
    t_us = now_us;
    ++recoveries;
    notice_loss();
    if (t_us < gone_until_us) return ErrorCode::kNoCard;
    lost_contact = false;
    return ErrorCode::kNone;
  }
  ErrorCode write(uint32_t index, const uint8_t* block) override {
    notice_loss();
    if (is_busy()) ++writes_while_busy;
    if (index >= prepared) ++writes_unprepared;
    if (lost_contact) return ErrorCode::kCardWriteFailed;
    if (failures_left > 0) {
      --failures_left;
      return ErrorCode::kCardWriteFailed;
    }
    std::memcpy(blocks.at(index).bytes, block, sizeof blocks[index].bytes);
    ++writes;
    unsynced.push_back(index);
    busy_until_us = t_us + write_us;
    return ErrorCode::kNone;
  }
  ErrorCode sync() override {
    notice_loss();
    if (lost_contact) return ErrorCode::kCardWriteFailed;
    unsynced.clear();
    sync_times_us.push_back(t_us);
    busy_until_us = t_us + sync_us;
    return ErrorCode::kNone;
  }
  ErrorCode close(uint32_t n_blocks) override {
    notice_loss();
    if (lost_contact) return ErrorCode::kCardWriteFailed;
    unsynced.clear();
    blocks.resize(n_blocks);
    ++closes;
    return ErrorCode::kNone;
  }
  ErrorCode inspect(uint32_t) override {
    ++looks;
    return open_error;
  }
  uint32_t free_mib() override { return 1000; }

  uint32_t n_blocks() const { return static_cast<uint32_t>(blocks.size()); }
  bool is_busy() const { return t_us < busy_until_us || (lost_contact && busy_when_gone); }
  void notice_loss() {
    if (t_us >= gone_until_us || lost_contact) return;
    lost_contact = true;
    for (const uint32_t index : unsynced) blocks.at(index) = Block();
    unsynced.clear();
  }

  std::vector<Block> blocks;
  std::vector<uint32_t> unsynced;
  std::vector<uint64_t> sync_times_us;
  ErrorCode open_error = ErrorCode::kNone;
  ErrorCode prepare_error = ErrorCode::kNone;
  uint32_t prepared = 0;
  uint32_t prepare_step = 0;  // blocks; 0: all at once
  uint64_t t_us = 0;
  uint64_t busy_until_us = 0;
  uint32_t write_us = 0, sync_us = 0;  // busy after a block, after a sync
  uint64_t gone_until_us = 0;
  bool busy_when_gone = false;
  bool lost_contact = false;
  int failures_left = 0;
  int recoveries = 0, looks = 0, opens = 0, closes = 0, writes = 0, writes_while_busy = 0;
  int writes_unprepared = 0;
};

// What the first `n` blocks hold, read as a decoder would; it stops at the first block that is not
// whole.
struct Recording {
  std::vector<BlockHeader> heads;
  std::vector<uint64_t> sample_times_us;
  std::vector<uint32_t> sample_indices;
  std::vector<tfsat::protocol::Sample> samples;
  std::vector<tfsat::protocol::Event> events;
  std::vector<tfsat::protocol::LogHeader> headers;
  std::vector<tfsat::protocol::LogFooter> footers;
};

inline bool whole(const Block& block, BlockHeader& head) {
  using namespace tfsat::protocol;
  Reader crc(block.bytes + kBlockCrcOffset);
  if (crc.u32() != crc32(block.bytes, kBlockCrcOffset)) return false;
  if (!head.decode(block.bytes, BlockHeader::kSize)) return false;
  return head.magic == kBlockMagic && head.version == kBlockVersion;
}

// Copies of a block are read once: the first that is whole.
inline Recording read_recording(const std::vector<Block>& blocks, size_t n) {
  using namespace tfsat::protocol;
  Recording recording;
  std::set<uint32_t> seen;
  for (size_t i = 0; i < n && i < blocks.size(); ++i) {
    BlockHeader head;
    if (!whole(blocks[i], head)) break;
    if (!seen.insert(head.block_number).second) continue;
    recording.heads.push_back(head);
    const uint8_t* bytes = blocks[i].bytes;
    if (head.kind == BlockKind::kHeader) {
      recording.headers.emplace_back().decode(bytes + BlockHeader::kSize, LogHeader::kSize);
    } else if (head.kind == BlockKind::kFooter) {
      recording.footers.emplace_back().decode(bytes + BlockHeader::kSize, LogFooter::kSize);
    }
    for (uint8_t s = 0; s < head.sample_count; ++s) {
      Sample sample;
      sample.decode(bytes + kSamplesOffset + s * Sample::kSize, Sample::kSize);
      recording.sample_times_us.push_back(head.time_us + sample.time_offset_us);
      recording.sample_indices.push_back(head.first_sample + s);
      recording.samples.push_back(sample);
    }
    for (uint8_t e = 0; e < head.event_count; ++e) {
      const uint8_t* event = bytes + kEventsOffset + e * Event::kSize;
      recording.events.emplace_back().decode(event, Event::kSize);
    }
  }
  return recording;
}

inline std::vector<tfsat::protocol::Event> events_of(const Recording& recording,
                                                     tfsat::protocol::EventCode code) {
  std::vector<tfsat::protocol::Event> found;
  for (const tfsat::protocol::Event& event : recording.events) {
    if (event.code == code) found.push_back(event);
  }
  return found;
}

}  // namespace tfsat_test
