// When the pulses of one servo rise, and how wide they are.
//
// A servo reads a new angle from the width of its next pulse. So that a stroke begins on time, the
// pulse that carries the new width must rise at the stroke's very tick: the frames left are
// stretched or shortened evenly until it does. Gaps stay within 0.75 and 1.5 frames, but for strokes closer than that; at the 0.7 s
// before the first stroke of a drop, within 0.3 ms of a frame of 20 ms.
#pragma once

#include "change_table.h"

namespace tfsat {
namespace sequencer {

struct Pulse {
  tick_t rise;
  uint16_t width_ticks;
  bool begins_change;  // the first pulse of a scheduled width
};

class PulseTrain {
 public:
  // The longest pulse, and time to prepare the next.
  static constexpr uint32_t kShortestGapTicks =
      ticks_from_us(protocol::kServoPulseMaxUs) + kTicksPerMs;

  PulseTrain(ChangeTable& changes, uint8_t joint) : changes_(changes), joint_(joint) {}

  // Starts with `first_rise`, or changes width and frame from the next pulse on.
  void hold(tick_t first_rise, uint16_t width_ticks, uint32_t frame_ticks);
  void stop() { running_ = false; }
  bool running() const { return running_; }

  // The pulse after the last one that next() returned. Call while running().
  Pulse next();
  // `pulse`, the last that next() returned, begins no change after all: it keeps the width before.
  void take_back(Pulse& pulse);

 private:
  void aim_at(const ChangeTable::Change& change);
  uint32_t next_gap(const ChangeTable::Change* change);

  ChangeTable& changes_;
  tick_t last_rise_ = 0;
  uint32_t frame_ticks_ = ticks_from_us(protocol::kServoFrameUs);
  const ChangeTable::Change* aimed_at_ = nullptr;  // the gaps below lead to it
  uint32_t gap_ticks_ = 0;
  uint32_t longer_gaps_ = 0;  // this many are a tick longer
  uint16_t width_ticks_ = 0;
  uint16_t width_before_ticks_ = 0;  // the change that began last
  uint8_t joint_;
  bool running_ = false;
  bool first_ = false;
};

}  // namespace sequencer
}  // namespace tfsat
