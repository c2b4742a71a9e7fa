// A reader of recordings, as a decoder would read them.
#pragma once

#include <set>
#include <vector>

#include "../../firmware/teensy_logger/src/core/block_layout.h"

namespace tfsat_test {

using tfsat::logger::Block;
using tfsat::protocol::BlockHeader;
using tfsat::protocol::BlockKind;

// What the first `n` blocks hold; reading stops at the first block that is not whole.
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
