// The release switches: D4 on input capture 1, D13 on input capture 3, with pull-ups. Closed pulls
// the pin low, open reads high. The timers stamp each edge; the counts are equal (see TickClock).
//
// D13 also has the board's LED. Where no buffer stands between them, the LED holds an open switch
// near 2 V against the internal pull-up, no safe high: docs/wiring.md says what to fit.
#pragma once

#include "../core/ports.h"

namespace tfsat {
namespace sequencer {

// There is one: its interrupts keep what they share with it in release_capture.cpp.
class ReleaseCapture : public ReleaseSwitches {
 public:
  // Call after TickClock::begin().
  void begin();

  bool take_edge(SwitchEdge& edge) override;
  uint8_t levels() override;

  // Contacts chattered for longer than an interrupt may follow: until levels() nothing is captured.
  static bool gave_up();
  // Call once a round of the main loop. True while the switches have moved in each round of late, though
  // not for so long that no contact chatters on: a line rattles, and a host must come through.
  static bool chattering(tick_t now);
};

}  // namespace sequencer
}  // namespace tfsat
