#include "pulse_train.h"

namespace tfsat {
namespace sequencer {

constexpr uint32_t PulseTrain::kShortestGapTicks;

void PulseTrain::hold(tick_t first_rise, uint16_t width_ticks, uint32_t frame_ticks) {
  width_ticks_ = width_ticks;
  frame_ticks_ = frame_ticks;
  aimed_at_ = nullptr;
  due_ = nullptr;
  if (running_) return;
  last_rise_ = first_rise;
  running_ = true;
  first_ = true;
}

// The steady frame, stretched or shortened so that a whole number of frames reaches the change. A
// change that is asked for too late begins late rather than cut the pulse before it short. Once a
// change, not once a pulse: these divisions take the AVR longer than all else in its interrupts.
void PulseTrain::aim_at(const ChangeTable::Change& change) {
  aimed_at_ = &change;
  const int32_t left = static_cast<int32_t>(change.at - last_rise_);
  if (left < static_cast<int32_t>(kShortestGapTicks)) {
    gap_ticks_ = kShortestGapTicks;
    longer_gaps_ = 0;
    return;
  }
  uint32_t frames = (static_cast<uint32_t>(left) + frame_ticks_ / 2) / frame_ticks_;
  if (frames == 0) frames = 1;
  gap_ticks_ = static_cast<uint32_t>(left) / frames;
  longer_gaps_ = static_cast<uint32_t>(left) % frames;
}

uint32_t PulseTrain::next_gap(const ChangeTable::Change* change) {
  if (change == nullptr) return frame_ticks_;
  if (change != aimed_at_) aim_at(*change);
  if (longer_gaps_ == 0) return gap_ticks_;
  --longer_gaps_;
  return gap_ticks_ + 1;
}

Pulse PulseTrain::next() {
  ChangeTable::Change* change = changes_.next(joint_);
  if (first_) {
    first_ = false;
  } else {
    last_rise_ += next_gap(change);
  }
  if (change != nullptr && !tick_before(last_rise_, change->at)) {
    change->planned = true;
    due_ = change;
  }
  Pulse pulse;
  pulse.rise = last_rise_;
  pulse.width_ticks = due_ != nullptr ? due_->width_ticks : width_ticks_;
  pulse.change = due_;
  return pulse;
}

void PulseTrain::was_whole(const Pulse& pulse) {
  if (pulse.change == nullptr) return;
  changes_.began(*pulse.change, pulse.rise);
  width_ticks_ = pulse.width_ticks;
  due_ = nullptr;
}

void PulseTrain::cancel(Pulse* pulse) {
  due_ = nullptr;
  if (pulse == nullptr) return;
  pulse->width_ticks = width_ticks_;
  pulse->change = nullptr;
}

}  // namespace sequencer
}  // namespace tfsat
