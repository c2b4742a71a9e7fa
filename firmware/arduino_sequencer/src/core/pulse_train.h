// When the pulses of one servo rise, and how wide they are.
//
// A servo reads a new angle from the width of its next pulse. So that a stroke begins on time, the
// pulse that carries the new width must rise at the stroke's very tick: the frames left are
// stretched or shortened evenly until it does. Gaps stay within 0.75 and 1.5 frames, but for strokes closer than that; at the 0.7 s
// before the first stroke of a drop, within 0.3 ms of a frame of 20 ms.
//
// A servo has got a new width only when a whole pulse of it was on the pin. Until then each pulse of
// that width is the one that may begin the change; the next change of the joint takes its place.
#pragma once

#include "change_table.h"

namespace tfsat {
namespace sequencer {

struct Pulse {
  tick_t rise;
  uint16_t width_ticks;
  ChangeTable::Change* change;  // that this pulse begins if it is whole on its pin, or null
};

class PulseTrain {
 public:
  // The longest pulse, and time to prepare the next.
  static constexpr uint32_t kShortestGapTicks =
      ticks_from_us(protocol::kServoPulseMaxUs) + kTicksPerMs;

  PulseTrain(ChangeTable& changes, uint8_t joint) : changes_(changes), joint_(joint) {}

  // Starts with `first_rise`, or changes width and frame from the next pulse on.
  void hold(tick_t first_rise, uint16_t width_ticks, uint32_t frame_ticks);
  void stop() {
    running_ = false;
    due_ = nullptr;
  }
  bool running() const { return running_; }

  // The pulse after the last one that next() returned. Call while running().
  Pulse next();
  // The pulse that next() returned last was whole on its pin.
  void was_whole(const Pulse& pulse);
  // No more changes. `pulse`, the last that next() returned, keeps the width before, if given.
  void cancel(Pulse* pulse);

 private:
  void aim_at(const ChangeTable::Change& change);
  uint32_t next_gap(const ChangeTable::Change* change);

  ChangeTable& changes_;
  tick_t last_rise_ = 0;
  uint32_t frame_ticks_ = ticks_from_us(protocol::kServoFrameUs);
  const ChangeTable::Change* aimed_at_ = nullptr;  // the gaps below lead to it
  ChangeTable::Change* due_ = nullptr;             // its time has come, it has not begun
  uint32_t gap_ticks_ = 0;
  uint32_t longer_gaps_ = 0;  // this many are a tick longer
  uint16_t width_ticks_ = 0;  // that the servo has
  uint8_t joint_;
  bool running_ = false;
  bool first_ = false;
};

}  // namespace sequencer
}  // namespace tfsat
