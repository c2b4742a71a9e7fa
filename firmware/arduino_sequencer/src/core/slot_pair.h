// One record in non-volatile memory, whole after any power cut: two slots take turns.
//
// A slot is: marker u8, generation u32, the record's bytes, CRC-16/IBM-3740 over generation and
// record. A write goes to the slot that does not hold the present record: its marker is erased
// first and set last, so that a slot with a marker is always complete.
#pragma once

#include "../protocol/messages.h"
#include "ports.h"

namespace tfsat {
namespace sequencer {

class SlotPair {
 public:
  static constexpr uint16_t slot_bytes(uint16_t record_bytes) { return 1 + 4 + record_bytes + 2; }

  // Reads both slots and adopts the newer valid record, if there is one.
  void load();

  protocol::Origin origin() const {
    return generation_ == 0 ? protocol::Origin::kFactory : protocol::Origin::kUploaded;
  }
  // Records stored so far; 0 with the factory's.
  uint32_t generation() const { return generation_; }

  // The record that begin() will store, byte by byte. May change only while nothing is being
  // written.
  uint8_t* staged() { return staged_; }
  const uint8_t* staged() const { return staged_; }
  // Starts storing what is staged, which must be valid; nothing is written if it is stored already.
  // The memory must not be busy: no other record may be on its way into it.
  void begin();
  // Writes at most one byte. Call from the main loop.
  void poll();

  bool writing() const { return stage_ != Stage::kIdle; }
  // The memory did not keep what the last begin() wrote. The record from before is still current.
  bool failed() const { return failed_; }
  void forget_failure() { failed_ = false; }
  // load() found a slot that was complete once and is not any more, or not of this layout: what is
  // current may be older than what was stored last. Storing anew mends it.
  bool damaged() const { return damaged_slots_ != 0; }
  // The last begin() changed the memory.
  bool changed() const { return changed_; }

 protected:
  SlotPair(NonVolatile& memory, uint16_t address, uint8_t* staged, uint8_t record_bytes)
      : memory_(memory), staged_(staged), address_(address), record_bytes_(record_bytes) {}
  ~SlotPair() = default;

  // Makes what is staged the current record; false, and no change, if it is not valid.
  virtual bool adopt() = 0;

 private:
  enum class Stage : uint8_t { kIdle, kErase, kContent, kMark, kVerify };

  static constexpr uint8_t kMarked = 0xA5;
  static constexpr uint8_t kErased = 0xFF;
  static constexpr uint8_t kGenerationBytes = 4;

  uint8_t other_slot() const { return static_cast<uint8_t>(1 - slot_); }
  uint16_t slot_address(uint8_t slot) const {
    return static_cast<uint16_t>(address_ + slot * slot_bytes(record_bytes_));
  }
  uint8_t content_bytes() const {
    return static_cast<uint8_t>(kGenerationBytes + record_bytes_ + 2);
  }
  uint8_t content_byte(uint8_t index) const;
  uint16_t content_crc() const;
  bool slot_holds(uint8_t slot, uint8_t first, uint8_t end);
  bool stage(uint8_t slot);
  void note_damage(uint8_t slot, bool damaged);
  void write_if_different(uint16_t address, uint8_t value);
  void finish();

  NonVolatile& memory_;
  uint8_t* const staged_;
  const uint16_t address_;
  uint16_t staged_crc_ = 0;
  uint32_t staged_generation_ = 0;
  uint32_t generation_ = 0;
  const uint8_t record_bytes_;
  uint8_t position_ = 0;
  uint8_t slot_ = 1;  // that holds the current record
  Stage stage_ = Stage::kIdle;
  bool failed_ = false;
  bool changed_ = false;
  uint8_t damaged_slots_ = 0;  // bit i: slot i
};

// A Record has: kSize; decode(bytes, size) from its canonical form; valid(); and factory().
template <typename Record>
class Stored : public SlotPair {
 public:
  static constexpr uint16_t kBytes = 2 * SlotPair::slot_bytes(Record::kSize);

  Stored(NonVolatile& memory, uint16_t address)
      : SlotPair(memory, address, bytes_, static_cast<uint8_t>(Record::kSize)) {}

  const Record& current() const { return current_; }

 private:
  static_assert(Record::kSize <= 255 - 6, "positions in a slot are counted in a byte");

  bool adopt() override {
    Record record;
    if (!record.decode(bytes_, Record::kSize) || !record.valid()) return false;
    current_ = record;
    return true;
  }

  Record current_ = Record::factory();
  uint8_t bytes_[Record::kSize] = {};
};

}  // namespace sequencer
}  // namespace tfsat
