#include "reset_cause.h"

#include <avr/io.h>
#include <avr/wdt.h>

#include "ram_paint.h"

namespace tfsat {
namespace sequencer {

using protocol::ResetCause;

namespace {

// Start-up code leaves it alone.
uint8_t flags_at_reset __attribute__((section(".noinit")));

}  // namespace

// Part of start-up, before .data and .bss are set up: after a watchdog reset the watchdog is on
// with its shortest timeout, and WDRF must be cleared before another can be set (datasheet
// section 8.2). From here on it is on.
extern "C" void tfsat_save_reset_flags(void) __attribute__((naked, used, section(".init3")));
extern "C" void tfsat_save_reset_flags(void) {
  flags_at_reset = MCUSR;
  MCUSR = 0;
  wdt_enable(WDTO_1S);
}

// At power-on the supply also passes the brown-out threshold, so PORF goes first.
ResetCause take_reset_cause() {
  if ((flags_at_reset & _BV(PORF)) != 0) return ResetCause::kPowerOn;
  if ((flags_at_reset & _BV(WDRF)) != 0) return ResetCause::kWatchdog;
  if ((flags_at_reset & _BV(BORF)) != 0) return ResetCause::kBrownOut;
  if ((flags_at_reset & _BV(EXTRF)) != 0) return ResetCause::kExternal;
  return RamPaint::survived() ? ResetCause::kUnknown : ResetCause::kPowerOn;
}

}  // namespace sequencer
}  // namespace tfsat
