// The release switches: D4 on input capture 1, D13 on input capture 3, with pull-ups. Closed pulls
// the pin low, open reads high. The timers stamp each edge; the counts are equal (see TickClock).
//
// D13 also has the board's LED. Where no buffer stands between them, the LED holds an open switch
// near 2 V against the internal pull-up, no safe high: docs/wiring.md says what to fit.
#pragma once

#include "../core/ports.h"

namespace tfsat {
namespace sequencer {

class ReleaseCapture : public ReleaseSwitches {
 public:
  // Call after TickClock::begin().
  void begin();

  bool take_edge(SwitchEdge& edge) override;
  uint8_t levels() override;

  // For the interrupts.
  void on_capture(uint8_t index);

 private:
  static constexpr uint8_t kQueueSize = 32;  // power of two

  void push(tick_t at, uint8_t index, bool open);
  void aim(uint8_t index);
  SwitchEdge& in_queue(int place) { return queue_[place & (kQueueSize - 1)]; }

  SwitchEdge queue_[kQueueSize];
  uint8_t head_ = 0;   // next to take
  uint8_t count_ = 0;  // changed with interrupts off
};

}  // namespace sequencer
}  // namespace tfsat
