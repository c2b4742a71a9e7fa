#include "hands.h"

namespace tfsat {
namespace emulator {
namespace {

constexpr Band kTremor{2.0, 8.0};
constexpr Band kSway{0.3, 6.0};

Vec3 random_direction(Noise& random) {
  Vec3 v;
  do {
    v = {random.normal(), random.normal(), random.normal()};
  } while (norm(v) < 1e-6);
  return (1.0 / norm(v)) * v;
}

}  // namespace

JointHand::JointHand(const HandParameters& parameters, const LegPath& path, double min_angle_rad,
                     double max_angle_rad)
    : path_(path), min_angle_rad_(min_angle_rad), max_angle_rad_(max_angle_rad) {
  Noise random(parameters.seed);
  if (parameters.tremor_rad_s > 0.0) tremor_ = Shake(parameters.tremor_rad_s, kTremor, random);
}

Jet JointHand::at(double t_s) const {
  const Jet way = path_.at(t_s);
  const double bound = tremor_.bound_rad();
  if (bound == 0.0) return way;
  const Jet above{way.value - min_angle_rad_, way.rate, way.acceleration};
  const Jet below{max_angle_rad_ - way.value, -way.rate, -way.acceleration};
  return way + path_.unrest(t_s) * distance_factor(above, bound) * distance_factor(below, bound) * tremor_.at(t_s);
}

HoldingHand::HoldingHand(const HandParameters& parameters) : reaction_(parameters.reaction) {
  Noise random(parameters.seed ^ 0x5A4Au);
  for (Shake& sway : sway_)
    if (parameters.sway_rad_s > 0.0) sway = Shake(parameters.sway_rad_s, kSway, random);
  give_way_axis_ = random_direction(random);
}

HoldingHand HoldingHand::beside(const HandParameters& parameters, const LegPath& path, double joint_angle_rad) {
  HoldingHand hand(parameters);
  hand.path_ = path;
  hand.joint_start_rad_ = joint_angle_rad;
  return hand;
}

HoldingHand HoldingHand::against_servo(const HandParameters& parameters, double lead_s, double joint_angle_rad) {
  HoldingHand hand(parameters);
  hand.endless_ = true;
  hand.lead_s_ = lead_s;
  hand.joint_start_rad_ = joint_angle_rad;
  return hand;
}

HoldingHand HoldingHand::turning(const HandParameters& parameters, const Vec3& axis, const LegPath& path) {
  HoldingHand hand(parameters);
  hand.path_ = path;
  hand.axis_ = axis;
  hand.turns_ = true;
  hand.reaction_ = 0.0;  // no joint moves
  return hand;
}

Jet HoldingHand::unrest(double t_s) const {
  return endless_ ? smooth_step(t_s - lead_s_, kUnrestFade_s) : path_.unrest(t_s);
}

Turning HoldingHand::at(double t_s, const Jet& joint) const {
  const Vec3 axes[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  Turning motion;
  if (turns_) motion = turning_about(axis_, path_.at(t_s));
  if (reaction_ != 0.0) {
    const Jet moved{joint.value - joint_start_rad_, joint.rate, joint.acceleration};
    motion = compose(motion, turning_about(give_way_axis_, reaction_ * moved));
  }
  const Jet unrest_now = unrest(t_s);
  for (int i = 0; i < 3; ++i)
    if (sway_[i].bound_rad() > 0.0)
      motion = compose(motion, turning_about(axes[i], unrest_now * sway_[i].at(t_s)));
  return motion;
}

}  // namespace emulator
}  // namespace tfsat
