#include "maneuver_store.h"

#include "../protocol/crc16.h"

namespace tfsat {
namespace sequencer {

using protocol::crc16_update;
using protocol::kCrc16Initial;
using protocol::ManeuverOrigin;

void ManeuverStore::load() {
  Maneuver found;
  uint32_t generation = 0;
  for (uint8_t slot = 0; slot < 2; ++slot) {
    if (read_slot(slot, found, generation) && generation > generation_) {
      current_ = found;
      generation_ = generation;
      slot_ = slot;
      origin_ = ManeuverOrigin::kUploaded;
    }
  }
}

bool ManeuverStore::read_slot(uint8_t slot, Maneuver& maneuver, uint32_t& generation) {
  uint16_t address = slot_address(slot);
  if (memory_.read(address++) != kMarked) return false;
  uint16_t crc = kCrc16Initial;
  generation = 0;
  for (uint8_t i = 0; i < 4; ++i) {
    const uint8_t byte = memory_.read(address++);
    generation |= static_cast<uint32_t>(byte) << (8 * i);
    crc = crc16_update(crc, byte);
  }
  maneuver.stroke_count = 0;
  for (size_t i = 0; i < maneuver.size_bytes(); ++i) {
    const uint8_t byte = memory_.read(address++);
    if (i == 0 && (byte == 0 || byte > protocol::kMaxStrokes)) return false;
    maneuver.set_byte(i, byte);
    crc = crc16_update(crc, byte);
  }
  const uint8_t low = memory_.read(address++);
  const uint8_t high = memory_.read(address);
  const bool intact = crc == (low | (static_cast<uint16_t>(high) << 8));
  return intact && maneuver.find_defect().code == ErrorCode::kNone;
}

void ManeuverStore::begin(const Maneuver& maneuver) {
  failed_ = false;
  changed_ = false;
  if (origin_ == ManeuverOrigin::kUploaded && maneuver == current_) return;
  pending_ = maneuver;
  position_ = 0;
  pending_crc_ = kCrc16Initial;
  const uint16_t covered = static_cast<uint16_t>(content_bytes() - 2);
  for (uint16_t i = 0; i < covered; ++i) pending_crc_ = crc16_update(pending_crc_, content_byte(i));
  stage_ = Stage::kErase;
  changed_ = true;
}

uint8_t ManeuverStore::content_byte(uint16_t index) const {
  if (index < 4) return static_cast<uint8_t>((generation_ + 1) >> (8 * index));
  const uint16_t offset = static_cast<uint16_t>(index - 4);
  const uint16_t size = static_cast<uint16_t>(pending_.size_bytes());
  if (offset < size) return pending_.byte_at(offset);
  return static_cast<uint8_t>(pending_crc_ >> (8 * (offset - size)));
}

void ManeuverStore::write_if_different(uint16_t address, uint8_t value) {
  if (memory_.read(address) != value) memory_.write(address, value);
}

void ManeuverStore::poll() {
  if (stage_ == Stage::kIdle || memory_.busy()) return;
  const uint16_t address = slot_address(static_cast<uint8_t>(1 - slot_));
  switch (stage_) {
    case Stage::kErase:
      write_if_different(address, kErased);
      stage_ = Stage::kContent;
      break;
    case Stage::kContent:
      write_if_different(static_cast<uint16_t>(address + 1 + position_), content_byte(position_));
      if (++position_ == content_bytes()) stage_ = Stage::kMark;
      break;
    case Stage::kMark:
      write_if_different(address, kMarked);
      stage_ = Stage::kVerify;
      break;
    case Stage::kVerify:
      finish();
      break;
    case Stage::kIdle:
      break;
  }
}

// All is written, once: read everything back before believing it.
void ManeuverStore::finish() {
  stage_ = Stage::kIdle;
  const uint8_t slot = static_cast<uint8_t>(1 - slot_);
  Maneuver stored;
  uint32_t generation = 0;
  failed_ = !read_slot(slot, stored, generation) || !(stored == pending_);
  if (failed_) return;
  current_ = stored;
  generation_ = generation;
  slot_ = slot;
  origin_ = ManeuverOrigin::kUploaded;
}

}  // namespace sequencer
}  // namespace tfsat
