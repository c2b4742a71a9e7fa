#include "servo.h"

#include <cmath>

namespace tfsat {
namespace emulator {
namespace {

constexpr double kPi = 3.14159265358979323846;

double seconds_between(uint64_t from_us, uint64_t to_us) {
  return to_us > from_us ? 1e-6 * static_cast<double>(to_us - from_us) : 0.0;
}

}  // namespace

Servo::Servo(const ServoParameters& parameters, double angle_rad)
    : parameters_(parameters), target_rad_(angle_rad) {
  profile_.angle_rad = angle_rad;
}

void Servo::pulse(uint64_t t_us, double width_us) {
  if (!(width_us >= parameters_.min_pulse_us && width_us <= parameters_.max_pulse_us)) return;
  const ServoMotion now = motion(t_us);
  double target = parameters_.reference_angle_rad +
                  (width_us - parameters_.reference_pulse_us) / parameters_.pulse_us_per_rad;
  target = std::fmax(parameters_.min_angle_rad, std::fmin(parameters_.max_angle_rad, target));
  if (!driven_ || swing_cycles_ != 0 || target != target_rad_) go_to(t_us, now, target);
  last_pulse_us_ = t_us;
  driven_ = true;
}

bool Servo::swing(uint64_t t_us, double amplitude_rad, double period_s, unsigned cycles) {
  const ServoMotion now = motion(t_us);
  const double far = now.angle_rad + amplitude_rad;
  if (!limp(t_us) || !(period_s > 0.0) || cycles == 0) return false;
  if (!(far >= parameters_.min_angle_rad && far <= parameters_.max_angle_rad)) return false;
  swing_start_us_ = t_us;
  swing_end_us_ = t_us + static_cast<uint64_t>(std::llround(1e6 * period_s * cycles));
  swing_from_rad_ = now.angle_rad;
  swing_amplitude_rad_ = amplitude_rad;
  swing_period_s_ = period_s;
  swing_cycles_ = cycles;
  return true;
}

void Servo::stop_at(uint64_t t_us, double angle_rad) {
  swing_cycles_ = 0;
  profile_ = Profile();
  profile_.start_us = t_us;
  profile_.angle_rad = angle_rad;
  driven_ = false;
}

ServoMotion Servo::motion(uint64_t t_us) {
  settle(t_us);
  return swing_cycles_ != 0 ? on_swing(t_us) : on_profile(t_us);
}

// Lets what has happened by itself since the last call take effect: going limp, the swing's end.
void Servo::settle(uint64_t t_us) {
  if (driven_ && limp(t_us)) {
    driven_ = false;
    brake(limp_time_us(), on_profile(limp_time_us()));
  }
  if (swing_cycles_ != 0 && t_us >= swing_end_us_) stop_at(swing_end_us_, swing_from_rad_);
}

void Servo::go_to(uint64_t t_us, const ServoMotion& from, double target_rad) {
  const double a = parameters_.acceleration_rad_s2;
  // Where braking at once would end decides the direction; overshoot is undone by coming back.
  const double rest = from.angle_rad + from.rate_rad_s * std::fabs(from.rate_rad_s) / (2.0 * a);
  const double direction = target_rad >= rest ? 1.0 : -1.0;
  const double way = direction * (target_rad - from.angle_rad);
  const double rate = direction * from.rate_rad_s;
  const double peak = std::fmin(parameters_.max_rate_rad_s,
                                std::sqrt(std::fmax(0.0, a * way + 0.5 * rate * rate)));
  const double ramps = (peak * peak - rate * rate) / (2.0 * a) + peak * peak / (2.0 * a);
  swing_cycles_ = 0;
  target_rad_ = target_rad;
  profile_ = Profile();
  profile_.start_us = t_us;
  profile_.angle_rad = from.angle_rad;
  profile_.rate_rad_s = from.rate_rad_s;
  profile_.duration_s[0] = std::fmax(0.0, (peak - rate) / a);
  profile_.duration_s[1] = peak > 0.0 ? std::fmax(0.0, (way - ramps) / peak) : 0.0;
  profile_.duration_s[2] = peak / a;
  profile_.acceleration_rad_s2[0] = direction * a;
  profile_.acceleration_rad_s2[2] = -direction * a;
}

void Servo::brake(uint64_t t_us, const ServoMotion& from) {
  const double a = parameters_.acceleration_rad_s2;
  profile_ = Profile();
  profile_.start_us = t_us;
  profile_.angle_rad = from.angle_rad;
  profile_.rate_rad_s = from.rate_rad_s;
  profile_.duration_s[0] = std::fabs(from.rate_rad_s) / a;
  profile_.acceleration_rad_s2[0] = from.rate_rad_s > 0.0 ? -a : a;
}

ServoMotion Servo::on_profile(uint64_t t_us) const {
  double left = seconds_between(profile_.start_us, t_us);
  ServoMotion m;
  m.angle_rad = profile_.angle_rad;
  m.rate_rad_s = profile_.rate_rad_s;
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
  const double k = kPi / swing_period_s_;
  const double phase = k * seconds_between(swing_start_us_, t_us);
  const double s = std::sin(phase), c = std::cos(phase);
  ServoMotion m;
  m.angle_rad = swing_from_rad_ + swing_amplitude_rad_ * s * s * s * s;
  m.rate_rad_s = 4.0 * k * swing_amplitude_rad_ * s * s * s * c;
  m.acceleration_rad_s2 = 4.0 * k * k * swing_amplitude_rad_ * s * s * (3.0 * c * c - s * s);
  return m;
}

}  // namespace emulator
}  // namespace tfsat
