#include "tick_clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

namespace tfsat {
namespace sequencer {

volatile uint16_t TickClock::overflows_;

// An overflow whose interrupt has not run yet shows in TOV1; the count is small right after it.
tick_t TickClock::read_with_interrupts_off() {
  const uint16_t count = TCNT1;
  uint16_t high = overflows_;
  if ((TIFR1 & _BV(TOV1)) != 0 && count < 0x8000) ++high;
  return static_cast<uint32_t>(high) << 16 | count;
}

ISR(TIMER1_OVF_vect) { TickClock::on_overflow(); }

// GTCCR.TSM holds the shared prescaler while both counters are set (datasheet section 12.3).
void TickClock::begin() {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    GTCCR = _BV(TSM) | _BV(PSRSYNC);
    TCCR1A = 0;
    TCCR3A = 0;
    TIMSK1 = 0;
    TIMSK3 = 0;
    TCCR1B = _BV(CS11);
    TCCR3B = _BV(CS31);
    TCNT1 = 0;
    TCNT3 = 0;
    TIFR1 = 0xFF;
    TIFR3 = 0xFF;
    overflows_ = 0;
    TIMSK1 = _BV(TOIE1);
    GTCCR = 0;
  }
}

tick_t TickClock::now() {
  tick_t ticks;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { ticks = read_with_interrupts_off(); }
  return ticks;
}

}  // namespace sequencer
}  // namespace tfsat
