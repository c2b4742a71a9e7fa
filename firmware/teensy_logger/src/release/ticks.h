// Copied from firmware/arduino_sequencer/src/core/ticks.h by tools/generate_protocol.py.
// Time on the sequencer: ticks of half a microsecond, as the ATmega32U4's timers count them.
#ifndef TFSAT_RELEASE_TICKS_H
#define TFSAT_RELEASE_TICKS_H

#include <stdint.h>

namespace tfsat {
namespace sequencer {

// 16 MHz / 8. Wraps after 35.8 minutes: compare with tick_before() only, over less than half of
// that.
typedef uint32_t tick_t;

constexpr uint32_t kTicksPerUs = 2;
constexpr uint32_t kTicksPerMs = 2000;

constexpr tick_t ticks_from_us(uint32_t us) { return us * kTicksPerUs; }

constexpr uint32_t us_from_ticks(uint32_t ticks) { return ticks / kTicksPerUs; }

inline bool tick_before(tick_t a, tick_t b) { return static_cast<int32_t>(a - b) < 0; }

}  // namespace sequencer
}  // namespace tfsat

#endif
