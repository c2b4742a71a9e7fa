#include "watchdog.h"

#include <Arduino.h>
#include <avr/wdt.h>
#include <util/atomic.h>

namespace tfsat {
namespace sequencer {

namespace {

constexpr uint8_t kTimeoutBits = _BV(WDP3) | _BV(WDP2) | _BV(WDP1) | _BV(WDP0);
constexpr uint8_t kOneSecond = _BV(WDP2) | _BV(WDP1);

// Where the core leaves MAGIC_KEY: at the end of RAM for newer bootloaders, else at MAGIC_KEY_POS,
// whose contents it keeps at the end of RAM (CDC.cpp, CDC_Setup).
void remove_bootloader_key() {
  volatile uint16_t& at_end = *reinterpret_cast<volatile uint16_t*>(RAMEND - 1);
  volatile uint16_t& older = *reinterpret_cast<volatile uint16_t*>(MAGIC_KEY_POS);
  if (older == MAGIC_KEY) older = at_end;
  at_end = 0;
}

}  // namespace

void Watchdog::feed(bool upload_allowed) {
  const bool upload_wanted = (WDTCSR & kTimeoutBits) != kOneSecond;
  if (upload_wanted && upload_allowed) return;
  if (upload_wanted) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
      wdt_enable(WDTO_1S);
      remove_bootloader_key();
    }
  }
  wdt_reset();
}

}  // namespace sequencer
}  // namespace tfsat
