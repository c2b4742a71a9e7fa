// What lies between a servo's command and its arm: gain, offset, play, and stopping never twice at the same place.
// What the arm does about that place is the servo's: servo_overshoot.h.
#pragma once

#include <cstdint>

#include "../sensors/noise.h"

namespace tfsat {
namespace emulator {

// The defaults change no angle, not even by rounding.
struct ServoErrors {
  double gain = 1.0;           // the angle for a pulse is offset + gain * (the pulse's nominal angle)
  double offset_rad = 0.0;
  double backlash_rad = 0.0;   // a motion ends half of it short of its target
  double repeat_rad = 0.0;     // standard deviation of where a motion ends
  double overshoot_rad = 0.0;  // a motion at the full rate runs so far beyond its end and comes back
  uint64_t delay_us = 0;         // from a pulse's end to the first motion of a joint at rest
  double closing_share = 1.0;    // of its greatest rate, towards smaller angles
  uint64_t seed = 1;
};

class ServoLinkage {
 public:
  explicit ServoLinkage(const ServoErrors& errors) : errors_(errors), random_(errors.seed) {}

  // The joint stands here without a drive, at a pulse's coming.
  void take_up(double angle_rad);
  // Where a pulse of this nominal angle sends the joint. A motion begins when the command changes after it has
  // stood, turns back, or after `take_up`; each draws where it will stop anew. What it drew takes effect over
  // the first degrees of the way, so that a jog's small steps have no jumps.
  double goal(uint64_t t_us, double nominal_rad);

 private:
  void draw(uint64_t t_us, double step_rad);

  ServoErrors errors_;
  Noise random_;
  double command_rad_ = 0.0;
  double arm_rad_ = 0.0;      // within the play about the command
  double stop_rad_ = 0.0;     // how far from there it stops
  double drawn_rad_ = 0.0;    // what that is on its way to
  double direction_ = 0.0;    // of the motion; 0: none yet
  uint64_t changed_us_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
