#include "slot_pair.h"

#include <string.h>

#include "../protocol/crc16.h"

namespace tfsat {
namespace sequencer {

constexpr uint16_t SlotPair::kSlotBytes;
constexpr uint16_t SlotPair::kBytes;
constexpr uint16_t SlotPair::kOldLayoutBelow;
constexpr uint8_t SlotPair::kMarkerBytes;
constexpr uint8_t SlotPair::kGenerationBytes;
constexpr uint8_t SlotPair::kHeadBytes;
constexpr uint8_t SlotPair::kCrcBytes;
constexpr uint8_t SlotPair::kLayout;
constexpr uint8_t SlotPair::kErased;
constexpr uint8_t SlotPair::kBegunFrom;
constexpr uint8_t SlotPair::kFlipToBegun;

void SlotPair::load() {
  for (uint8_t slot = 0; slot < 2; ++slot) {
    if (!complete(slot) || !stage(slot) || staged_generation() <= generation_ || !adopt()) continue;
    generation_ = staged_generation();
    slot_ = slot;
  }
  for (uint8_t slot = 0; slot < 2; ++slot) slots_[slot] = look_at(slot);
  old_layout_ = slots_[0] == Slot::kUnused && slots_[1] == Slot::kUnused &&
                !erased(static_cast<uint16_t>(address_ - kOldLayoutBelow), kBytes);
}

// What the slot is, beside the one that holds the current record. A marker that is none is that of a
// write cut short if what stands behind it is erased, or whole and older than what is current: then
// nothing was lost. Anything else is damage.
SlotPair::Slot SlotPair::look_at(uint8_t slot) {
  const bool holds_current = generation_ != 0 && slot == slot_;
  if (holds_current) return Slot::kWhole;
  const bool older = stage(slot) && staged_generation() < generation_;
  if (complete(slot)) return older ? Slot::kWhole : Slot::kDamaged;
  const uint8_t begun = marker_bytes(slot, kFlipToBegun);
  if (begun < kBegunFrom) {
    if (older) return Slot::kWhole;
    const uint16_t used = used_bytes(record_bytes_);
    if (erased(content_address(slot), static_cast<uint16_t>(used - kMarkerBytes))) {
      return Slot::kUnused;
    }
  }
  return begun > 0 ? Slot::kBegun : Slot::kDamaged;
}

ErrorCode SlotPair::defect() const {
  if (slots_[0] == Slot::kDamaged || slots_[1] == Slot::kDamaged) return ErrorCode::kStoreDamaged;
  if (begun_ || slots_[0] == Slot::kBegun || slots_[1] == Slot::kBegun) {
    return ErrorCode::kUploadInterrupted;
  }
  return old_layout_ ? ErrorCode::kStoreOldLayout : ErrorCode::kNone;
}

// Stages what the slot holds; false unless it is whole and of this layout. What a shorter record
// lacks is zero.
bool SlotPair::stage(uint8_t slot) {
  const uint16_t content = content_address(slot);
  for (uint8_t i = 0; i < content_bytes(); ++i) {
    content_[i] = memory_.read(static_cast<uint16_t>(content + i));
  }
  const uint8_t length = content_[kHeadBytes - 1];
  if (content_[kGenerationBytes] != kLayout || length > record_bytes_) return false;
  const uint8_t end = static_cast<uint8_t>(kHeadBytes + length);
  const uint16_t crc = content_crc(end);
  if (memcmp(content_ + end, &crc, kCrcBytes) != 0) return false;
  memset(content_ + end, 0, static_cast<uint8_t>(record_bytes_ - length));
  return true;
}

void SlotPair::begin() {
  if (writing()) return;
  begun_ = true;
  committing_ = false;
  go_to(Stage::kMark);
}

void SlotPair::commit() {
  failed_ = false;
  committing_ = true;
  if (!writing()) decide();
}

void SlotPair::decide() {
  content_[kGenerationBytes] = kLayout;
  content_[kHeadBytes - 1] = record_bytes_;
  const uint8_t end = static_cast<uint8_t>(kHeadBytes + record_bytes_);
  const Slot other = slots_[other_slot()];
  changed_ = generation_ == 0 || other == Slot::kBegun || other == Slot::kDamaged ||
             !slot_holds(slot_, kGenerationBytes, end);
  if (!changed_) {
    go_to(begun_ ? Stage::kTakeBack : Stage::kIdle);
    return;
  }
  const uint32_t next = generation_ + 1;
  memcpy(content_, &next, kGenerationBytes);
  const uint16_t crc = content_crc(end);
  memcpy(content_ + end, &crc, kCrcBytes);
  go_to(begun_ ? Stage::kContent : Stage::kMark);
  begun_ = true;
}

void SlotPair::poll() {
  if (stage_ == Stage::kIdle || memory_.busy()) return;
  if (stage_ == Stage::kContent) {
    const uint16_t content = content_address(other_slot());
    write_if_different(static_cast<uint16_t>(content + position_), content_[position_]);
    if (++position_ == content_bytes()) go_to(Stage::kComplete);
  } else if (position_ < kMarkerBytes) {
    write_if_different(static_cast<uint16_t>(slot_address(other_slot()) + position_), marker_byte());
    ++position_;
  } else {
    marked();
  }
}

// The marker is written, and the memory at rest.
void SlotPair::marked() {
  if (stage_ == Stage::kComplete) {
    finish();
  } else if (stage_ == Stage::kMark && committing_) {
    decide();
  } else {
    if (stage_ == Stage::kTakeBack) begun_ = false;
    stage_ = Stage::kIdle;
  }
}

// The byte of the other slot's marker that is to be written now.
uint8_t SlotPair::marker_byte() const {
  if (stage_ == Stage::kMark) return complete_byte(position_) ^ kFlipToBegun;
  const bool unused = stage_ == Stage::kTakeBack && slots_[other_slot()] == Slot::kUnused;
  return unused ? kErased : complete_byte(position_);
}

// All is written, once: everything is read back before it is believed.
void SlotPair::finish() {
  stage_ = Stage::kIdle;
  begun_ = false;
  const uint8_t written = other_slot();
  failed_ = !complete(written) || !slot_holds(written, 0, content_bytes()) || !adopt();
  slots_[written] = failed_ ? Slot::kDamaged : Slot::kWhole;
  if (failed_) return;
  old_layout_ = false;
  generation_ = staged_generation();
  slot_ = written;
}

uint32_t SlotPair::staged_generation() const {
  uint32_t generation;
  memcpy(&generation, content_, kGenerationBytes);
  return generation;
}

uint16_t SlotPair::content_crc(uint8_t bytes) const {
  uint16_t crc = protocol::kCrc16Initial;
  for (uint8_t i = 0; i < bytes; ++i) crc = protocol::crc16_update(crc, content_[i]);
  return crc;
}

// The slot's content from byte `first` to before `end` is what is staged.
bool SlotPair::slot_holds(uint8_t slot, uint8_t first, uint8_t end) {
  for (uint8_t i = first; i < end; ++i) {
    const uint16_t address = static_cast<uint16_t>(content_address(slot) + i);
    if (memory_.read(address) != content_[i]) return false;
  }
  return true;
}

bool SlotPair::erased(uint16_t address, uint16_t bytes) {
  for (uint16_t i = 0; i < bytes; ++i) {
    if (memory_.read(static_cast<uint16_t>(address + i)) != kErased) return false;
  }
  return true;
}

// How many bytes of the slot's marker are those of "complete", with these bits flipped.
uint8_t SlotPair::marker_bytes(uint8_t slot, uint8_t flip) {
  uint8_t count = 0;
  for (uint8_t i = 0; i < kMarkerBytes; ++i) {
    const uint8_t byte = memory_.read(static_cast<uint16_t>(slot_address(slot) + i));
    if (byte == (complete_byte(i) ^ flip)) ++count;
  }
  return count;
}

void SlotPair::write_if_different(uint16_t address, uint8_t value) {
  if (memory_.read(address) != value) memory_.write(address, value);
}

}  // namespace sequencer
}  // namespace tfsat
