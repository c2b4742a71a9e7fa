// The time base: Timer 1 and Timer 3 run free in normal mode from the same prescaler, 16 MHz / 8,
// started in the same cycle, so that TCNT1 == TCNT3 always and a stamp from either means the same.
#pragma once

#include "../core/ticks.h"

namespace tfsat {
namespace sequencer {

class TickClock {
 public:
  // Takes both timers from the Arduino core, which sets them up for PWM.
  static void begin();
  static tick_t now();
  // The tick of a 16-bit count that a timer held less than 32 ms ago. Call with interrupts off.
  static tick_t extend(uint16_t count);
};

}  // namespace sequencer
}  // namespace tfsat
