#include "servo.h"

#include <cmath>

#include "supply.h"

namespace tfsat {
namespace emulator {
namespace {

double seconds_between(uint64_t from_us, uint64_t to_us) {
  return to_us > from_us ? 1e-6 * static_cast<double>(to_us - from_us) : 0.0;
}

}  // namespace

Servo::Servo(const ServoParameters& parameters, double angle_rad)
    : parameters_(parameters), target_rad_(angle_rad), linkage_(parameters.errors) {
  profile_.angle_rad = angle_rad;
}

void Servo::pulse(uint64_t t_us, double width_us) {
  if (!(width_us >= parameters_.min_pulse_us && width_us <= parameters_.max_pulse_us)) return;
  if (fault_ == ServoFault::kDead) return;
  const ServoMotion now = motion(t_us);
  if (!driven_) linkage_.take_up(now.angle_rad);
  const double goal = linkage_.goal(t_us, nominal_rad(width_us));
  const double target = std::fmax(parameters_.min_angle_rad, std::fmin(parameters_.max_angle_rad, goal));
  if (!driven_ || by_hand() || std::fabs(target - target_rad_) > kSameTarget_rad)
    go_to(t_us, now, target);
  else if (target != target_rad_)
    correct(t_us, target);
  last_pulse_us_ = t_us;
  driven_ = true;
}

double Servo::nominal_rad(double width_us) const {
  const double from_reference = (width_us - parameters_.reference_pulse_us) / parameters_.pulse_us_per_rad;
  return parameters_.reference_angle_rad + (fault_ == ServoFault::kReversed ? -from_reference : from_reference);
}

double Servo::rate_limit_rad_s() const {
  return fault_ == ServoFault::kSlow ? kSlowPart * parameters_.max_rate_rad_s : parameters_.max_rate_rad_s;
}

void Servo::set_fault(uint64_t t_us, ServoFault fault) {
  const ServoMotion now = motion(t_us);
  fault_ = fault;
  if (!driven_) return;
  if (fault == ServoFault::kDead) {
    driven_ = false;
    last_pulse_us_ = kNever;
    brake(t_us, now);
  } else {
    go_to(t_us, now, target_rad_);
  }
}

bool Servo::swing(uint64_t t_us, double amplitude_rad, double period_s, unsigned cycles) {
  const ServoMotion now = motion(t_us);
  if (!limp(t_us) || !(period_s > 0.0) || cycles == 0) return false;
  if (!reachable(now.angle_rad + amplitude_rad)) return false;
  begin_by_hand(t_us, period_s * cycles);
  swing_from_rad_ = now.angle_rad;
  swing_amplitude_rad_ = amplitude_rad;
  swing_period_s_ = period_s;
  swing_cycles_ = cycles;
  return true;
}

bool Servo::follow(uint64_t t_us, const HandParameters& hand, double lead_s, const std::vector<Leg>& legs) {
  const ServoMotion now = motion(t_us);
  if (!limp(t_us)) return false;
  for (const Leg& leg : legs)
    if (!(leg.duration_s > 0.0) || !reachable(leg.target_rad)) return false;
  const LegPath path(now.angle_rad, lead_s, legs);
  begin_by_hand(t_us, path.duration_s());
  hand_ = std::make_shared<const JointHand>(hand, path, parameters_.min_angle_rad, parameters_.max_angle_rad);
  return true;
}

bool Servo::reachable(double angle_rad) const {
  return angle_rad >= parameters_.min_angle_rad && angle_rad <= parameters_.max_angle_rad;
}

void Servo::begin_by_hand(uint64_t t_us, double duration_s) {
  swing_cycles_ = 0;
  hand_.reset();
  hand_start_us_ = t_us;
  hand_end_us_ = t_us + static_cast<uint64_t>(std::llround(1e6 * duration_s));
}

void Servo::stop_at(uint64_t t_us, double angle_rad) {
  swing_cycles_ = 0;
  hand_.reset();
  profile_ = Profile();
  overshoot_ = ServoOvershoot();
  profile_.start_us = t_us;
  profile_.angle_rad = angle_rad;
  driven_ = false;
}

ServoMotion Servo::motion(uint64_t t_us) {
  settle(t_us);
  return by_hand() ? by_hand_at(t_us) : on_profile(t_us);
}

// Lets what has happened by itself since the last call take effect: going limp, the swing's end.
void Servo::settle(uint64_t t_us) {
  if (driven_ && limp(t_us)) {
    driven_ = false;
    brake(limp_time_us(), on_profile(limp_time_us()));
  }
  if (!by_hand() || t_us < hand_end_us_) return;
  // A swing comes back to where it began; rounding must not let it creep.
  stop_at(hand_end_us_, hand_ ? hand_->at(hand_->duration_s()).value : swing_from_rad_);
}

double Servo::current_A(uint64_t t_us) {
  const ServoMotion now = motion(t_us);
  if (!driven_) return 0.0;
  if (std::fabs(now.rate_rad_s) < kServoMoving_rad_s) return kServoHolding_A;
  return now.rate_rad_s * now.acceleration_rad_s2 > 0.0 ? kServoStart_A : kServoRunning_A;
}

ServoMotion Servo::by_hand_at(uint64_t t_us) const {
  if (!hand_) return on_swing(t_us);
  const Jet joint = hand_->at(seconds_between(hand_start_us_, t_us));
  return {joint.value, joint.rate, joint.acceleration};
}

void Servo::go_to(uint64_t t_us, const ServoMotion& from, double target_rad) {
  const double a = parameters_.acceleration_rad_s2;
  // Where braking at once would end decides the direction; overshoot is undone by coming back.
  const double rest = from.angle_rad + from.rate_rad_s * std::fabs(from.rate_rad_s) / (2.0 * a);
  const double direction = target_rad >= rest ? 1.0 : -1.0;
  const double way = direction * (target_rad - from.angle_rad);
  const double rate = direction * from.rate_rad_s;
  const double limit = rate_limit_rad_s() * (direction < 0.0 ? parameters_.errors.closing_share : 1.0);
  const double peak = std::fmin(limit, std::sqrt(std::fmax(0.0, a * way + 0.5 * rate * rate)));
  // It became slow on its way: first it brakes to what it still can.
  const bool too_fast = fault_ == ServoFault::kSlow && rate > peak;
  // From rest the motor takes its time; what it waits for since an earlier pulse is not put off by another.
  const bool waits = driven_ && t_us < profile_.start_us;
  const uint64_t start_us = waits ? profile_.start_us : rate == 0.0 ? t_us + parameters_.errors.delay_us : t_us;
  const double ramps =
      too_fast ? rate * rate / (2.0 * a) : (peak * peak - rate * rate) / (2.0 * a) + peak * peak / (2.0 * a);
  swing_cycles_ = 0;
  hand_.reset();
  target_rad_ = target_rad;
  profile_ = Profile();
  profile_.start_us = start_us;
  profile_.angle_rad = from.angle_rad;
  profile_.rate_rad_s = from.rate_rad_s;
  profile_.duration_s[0] = too_fast ? (rate - peak) / a : std::fmax(0.0, (peak - rate) / a);
  profile_.duration_s[1] = peak > 0.0 ? std::fmax(0.0, (way - ramps) / peak) : 0.0;
  profile_.duration_s[2] = peak / a;
  profile_.acceleration_rad_s2[0] = too_fast ? -direction * a : direction * a;
  profile_.acceleration_rad_s2[2] = -direction * a;
  overshoot_ = overshoot(start_us, direction, peak);
}

void Servo::correct(uint64_t t_us, double target_rad) {
  const ServoOvershoot kept = overshoot_;
  go_to(t_us, on_trapezoid(t_us), target_rad);
  overshoot_ = kept;
}

// By the energy that it brakes: the square of its rate. A stop of the mechanics ends it.
ServoOvershoot Servo::overshoot(uint64_t t_us, double direction, double peak_rad_s) const {
  const double part = peak_rad_s / parameters_.max_rate_rad_s;
  const double room =
      direction > 0.0 ? parameters_.max_angle_rad - target_rad_ : target_rad_ - parameters_.min_angle_rad;
  const double size = std::fmin(parameters_.errors.overshoot_rad * part * part, room);
  return {t_us, profile_.duration_s[0] + profile_.duration_s[1], profile_.duration_s[2], direction * size};
}

void Servo::brake(uint64_t t_us, const ServoMotion& from) {
  const double a = parameters_.acceleration_rad_s2;
  profile_ = Profile();
  overshoot_ = ServoOvershoot();
  profile_.start_us = t_us;
  profile_.angle_rad = from.angle_rad;
  profile_.rate_rad_s = from.rate_rad_s;
  profile_.duration_s[0] = std::fabs(from.rate_rad_s) / a;
  profile_.acceleration_rad_s2[0] = from.rate_rad_s > 0.0 ? -a : a;
}

ServoMotion Servo::on_profile(uint64_t t_us) const {
  const ServoMotion m = on_trapezoid(t_us);
  if (overshoot_.none()) return m;
  const Jet beyond = overshoot_.at(t_us);
  return {m.angle_rad + beyond.value, m.rate_rad_s + beyond.rate, m.acceleration_rad_s2 + beyond.acceleration};
}

ServoMotion Servo::on_trapezoid(uint64_t t_us) const {
  double left = seconds_between(profile_.start_us, t_us);
  ServoMotion m;
  m.angle_rad = profile_.angle_rad;
  m.rate_rad_s = profile_.rate_rad_s;
  if (t_us < profile_.start_us) return m;  // its delay is not over
  for (int i = 0; i < 3; ++i) {
    const double a = profile_.acceleration_rad_s2[i];
    const bool inside = left < profile_.duration_s[i];
    const double t = inside ? left : profile_.duration_s[i];
    m.angle_rad += m.rate_rad_s * t + 0.5 * a * t * t;
    m.rate_rad_s += a * t;
    if (inside) {
      m.acceleration_rad_s2 = a;
      return m;
    }
    left -= t;
  }
  m.rate_rad_s = 0.0;  // what is left of it is rounding
  if (driven_) m.angle_rad = target_rad_;
  return m;
}

ServoMotion Servo::on_swing(uint64_t t_us) const {
  const Jet swung = there_and_back(seconds_between(hand_start_us_, t_us), swing_period_s_, swing_amplitude_rad_);
  return {swing_from_rad_ + swung.value, swung.rate, swung.acceleration};
}

}  // namespace emulator
}  // namespace tfsat
