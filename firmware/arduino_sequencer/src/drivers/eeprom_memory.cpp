#include "eeprom_memory.h"

#include <avr/io.h>
#include <util/atomic.h>

#include "tick_clock.h"

namespace tfsat {
namespace sequencer {

void EepromMemory::begin() {
  const tick_t start = TickClock::now();
  while (busy() && TickClock::now() - start < 10 * kTicksPerMs) continue;
}

uint8_t EepromMemory::read(uint16_t address) {
  EEAR = address;
  EECR |= _BV(EERE);
  return EEDR;
}

bool EepromMemory::busy() { return (EECR & _BV(EEPE)) != 0; }

// EEPE must follow EEMPE within four cycles (datasheet section 5.3).
void EepromMemory::write(uint16_t address, uint8_t value) {
  EEAR = address;
  EEDR = value;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    EECR = _BV(EEMPE);
    EECR |= _BV(EEPE);
  }
}

}  // namespace sequencer
}  // namespace tfsat
