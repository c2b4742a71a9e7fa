#include "pulse_train.h"

namespace tfsat {
namespace sequencer {

constexpr uint32_t PulseTrain::kFrameTicks;
constexpr uint32_t PulseTrain::kShortestGapTicks;

void PulseTrain::hold(tick_t first_rise, uint16_t width_ticks) {
  change_count_ = 0;
  change_next_ = 0;
  width_ticks_ = width_ticks;
  if (running_) return;
  last_rise_ = first_rise;
  running_ = true;
  first_ = true;
}

bool PulseTrain::schedule(tick_t at, uint16_t width_ticks) {
  if (change_count_ == kMaxChanges) return false;
  changes_[change_count_].at = at;
  changes_[change_count_].width_ticks = width_ticks;
  ++change_count_;
  return true;
}

void PulseTrain::stop() {
  running_ = false;
  change_count_ = 0;
  change_next_ = 0;
}

// The steady frame, stretched or shortened so that a whole number of frames reaches the next change.
// A change that is asked for too late begins late rather than cut the pulse before it short.
uint32_t PulseTrain::gap_to_next_rise() const {
  if (change_next_ == change_count_) return kFrameTicks;
  const int32_t left = static_cast<int32_t>(changes_[change_next_].at - last_rise_);
  if (left < static_cast<int32_t>(kShortestGapTicks)) return kShortestGapTicks;
  const uint32_t frames = (static_cast<uint32_t>(left) + kFrameTicks / 2) / kFrameTicks;
  return frames < 2 ? static_cast<uint32_t>(left) : static_cast<uint32_t>(left) / frames;
}

Pulse PulseTrain::next() {
  Pulse pulse;
  pulse.begins_change = false;
  if (first_) {
    first_ = false;
  } else {
    last_rise_ += gap_to_next_rise();
  }
  if (change_next_ < change_count_ && !tick_before(last_rise_, changes_[change_next_].at)) {
    width_ticks_ = changes_[change_next_].width_ticks;
    ++change_next_;
    pulse.begins_change = true;
  }
  pulse.rise = last_rise_;
  pulse.width_ticks = width_ticks_;
  return pulse;
}

}  // namespace sequencer
}  // namespace tfsat
