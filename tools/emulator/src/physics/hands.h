// A person's hands at the bench: one moves a joint, the other holds bodies or turns the whole robot.
#pragma once

#include <cstdint>
#include <vector>

#include "leg_path.h"
#include "shake.h"
#include "turning.h"

namespace tfsat {
namespace emulator {

// One person's way with one motion; all zero: a machine's.
struct HandParameters {
  uint64_t seed = 1;
  double tremor_rad_s = 0.0;  // rms rate of the joint on top of its path
  double sway_rad_s = 0.0;    // rms rate of held bodies about each of their axes
  double reaction = 0.0;      // held bodies give way by this much of the joint's angle
};

// The hand that moves a joint. Its tremor keeps away from the joint's mechanical stops.
class JointHand {
 public:
  JointHand() = default;
  JointHand(const HandParameters& parameters, const LegPath& path, double min_angle_rad, double max_angle_rad);

  Jet at(double t_s) const;
  double duration_s() const { return path_.duration_s(); }

 private:
  LegPath path_;
  Shake tremor_;
  double min_angle_rad_ = 0.0, max_angle_rad_ = 0.0;
};

// The hand that holds bodies: how they turn against where they were when it took hold.
class HoldingHand {
 public:
  HoldingHand() = default;  // holds still
  // Holds while the path of another hand moves the joint; sways while that is on its way.
  static HoldingHand beside(const HandParameters& parameters, const LegPath& path, double joint_angle_rad);
  // Holds while a servo moves the joint, for as long as it takes.
  static HoldingHand against_servo(const HandParameters& parameters, double lead_s, double joint_angle_rad);
  // Turns all that it holds about `axis` (holder's frame) along the path of the angle.
  static HoldingHand turning(const HandParameters& parameters, const Vec3& axis, const LegPath& path);

  // `joint` is the joint that moves, where one does.
  Turning at(double t_s, const Jet& joint) const;
  double duration_s() const { return turns_ ? path_.duration_s() : 0.0; }

 private:
  explicit HoldingHand(const HandParameters& parameters);
  Jet unrest(double t_s) const;

  Shake sway_[3];
  Vec3 give_way_axis_{1.0, 0.0, 0.0};
  double reaction_ = 0.0, joint_start_rad_ = 0.0;
  LegPath path_;
  Vec3 axis_{0.0, 0.0, 1.0};
  bool turns_ = false;
  bool endless_ = false;
  double lead_s_ = 0.0;
};

}  // namespace emulator
}  // namespace tfsat
