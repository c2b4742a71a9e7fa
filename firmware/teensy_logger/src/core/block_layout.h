// Where things stand in a 512-byte block, and its seal.
#pragma once

#include "../protocol/crc32.h"
#include "block_ring.h"

namespace tfsat {
namespace logger {

inline void put_sample(Block& block, uint8_t slot, const protocol::Sample& sample) {
  sample.encode(block.bytes + protocol::kSamplesOffset + slot * protocol::Sample::kSize);
}

inline void put_event(Block& block, uint8_t slot, const protocol::Event& event) {
  event.encode(block.bytes + protocol::kEventsOffset + slot * protocol::Event::kSize);
}

// Payload of a header or footer block.
template <typename Payload>
void put_payload(Block& block, const Payload& payload) {
  payload.encode(block.bytes + protocol::BlockHeader::kSize);
}

// The block's own header, and the CRC-32/ISO-HDLC over everything before it. Comes last.
inline void seal(Block& block, const protocol::BlockHeader& head) {
  head.encode(block.bytes);
  protocol::Writer crc(block.bytes + protocol::kBlockCrcOffset);
  crc.u32(protocol::crc32(block.bytes, protocol::kBlockCrcOffset));
}

}  // namespace logger
}  // namespace tfsat
