// Timer/Counter 1 and 3 of the ATmega32U4 in normal mode (datasheet section 14), in place of
// simavr 1.6's own, which cannot carry servo pulses:
//   - it has no compare unit C (D11 = OC1C) on this chip;
//   - in normal mode every write to OCR1x, and every overflow, toggles pins set to "clear" or "set
//     on compare match" (avr_timer_comp_on_tov);
//   - it knows neither TEMP, nor FOC1x, nor the prescaler that Timer 0, 1 and 3 share (GTCCR), nor
//     an interrupt that is enabled after its flag was raised;
//   - it has no input capture noise canceler.
// Not modelled: the PWM and CTC modes (the counter runs, compare units rest), the external clock,
// capture by the analog comparator, the 2 to 3 cycles of the input synchronizer.
#pragma once

#include <array>
#include <cstdint>

#include "avr_io.h"

namespace tfsat {
namespace emulator {

// The ten-bit prescaler behind Timer 1 and 3.
struct Prescaler {
  uint64_t origin = 0;  // cycle at which it was zero
  bool held = false;    // GTCCR: TSM and PSRSYNC are set
};

// Told when the compare unit of a channel changes what it puts out, with the exact cycle.
class CompareOutputListener {
 public:
  virtual void compare_output_changed(uint64_t cycle) = 0;

 protected:
  ~CompareOutputListener() = default;
};

class Timer16 {
 public:
  static constexpr int kChannels = 3;

  struct Layout {
    avr_io_addr_t tccra;  // the other registers follow it as the datasheet lists them
    avr_io_addr_t timsk, tifr;
    uint8_t capture_vector;  // compare A, B, C and overflow follow it
  };
  static constexpr Layout timer1() { return {0x80, 0x6F, 0x36, 16}; }
  static constexpr Layout timer3() { return {0x90, 0x71, 0x38, 31}; }

  Timer16(avr_t* avr, const Layout& layout, Prescaler& prescaler, CompareOutputListener* listener);
  Timer16(const Timer16&) = delete;
  Timer16& operator=(const Timer16&) = delete;

  // Call from avr->reset: registers to zero; simavr has just forgotten every cycle timer.
  void reset();

  // The input capture pin is at this level from `cycle` on.
  void set_capture_pin(bool high, uint64_t cycle);

  // OCnx takes the pin from the port (COM bits are set), and the level it puts out.
  bool drives(int channel) const { return com(channel) != 0; }
  bool output(int channel) const { return output_[channel]; }

  // Around a change of the prescaler.
  void before_prescaler_change() { settle(); }
  void after_prescaler_change() { plan(); }

 private:
  enum Vector { kCapture, kCompareA, kCompareB, kCompareC, kOverflow, kVectors };

  uint8_t com(int channel) const { return (control_a_ >> (6 - 2 * channel)) & 3; }
  bool normal_mode() const { return (control_a_ & 0x03) == 0 && (control_b_ & 0x18) == 0; }
  uint32_t divider() const;
  uint16_t count_at(uint64_t cycle) const;
  uint64_t next_tick(uint64_t cycle) const;
  uint64_t match_after(uint64_t cycle, uint16_t value) const;

  uint64_t next_due() const;
  void settle();
  void catch_up();
  void plan();
  void arm();
  void fire(uint64_t when);
  void apply_compare(int channel, uint64_t when);
  void capture(uint64_t cycle);
  void raise(int vector);

  uint8_t read_register(avr_io_addr_t address);
  void write_register(avr_io_addr_t address, uint8_t value);
  void write_low_byte(int offset, uint16_t word);
  void write_interrupt_mask(uint8_t value);
  void clear_flags(uint8_t value);

  static uint8_t on_read(avr_t*, avr_io_addr_t, void* self);
  static void on_write(avr_t*, avr_io_addr_t, uint8_t, void* self);
  static avr_cycle_count_t on_due(avr_t*, avr_cycle_count_t when, void* self);
  static avr_cycle_count_t on_pin_stable(avr_t*, avr_cycle_count_t when, void* self);

  avr_t* avr_;
  const Layout layout_;
  Prescaler& prescaler_;
  CompareOutputListener* listener_;
  std::array<avr_int_vector_t*, kVectors> vectors_{};
  avr_int_vector_t compare_c_{};

  uint8_t control_a_ = 0, control_b_ = 0;
  uint8_t temp_ = 0;
  std::array<uint16_t, kChannels> compare_{};
  uint16_t captured_ = 0;
  std::array<bool, kChannels> output_{};
  bool pin_ = true, filtered_pin_ = true;

  uint64_t anchor_cycle_ = 0;  // the counter stood at anchor_count_ then
  uint16_t anchor_count_ = 0;
  std::array<uint64_t, kChannels> match_due_{};
  uint64_t overflow_due_ = kNever;
};

}  // namespace emulator
}  // namespace tfsat
