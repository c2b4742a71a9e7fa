// An ATmega32U4 in libsimavr with the Arduino Micro's surroundings, and what simavr 1.6 leaves out
// or does otherwise than the chip: see avr_timer16.h, avr_eeprom.h, avr_usb_host.h, and here the
// interrupts' entry time, the signature row and a changed watchdog timeout.
#pragma once

#include <array>
#include <cstdarg>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "avr_eeprom.h"
#include "avr_io.h"
#include "avr_pins.h"
#include "avr_timer16.h"
#include "avr_usb_host.h"
#include "sequencer_board.h"

namespace tfsat {
namespace emulator {

class AvrMachine {
 public:
  explicit AvrMachine(const std::string& hex_path);
  AvrMachine(const AvrMachine&) = delete;
  AvrMachine& operator=(const AvrMachine&) = delete;

  void power(bool on);
  void restart(ResetCause cause);
  void run_until(uint64_t cycle);
  // From now on, notes how long interrupts stay off: an instruction at a time, several times slower.
  void watch_blocking();

  std::unique_ptr<avr_t, void (*)(avr_t*)> avr;
  Prescaler prescaler;
  AvrPins pins;
  Timer16 timer1, timer3;
  AvrEeprom eeprom;
  AvrUsbHost usb;
  bool powered = false;
  uint64_t now = 0;  // virtual time in cycles; the CPU may be an instruction ahead
  // The longest that they were off, in cycles, by the address of the first instruction then.
  std::map<uint16_t, uint64_t> blocked;
  std::array<uint8_t, 10> serial{{'e', 'm', 'u', 'l', 'a', 't', 'e', 'd', 0, 0}};
  // Low, lock bits, extended, high. Brown-out at 4.3 V: the Micro is sold with 0xCB, 2.6 V.
  std::array<uint8_t, 4> fuses{{0xFF, 0xEF, 0xC8, 0xD8}};

 private:
  static AvrMachine& of(avr_t* avr) { return *static_cast<AvrMachine*>(avr->custom.data); }
  void hook_simavr();
  void note_blocking();

  static void on_reset(avr_t* avr);
  static avr_cycle_count_t after_reset(avr_t* avr, avr_cycle_count_t, void*);
  static avr_cycle_count_t on_stop(avr_t* avr, avr_cycle_count_t, void*);
  template <size_t n>
  void lay_over_flash(uint32_t address, const std::array<uint8_t, n>& bytes);
  static avr_cycle_count_t uncover_flash(avr_t*, avr_cycle_count_t, void* self);
  static void on_interrupt(avr_irq_t*, uint32_t vector, void* self);
  static void on_gtccr_write(avr_t*, avr_io_addr_t, uint8_t, void* self);
  static void on_spmcsr_write(avr_t*, avr_io_addr_t, uint8_t, void* self);
  static void on_wdtcsr_write(void* self, uint8_t);
  static void on_sleep(avr_t*, avr_cycle_count_t) {}
  static void log(avr_t* avr, int level, const char* format, va_list arguments);

  void (*simavr_reset_)(avr_t*) = nullptr;
  std::vector<uint8_t> covered_flash_;
  uint32_t covered_at_ = 0;
  WriteTap wdtcsr_tap_;
  uint8_t watchdog_timeout_ = 0;
  std::string fault_;
  bool watching_ = false;
  bool off_ = false;
  uint64_t off_since_ = 0;
  uint16_t off_at_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
