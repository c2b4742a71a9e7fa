// When the pulses of one servo rise, and how wide they are.
//
// A servo reads a new angle from the width of its next pulse. So that a stroke begins on time, the
// pulse that carries the new width must rise at the stroke's very tick: the frames left are stretched
// or shortened evenly until it does. With more than 30 ms to go, gaps stay within 15 to 30 ms (16-bit
// timers count 32.7 ms); at the 0.7 s of a drop, within 0.3 ms of the steady frame.
#pragma once

#include "ticks.h"

namespace tfsat {
namespace sequencer {

struct Pulse {
  tick_t rise;
  uint16_t width_ticks;
  bool begins_change;  // the first pulse of a scheduled width
};

class PulseTrain {
 public:
  static constexpr uint32_t kFrameTicks = 20 * kTicksPerMs;
  static constexpr uint32_t kShortestGapTicks = 5 * kTicksPerMs;  // longest pulse, and time to be over
  static constexpr uint8_t kMaxChanges = 16;

  // Starts with `first_rise`, or changes the width from the next pulse on; forgets the schedule.
  void hold(tick_t first_rise, uint16_t width_ticks);
  // Appends a change. It must lie at least one frame after the one before; `false` if the queue is full.
  bool schedule(tick_t at, uint16_t width_ticks);
  void stop();
  bool running() const { return running_; }

  // The pulse after the last one that next() returned. Call while running().
  Pulse next();

 private:
  struct Change {
    tick_t at;
    uint16_t width_ticks;
  };

  uint32_t gap_to_next_rise() const;

  Change changes_[kMaxChanges];
  uint8_t change_count_ = 0;
  uint8_t change_next_ = 0;
  tick_t last_rise_ = 0;
  uint16_t width_ticks_ = 0;
  bool running_ = false;
  bool first_ = false;
};

}  // namespace sequencer
}  // namespace tfsat
