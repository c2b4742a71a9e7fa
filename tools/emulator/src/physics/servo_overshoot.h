// A joint that runs beyond where its motion ends, and comes back.
#pragma once

#include <cstdint>

#include "jet.h"

namespace tfsat {
namespace emulator {

// It begins when the motion begins to brake, is at its farthest when the motion by itself has ended, and is gone
// after as long again. Smooth to the third derivative, and monotonic with a motion that brakes steadily: what was
// on its way does not stop before the turn.
class ServoOvershoot {
 public:
  ServoOvershoot() = default;  // none
  // Of a motion that begins to brake so long after `t_us`; signed.
  ServoOvershoot(uint64_t t_us, double until_braking_s, double braking_s, double size_rad)
      : from_us_(t_us), until_s_(until_braking_s), duration_s_(2.0 * braking_s), size_rad_(size_rad) {}

  bool none() const { return size_rad_ == 0.0; }
  // What it adds to the motion.
  Jet at(uint64_t t_us) const {
    const double since_s = (t_us > from_us_ ? 1e-6 * static_cast<double>(t_us - from_us_) : 0.0) - until_s_;
    return since_s > 0.0 && since_s < duration_s_ ? there_and_back(since_s, duration_s_, size_rad_) : Jet();
  }

 private:
  uint64_t from_us_ = 0;
  double until_s_ = 0.0, duration_s_ = 0.0, size_rad_ = 0.0;
};

}  // namespace emulator
}  // namespace tfsat
