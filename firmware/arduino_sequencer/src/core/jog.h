// A joint on its slow way to an angle, for calibration.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

class Jog {
 public:
  void start(uint8_t joint, int16_t from_cdeg, uint32_t now_ms) {
    joint_ = joint;
    angle_cdeg_ = from_cdeg;
    target_cdeg_ = from_cdeg;
    moved_ms_ = now_ms;
    rest_ = 0;
  }

  void go_to(int16_t target_cdeg, uint32_t now_ms) {
    if (arrived()) moved_ms_ = now_ms;
    target_cdeg_ = target_cdeg;
    ordered_ms_ = now_ms;
  }

  // True when the commanded angle has changed.
  bool advance(uint32_t now_ms) {
    bool changed = false;
    for (; moved_ms_ != now_ms && !arrived(); ++moved_ms_) {
      rest_ = static_cast<uint16_t>(rest_ + protocol::kJogSpeedCdegS);
      while (rest_ >= 1000 && !arrived()) {
        rest_ = static_cast<uint16_t>(rest_ - 1000);
        angle_cdeg_ = static_cast<int16_t>(angle_cdeg_ + (target_cdeg_ > angle_cdeg_ ? 1 : -1));
        changed = true;
      }
    }
    return changed;
  }

  uint8_t joint() const { return joint_; }  // 1 to 3
  int16_t angle_cdeg() const { return angle_cdeg_; }
  bool arrived() const { return angle_cdeg_ == target_cdeg_; }
  bool idle(uint32_t now_ms) const { return now_ms - ordered_ms_ >= protocol::kJogIdleMs; }

 private:
  // No initial values: `Jog jog{}` is all zeros, by one loop instead of byte for byte.
  uint32_t moved_ms_;
  uint32_t ordered_ms_;
  int16_t angle_cdeg_;
  int16_t target_cdeg_;
  uint16_t rest_;  // thousandths of 0.01 deg
  uint8_t joint_;
};

}  // namespace sequencer
}  // namespace tfsat
