// The uploaded maneuver in EEPROM: two slots, so that a power cut at any byte leaves one whole.
//
// A slot is: marker u8, generation u32, maneuver (canonical form), CRC-16/IBM-3740 over generation
// and maneuver. A write goes to the slot that does not hold the present maneuver: its marker is
// erased first and set last, so that a slot with a marker is always complete.
#pragma once

#include "maneuver.h"
#include "ports.h"

namespace tfsat {
namespace sequencer {

class ManeuverStore {
 public:
  static constexpr uint16_t kSlotBytes = 1 + 4 + Maneuver::kMaxBytes + 2;

  explicit ManeuverStore(NonVolatile& memory) : memory_(memory) {}

  // Reads both slots and takes the newer valid one, else the factory maneuver.
  void load();
  const Maneuver& current() const { return current_; }
  protocol::ManeuverOrigin origin() const { return origin_; }
  // Uploads stored so far; 0 with the factory maneuver.
  uint32_t generation() const { return generation_; }

  // Starts storing; nothing is written if `maneuver` is stored already. `maneuver` must be valid.
  void begin(const Maneuver& maneuver);
  // Writes at most one byte. Call from the main loop.
  void poll();
  bool writing() const { return stage_ != Stage::kIdle; }
  // The memory did not keep what the last begin() wrote. The maneuver from before is still current.
  bool failed() const { return failed_; }
  void forget_failure() { failed_ = false; }
  // The last begin() changed the memory.
  bool changed() const { return changed_; }

 private:
  enum class Stage : uint8_t { kIdle, kErase, kContent, kMark, kVerify };

  static constexpr uint8_t kMarked = 0xA5;
  static constexpr uint8_t kErased = 0xFF;

  uint16_t slot_address(uint8_t slot) const { return static_cast<uint16_t>(slot * kSlotBytes); }
  bool read_slot(uint8_t slot, Maneuver& maneuver, uint32_t& generation);
  uint8_t content_byte(uint16_t index) const;
  uint16_t content_bytes() const { return static_cast<uint16_t>(4 + pending_.size_bytes() + 2); }
  void write_if_different(uint16_t address, uint8_t value);
  void finish();

  NonVolatile& memory_;
  Maneuver current_ = Maneuver::factory();
  Maneuver pending_ = Maneuver::factory();
  uint32_t generation_ = 0;
  uint16_t pending_crc_ = 0;
  uint16_t position_ = 0;
  uint8_t slot_ = 1;  // that holds current_
  protocol::ManeuverOrigin origin_ = protocol::ManeuverOrigin::kFactory;
  Stage stage_ = Stage::kIdle;
  bool failed_ = false;
  bool changed_ = false;
};

}  // namespace sequencer
}  // namespace tfsat
