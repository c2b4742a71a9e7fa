// The sequencer's real firmware: the HEX that would be flashed, run instruction by instruction in
// libsimavr 1.6 (GPLv3, unpatched) as an Arduino Micro with its USB serial port, EEPROM, release
// switches and output pins. Output edges are exact to the CPU cycle (62.5 ns).
//
// Not modelled: the bootloader (after a brown-out the real one waits 8 s for an upload before it
// starts the sketch), supply voltage, sleep modes' currents.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "sequencer_board.h"

namespace tfsat {
namespace emulator {

class AvrMachine;

class AvrSequencer : public SequencerBoard {
 public:
  // Loads the image; the board starts unpowered, cable unplugged, switches open, EEPROM erased.
  // Throws std::runtime_error when the file is no Intel HEX image for an ATmega32U4.
  explicit AvrSequencer(const std::string& hex_path);
  ~AvrSequencer() override;

  void set_power(bool on) override;
  void reset(ResetCause cause) override;
  // Throws std::runtime_error when the program did what would hang or wreck the real board (an
  // access outside memory, an invalid instruction).
  void advance_to(uint64_t t_us) override;
  void advance_to_cycle(uint64_t cycle);
  void set_switch(int index, bool closed) override;
  void hold_pin(int joint, PinHold hold) override;
  void set_cable(bool plugged) override;
  // At 115200 baud.
  void set_port(bool open) override;
  size_t write(const uint8_t* data, size_t n) override;
  size_t read(uint8_t* data, size_t capacity) override;
  bool take_edge(PinEdge& edge) override;
  void eeprom_get(uint8_t* image, size_t n) override;
  void eeprom_set(const uint8_t* image, size_t n) override;
  // Byte writes begun: lets a test cut the power at each one.
  uint32_t eeprom_writes() const override;

  // Likewise, at another rate.
  void set_port(bool open, uint32_t baud);
  // A busy host: it rests this many polls of 125 us after each stage of a control transfer. 0 at
  // first.
  void set_usb_stage_pause(uint32_t polls);
  void set_usb_half_transfers(uint32_t polls);
  // The host resets the bus and asks at once: see AvrUsbHost::reset_bus().
  void reset_usb_bus();
  // The device is enumerated and can carry bytes.
  bool link_ready() const;
  // The ten bytes of serial number in the signature row (0x0E to 0x17). "emulated" and two zeros at
  // first, so that a host sees which board it is not.
  void set_serial_number(const std::array<uint8_t, 10>& serial);
  // 0xC8 at first: brown-out at 4.3 V. The Micro is sold with 0xCB.
  void set_extended_fuse(uint8_t fuse);
  // One byte of RAM (data space address), as a debugger would read it.
  uint8_t peek(uint16_t address) const;
  void poke(uint16_t address, uint8_t value);
  uint64_t cycles() const;
  // From now on, notes how long interrupts stay off, in cycles, by the address of the first
  // instruction then: takes several times longer.
  void watch_blocking();
  std::map<uint16_t, uint64_t> blocked() const;

 private:
  std::unique_ptr<AvrMachine> machine_;
};

}  // namespace emulator
}  // namespace tfsat
