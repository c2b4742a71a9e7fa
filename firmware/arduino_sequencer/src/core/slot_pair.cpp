#include "slot_pair.h"

#include "../protocol/crc16.h"

namespace tfsat {
namespace sequencer {

constexpr uint8_t SlotPair::kMarked;
constexpr uint8_t SlotPair::kErased;
constexpr uint8_t SlotPair::kGenerationBytes;

void SlotPair::load() {
  for (uint8_t slot = 0; slot < 2; ++slot) {
    if (memory_.read(slot_address(slot)) != kMarked) continue;
    if (!stage(slot)) {
      note_damage(slot, true);
    } else if (staged_generation_ > generation_) {
      const bool adopted = adopt();
      note_damage(slot, !adopted);
      if (!adopted) continue;
      generation_ = staged_generation_;
      slot_ = slot;
    }
  }
}

// Stages what the slot holds; false unless it is undamaged.
bool SlotPair::stage(uint8_t slot) {
  uint16_t address = static_cast<uint16_t>(slot_address(slot) + 1);
  staged_generation_ = 0;
  for (uint8_t i = 0; i < kGenerationBytes; ++i) {
    staged_generation_ |= static_cast<uint32_t>(memory_.read(address++)) << (8 * i);
  }
  for (uint8_t i = 0; i < record_bytes_; ++i) staged_[i] = memory_.read(address++);
  staged_crc_ = content_crc();
  const uint8_t end = content_bytes();
  return slot_holds(slot, static_cast<uint8_t>(end - 2), end);
}

void SlotPair::begin() {
  failed_ = false;
  changed_ =
      damaged_slots_ != 0 || generation_ == 0 ||
      !slot_holds(slot_, kGenerationBytes, static_cast<uint8_t>(kGenerationBytes + record_bytes_));
  if (!changed_) return;
  staged_generation_ = generation_ + 1;
  staged_crc_ = content_crc();
  position_ = 0;
  stage_ = Stage::kErase;
}

void SlotPair::poll() {
  if (stage_ == Stage::kIdle || memory_.busy()) return;
  const uint16_t marker = slot_address(other_slot());
  switch (stage_) {
    case Stage::kErase:
      write_if_different(marker, kErased);
      stage_ = Stage::kContent;
      break;
    case Stage::kContent:
      write_if_different(static_cast<uint16_t>(marker + 1 + position_), content_byte(position_));
      if (++position_ == content_bytes()) stage_ = Stage::kMark;
      break;
    case Stage::kMark:
      write_if_different(marker, kMarked);
      stage_ = Stage::kVerify;
      break;
    case Stage::kVerify:
      finish();
      break;
    case Stage::kIdle:
      break;
  }
}

void SlotPair::note_damage(uint8_t slot, bool damaged) {
  const uint8_t bit = static_cast<uint8_t>(1u << slot);
  damaged_slots_ = static_cast<uint8_t>(damaged ? damaged_slots_ | bit : damaged_slots_ & ~bit);
}

// All is written, once: everything is read back before it is believed.
void SlotPair::finish() {
  stage_ = Stage::kIdle;
  const uint8_t written = other_slot();
  failed_ = memory_.read(slot_address(written)) != kMarked ||
            !slot_holds(written, 0, content_bytes()) || !adopt();
  note_damage(written, failed_);
  if (failed_) return;
  generation_ = staged_generation_;
  slot_ = written;
}

uint8_t SlotPair::content_byte(uint8_t index) const {
  if (index < kGenerationBytes) return static_cast<uint8_t>(staged_generation_ >> (8 * index));
  const uint8_t offset = static_cast<uint8_t>(index - kGenerationBytes);
  if (offset < record_bytes_) return staged_[offset];
  return static_cast<uint8_t>(staged_crc_ >> (8 * (offset - record_bytes_)));
}

uint16_t SlotPair::content_crc() const {
  uint16_t crc = protocol::kCrc16Initial;
  for (uint8_t i = 0; i < kGenerationBytes + record_bytes_; ++i) {
    crc = protocol::crc16_update(crc, content_byte(i));
  }
  return crc;
}

// The slot's content from byte `first` to before `end` is what is staged.
bool SlotPair::slot_holds(uint8_t slot, uint8_t first, uint8_t end) {
  const uint16_t content = static_cast<uint16_t>(slot_address(slot) + 1);
  for (uint8_t i = first; i < end; ++i) {
    if (memory_.read(static_cast<uint16_t>(content + i)) != content_byte(i)) return false;
  }
  return true;
}

void SlotPair::write_if_different(uint16_t address, uint8_t value) {
  if (memory_.read(address) != value) memory_.write(address, value);
}

}  // namespace sequencer
}  // namespace tfsat
