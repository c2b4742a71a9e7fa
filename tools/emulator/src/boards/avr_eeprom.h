// The ATmega32U4's EEPROM with the time a write takes (datasheet section 5.3 and 8.5): simavr 1.6
// stores a byte at once and never shows EEPE set. A write in place of simavr's handler takes 3.4 ms
// (1.8 ms for erase only and write only).
//
// When the supply fails during a write, the byte under way is left erased (0xFF), since the cell is
// erased before it is programmed. A reset lets the write end. What a real cell holds after a cut at
// an unlucky instant is any mixture of bits; that is not modelled. Nor is the EE_READY interrupt.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "avr_io.h"

namespace tfsat {
namespace emulator {

class AvrEeprom {
 public:
  static constexpr size_t kSize = 1024;

  explicit AvrEeprom(avr_t* avr);
  AvrEeprom(const AvrEeprom&) = delete;
  AvrEeprom& operator=(const AvrEeprom&) = delete;

  void reset();      // call from avr->reset
  void cut_power();  // the byte under way is torn

  std::array<uint8_t, kSize>& cells() { return cells_; }
  uint32_t writes_begun() const { return writes_begun_; }

 private:
  bool busy() const { return busy_until_ != kNever; }
  void begin_write(uint8_t mode);
  void end_write();

  static uint8_t on_read(avr_t*, avr_io_addr_t, void* self);
  static void on_write(avr_t*, avr_io_addr_t, uint8_t, void* self);
  static avr_cycle_count_t on_done(avr_t*, avr_cycle_count_t, void* self);

  avr_t* avr_;
  std::array<uint8_t, kSize> cells_;
  uint8_t control_ = 0;
  uint64_t master_enable_until_ = 0;
  uint64_t busy_until_ = kNever;
  uint16_t address_ = 0;
  uint8_t erased_ = 0xFF, result_ = 0xFF;  // the byte under way: half done, done
  uint32_t writes_begun_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
