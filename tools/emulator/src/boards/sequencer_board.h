// The sequencer as the emulated robot sees it: a board with power, two release switches, a USB
// cable and four output pins. native_sequencer.* runs the firmware's core on the PC;
// avr_sequencer.* runs the HEX that would be flashed. Its times are what the board's own clock has
// counted since power-up of the world: see board_clock.h.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tfsat {
namespace emulator {

// Why the board restarts while it keeps its supply. Power-on is set_power(false), set_power(true).
enum class ResetCause : uint8_t { kWatchdog, kBrownOut, kExternal };

// A short or a wire that lies where it must not: it wins against what drives the pin.
enum class PinHold : uint8_t { kFree, kLow, kHigh };

// One change of an output pin's level.
// pin: 0..2 = servo signal of joint 1..3 (D9 D10 D11), 3 = stroke line to the logger (D12).
struct PinEdge {
  uint64_t t_ns;
  uint8_t pin;
  bool high;
};

class SequencerBoard {
 public:
  virtual ~SequencerBoard() = default;

  // Off: RAM, pins and the link are gone at once, the EEPROM stays.
  virtual void set_power(bool on) = 0;
  virtual void reset(ResetCause cause) = 0;

  // Runs the board to this time; never runs it backwards.
  virtual void advance_to(uint64_t t_us) = 0;

  // Release switch 0 (D4) or 1 (D13), from the present time on; closed pulls the pin low.
  virtual void set_switch(int index, bool closed) = 0;

  // Holds the servo pin of a joint, 0 to 2, from the present time on, or lets it go.
  virtual void hold_pin(int joint, PinHold hold) = 0;

  // USB cable to the host. Pulling it drops what is under way in both directions.
  virtual void set_cable(bool plugged) = 0;

  // A program on the host opens or closes the board's serial port (DTR). It is open at first, and
  // stays as it is while the cable is pulled.
  virtual void set_port(bool open) = 0;

  // Host -> board; returns how many bytes were taken. Board -> host; returns how many were given.
  virtual size_t write(const uint8_t* data, size_t n) = 0;
  virtual size_t read(uint8_t* data, size_t capacity) = 0;

  // Oldest unread edge of an output pin; false when there is none.
  virtual bool take_edge(PinEdge& edge) = 0;

  virtual void eeprom_get(uint8_t* image, size_t n) = 0;
  virtual void eeprom_set(const uint8_t* image, size_t n) = 0;
  // Changes of the EEPROM by the board since it was made: tells cheaply that there was one.
  virtual uint32_t eeprom_writes() const = 0;
};

}  // namespace emulator
}  // namespace tfsat
