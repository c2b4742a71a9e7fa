// One record in non-volatile memory, whole after any power cut: two slots take turns.
//
// A slot is: marker u8[4], generation u32, layout u8, length u8, the record's bytes, CRC-16/IBM-3740
// over generation to record. A write goes to the slot that does not hold the present record: its
// marker says "begun" before anything else changes, and "complete" once all the rest is there. Until
// "begun" is there, the record from before counts; then nothing does, until a record is complete.
#pragma once

#include "../protocol/messages.h"
#include "ports.h"

namespace tfsat {
namespace sequencer {

using protocol::ErrorCode;

class SlotPair {
 public:
  // A slot's place, with room for records that grow.
  static constexpr uint16_t kSlotBytes = 128;
  static constexpr uint16_t kBytes = 2 * kSlotBytes;
  // Layout 1 kept the same record so far below, in at most as many bytes. Nothing is written there.
  static constexpr uint16_t kOldLayoutBelow = 512;
  static constexpr uint8_t kMarkerBytes = 4;
  static constexpr uint8_t kGenerationBytes = 4;
  static constexpr uint8_t kHeadBytes = kGenerationBytes + 2;  // layout, length
  static constexpr uint8_t kCrcBytes = 2;
  static constexpr uint16_t used_bytes(uint16_t record_bytes) {
    return kMarkerBytes + kHeadBytes + record_bytes + kCrcBytes;
  }

  // Reads both slots and adopts the newer valid record, if there is one.
  void load();

  protocol::Origin origin() const {
    return generation_ == 0 ? protocol::Origin::kFactory : protocol::Origin::kUploaded;
  }
  // Records stored so far; 0 with the factory's.
  uint32_t generation() const { return generation_; }
  // Why what is current may not be what somebody wanted last, or none: store_damaged,
  // upload_interrupted, store_old_layout. Storing anew mends each.
  ErrorCode defect() const;

  // The record that commit() will store, byte by byte. May change only while committing() says no.
  uint8_t* staged() { return content_ + kHeadBytes; }
  const uint8_t* staged() const { return content_ + kHeadBytes; }
  // What is current is to be replaced: notes so in the memory, so that from then on a commit alone
  // gives something to fly again, even after a power cut.
  void begin();
  // Starts storing what is staged, which must be valid, or does so after what begin() writes. If it
  // is stored already, only what begin() wrote is taken back. Unless begin() is still at it, the
  // memory must not be busy: no other record may be on its way into it.
  void commit();
  // Writes at most one byte. Call from the main loop.
  void poll();

  bool writing() const { return stage_ != Stage::kIdle; }
  bool committing() const { return writing() && committing_; }
  // The memory did not keep what the last commit() wrote. The record from before is still current.
  bool failed() const { return failed_; }
  // The last commit() found another record in the memory than the staged one.
  bool changed() const { return changed_; }
  void forget_last() { failed_ = changed_ = false; }

 protected:
  // `content` has room for everything in a slot but its marker.
  // In line it would be written out for each store.
  __attribute__((noinline)) SlotPair(NonVolatile& memory, uint16_t address, uint8_t* content,
                                     uint8_t record_bytes)
      : memory_(memory), content_(content), address_(address), record_bytes_(record_bytes) {}
  ~SlotPair() = default;

  // Makes what is staged the current record; false, and no change, if it is not valid.
  virtual bool adopt() = 0;

 private:
  enum class Stage : uint8_t { kIdle, kMark, kContent, kComplete, kTakeBack };
  // kUnused: erased, but perhaps for a marker that a power cut tore before it said "begun".
  enum class Slot : uint8_t { kUnused, kWhole, kBegun, kDamaged };

  static constexpr uint8_t kLayout = 2;
  static constexpr uint8_t kErased = 0xFF;
  static constexpr uint8_t kBegunFrom = 3;  // bytes of the marker: one more may be torn or damaged

  // Complete: this. Begun: its complement, 32 bits away. Erased memory is 16 bits from both.
  static uint8_t complete_byte(uint8_t index) { return index % 2 == 0 ? 0x3C : 0x96; }
  static constexpr uint8_t kFlipToBegun = 0xFF;

  uint8_t other_slot() const { return static_cast<uint8_t>(1 - slot_); }
  uint16_t slot_address(uint8_t slot) const {
    return static_cast<uint16_t>(address_ + slot * kSlotBytes);
  }
  uint16_t content_address(uint8_t slot) const {
    return static_cast<uint16_t>(slot_address(slot) + kMarkerBytes);
  }
  uint8_t content_bytes() const {
    return static_cast<uint8_t>(kHeadBytes + record_bytes_ + kCrcBytes);
  }
  uint32_t staged_generation() const;
  uint16_t content_crc(uint8_t bytes) const;
  uint8_t marker_byte() const;
  bool slot_holds(uint8_t slot, uint8_t first, uint8_t end);
  bool erased(uint16_t address, uint16_t bytes);
  bool stage(uint8_t slot);
  uint8_t marker_bytes(uint8_t slot, uint8_t flip);
  bool complete(uint8_t slot) { return marker_bytes(slot, 0) == kMarkerBytes; }
  Slot look_at(uint8_t slot);
  void write_if_different(uint16_t address, uint8_t value);
  void decide();
  void marked();
  void finish();
  void go_to(Stage stage) {
    stage_ = stage;
    position_ = 0;
  }

  NonVolatile& memory_;
  uint8_t* const content_;  // what is staged, as a slot holds it
  const uint16_t address_;
  uint32_t generation_ = 0;
  const uint8_t record_bytes_;
  uint8_t position_ = 0;
  uint8_t slot_ = 1;  // that holds the current record
  Slot slots_[2] = {Slot::kUnused, Slot::kUnused};  // as they were when last looked at
  Stage stage_ = Stage::kIdle;
  bool begun_ = false;  // begin() came after that, and no end of it yet
  bool committing_ = false;
  bool old_layout_ = false;
  bool failed_ = false;
  bool changed_ = false;
};

// A Record has: kSize; decode(bytes, size) from its canonical form; valid(); and factory(). One that
// grows does so at its end: what an earlier firmware stored is read with zeros for the rest.
template <typename Record>
class Stored : public SlotPair {
 public:
  static constexpr uint16_t kUsedBytes = SlotPair::used_bytes(Record::kSize);

  Stored(NonVolatile& memory, uint16_t address)
      : SlotPair(memory, address, content_, static_cast<uint8_t>(Record::kSize)) {}

  const Record& current() const { return current_; }

 private:
  static_assert(kUsedBytes <= SlotPair::kSlotBytes, "a slot must hold its record");

  bool adopt() override {
    Record record;
    if (!record.decode(staged(), Record::kSize) || !record.valid()) return false;
    current_ = record;
    return true;
  }

  Record current_ = Record::factory();
  uint8_t content_[kUsedBytes - kMarkerBytes] = {};
};

}  // namespace sequencer
}  // namespace tfsat
