#include "servo_linkage.h"

#include <cmath>

namespace tfsat {
namespace emulator {
namespace {

constexpr uint64_t kStood_us = 300000;
constexpr double kSettlingWay_rad = 0.0872664625997164788;  // 5 deg

}  // namespace

void ServoLinkage::take_up(double angle_rad) {
  command_rad_ = arm_rad_ = angle_rad;
  stop_rad_ = drawn_rad_ = 0.0;
  direction_ = 0.0;
}

double ServoLinkage::goal(uint64_t t_us, double nominal_rad) {
  const double command = errors_.offset_rad + errors_.gain * nominal_rad;
  draw(t_us, command - command_rad_);
  command_rad_ = command;
  const double play = 0.5 * errors_.backlash_rad;
  arm_rad_ = std::fmax(command - play, std::fmin(command + play, arm_rad_));
  return arm_rad_ + stop_rad_;
}

void ServoLinkage::draw(uint64_t t_us, double step_rad) {
  if (errors_.repeat_rad == 0.0 || step_rad == 0.0) return;
  const double direction = step_rad > 0.0 ? 1.0 : -1.0;
  if (direction != direction_ || t_us - changed_us_ > kStood_us) drawn_rad_ = errors_.repeat_rad * random_.normal();
  direction_ = direction;
  changed_us_ = t_us;
  stop_rad_ += (drawn_rad_ - stop_rad_) * std::fmin(1.0, std::fabs(step_rad) / kSettlingWay_rad);
}

}  // namespace emulator
}  // namespace tfsat
