#include "reset_cause.h"

#include <avr/io.h>
#include <avr/wdt.h>

namespace tfsat {
namespace sequencer {

using protocol::ResetCause;

namespace {

constexpr uint32_t kMark = 0x5EC0DE5A;

// Neither is touched by start-up code. The bootloader's own variables lie below.
uint8_t flags_at_reset __attribute__((section(".noinit")));
uint32_t mark_of_last_run __attribute__((section(".noinit")));

}  // namespace

// Part of start-up, before .data and .bss are set up: after a watchdog reset the watchdog is on
// with its shortest timeout, and WDRF must be cleared before it can be turned off (datasheet
// section 8.2).
extern "C" void tfsat_save_reset_flags(void) __attribute__((naked, used, section(".init3")));
extern "C" void tfsat_save_reset_flags(void) {
  flags_at_reset = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

// At power-on the supply also passes the brown-out threshold, so PORF goes first.
ResetCause take_reset_cause() {
  const bool ram_kept = mark_of_last_run == kMark;
  mark_of_last_run = kMark;
  if ((flags_at_reset & _BV(PORF)) != 0) return ResetCause::kPowerOn;
  if ((flags_at_reset & _BV(WDRF)) != 0) return ResetCause::kWatchdog;
  if ((flags_at_reset & _BV(BORF)) != 0) return ResetCause::kBrownOut;
  if ((flags_at_reset & _BV(EXTRF)) != 0) return ResetCause::kExternal;
  return ram_kept ? ResetCause::kUnknown : ResetCause::kPowerOn;
}

}  // namespace sequencer
}  // namespace tfsat
