// A hobby servo: pulse width in, joint angle out. Limp without pulses, and then moved by hand.
#pragma once

#include <cstdint>
#include <memory>

#include "hands.h"
#include "servo_linkage.h"
#include "servo_overshoot.h"

namespace tfsat {
namespace emulator {

struct ServoParameters {
  double reference_pulse_us = 1500.0;
  double reference_angle_rad = 0.7853981633974483;    // 45 deg
  double pulse_us_per_rad = 636.6197723675814;        // 100/9 us per deg; negative: reversed
  double min_pulse_us = 500.0;
  double max_pulse_us = 2500.0;
  double min_angle_rad = 0.0;                         // mechanical stops
  double max_angle_rad = 1.5707963267948966;
  double max_rate_rad_s = 3.4906585039886590;         // 200 deg/s
  double acceleration_rad_s2 = 69.813170079773180;    // 4000 deg/s^2
  uint64_t limp_after_us = 100000;                    // without a pulse
  ServoErrors errors;
};

enum class ServoFault : uint8_t {
  kNone,
  kDead,      // its motor does not turn: the joint stays where it is, and limp
  kSlow,      // it reaches a quarter of its rate
  kReversed,  // pulses mean the mirrored angle: those of the reference pulse stay
};

struct ServoMotion {
  double angle_rad = 0.0, rate_rad_s = 0.0, acceleration_rad_s2 = 0.0;
};

// Time must not run backwards between the calls.
class Servo {
 public:
  explicit Servo(const ServoParameters& parameters, double angle_rad = 0.0);

  // A pulse of this width ended at `t_us`. Widths outside min..max are not servo pulses: ignored.
  void pulse(uint64_t t_us, double width_us);
  // Moves the limp joint by hand: `cycles` times from where it is by `amplitude_rad` and back, one
  // cycle per `period_s`, as angle = start + amplitude sin^4(pi t / period): smooth to the third
  // derivative at both ends. False, and nothing done, while the servo holds the joint or if the
  // swing would leave the mechanical range.
  bool swing(uint64_t t_us, double amplitude_rad, double period_s, unsigned cycles);
  // Moves the limp joint by hand from where it is along the legs, after `lead_s` of rest. False, and nothing
  // done, while the servo holds the joint or if a leg ends outside the mechanical range.
  bool follow(uint64_t t_us, const HandParameters& hand, double lead_s, const std::vector<Leg>& legs);
  // The joint was stopped from outside at this angle (a jig, a hand): it stands there now. A servo
  // that still gets pulses starts again towards its target with the next one.
  void stop_at(uint64_t t_us, double angle_rad);

  // From `t_us` on. A dead servo brakes, a slow one begins its way anew, one that is well again waits for a pulse.
  void set_fault(uint64_t t_us, ServoFault fault);

  bool limp(uint64_t t_us) const { return last_pulse_us_ == kNever || t_us > limp_time_us(); }
  // By a hand, in either way.
  bool swinging(uint64_t t_us) const { return by_hand() && t_us < hand_end_us_; }
  double target_rad() const { return target_rad_; }
  ServoMotion motion(uint64_t t_us);
  // What it draws from the battery (supply.h); nothing while limp.
  double current_A(uint64_t t_us);
  const ServoParameters& parameters() const { return parameters_; }

 private:
  static constexpr uint64_t kNever = UINT64_MAX;
  static constexpr double kSlowPart = 0.25;
  // Less than the board's step of a pulse, more than what its clock rounds a pulse's length by: the same command.
  static constexpr double kSameTarget_rad = 1e-4;
  // Constant-acceleration pieces from a start: speed up, cruise, slow down.
  struct Profile {
    uint64_t start_us = 0;
    double angle_rad = 0.0, rate_rad_s = 0.0;
    double duration_s[3] = {};
    double acceleration_rad_s2[3] = {};
  };
  uint64_t limp_time_us() const { return last_pulse_us_ + parameters_.limp_after_us; }
  double nominal_rad(double width_us) const;
  double rate_limit_rad_s() const;
  void go_to(uint64_t t_us, const ServoMotion& from, double target_rad);
  // The target moved by next to nothing: the motion goes there instead, and keeps what it overshoots.
  void correct(uint64_t t_us, double target_rad);
  ServoOvershoot overshoot(uint64_t t_us, double direction, double peak_rad_s) const;
  void brake(uint64_t t_us, const ServoMotion& from);
  void settle(uint64_t t_us);
  ServoMotion on_profile(uint64_t t_us) const;
  ServoMotion on_trapezoid(uint64_t t_us) const;
  ServoMotion on_swing(uint64_t t_us) const;
  ServoMotion by_hand_at(uint64_t t_us) const;
  bool by_hand() const { return swing_cycles_ != 0 || hand_ != nullptr; }
  bool reachable(double angle_rad) const;
  void begin_by_hand(uint64_t t_us, double duration_s);

  ServoParameters parameters_;
  Profile profile_;
  ServoOvershoot overshoot_;
  double target_rad_;
  uint64_t last_pulse_us_ = kNever;
  bool driven_ = false;  // following pulses; false once limp
  ServoFault fault_ = ServoFault::kNone;
  ServoLinkage linkage_;
  uint64_t hand_start_us_ = 0, hand_end_us_ = 0;
  std::shared_ptr<const JointHand> hand_;
  double swing_from_rad_ = 0.0, swing_amplitude_rad_ = 0.0, swing_period_s_ = 1.0;
  unsigned swing_cycles_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
