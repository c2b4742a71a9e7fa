// The time base: Timer 1 and Timer 3 run free in normal mode from the same prescaler, 16 MHz / 8,
// started in the same cycle, so that TCNT1 == TCNT3 always and a stamp from either means the same.
#pragma once

#include <avr/io.h>

#include "../core/ticks.h"

namespace tfsat {
namespace sequencer {

class TickClock {
 public:
  // Takes both timers from the Arduino core, which sets them up for PWM.
  static void begin();
  static tick_t now();
  // The turn of the 16-bit timers, low byte, in which they stand at this count, just read. Call with
  // interrupts off.
  static inline __attribute__((always_inline)) uint8_t turn_of(uint16_t count) {
    uint8_t turn = *reinterpret_cast<volatile uint8_t*>(&overflows_);
    if ((TIFR1 & _BV(TOV1)) != 0 && count < 0x8000) ++turn;
    return turn;
  }

  // For the interrupt.
  static void on_overflow() { overflows_ = overflows_ + 1; }

 private:
  static tick_t read_with_interrupts_off();

  static volatile uint16_t overflows_;
};

}  // namespace sequencer
}  // namespace tfsat
