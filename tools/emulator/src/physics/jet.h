// A quantity of time with its first two derivatives, and what can be made of such.
#pragma once

#include <cmath>

namespace tfsat {
namespace emulator {

struct Jet {
  double value = 0.0, rate = 0.0, acceleration = 0.0;
};

inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.rate + b.rate, a.acceleration + b.acceleration};
}
inline Jet operator*(double s, const Jet& a) { return {s * a.value, s * a.rate, s * a.acceleration}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.acceleration * b.value + 2.0 * a.rate * b.rate + a.value * b.acceleration};
}

// From 0 to 1 in `duration_s` with neither speed nor acceleration at the ends: the path of least jerk, which
// is how people move (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985).
inline Jet smooth_step(double t_s, double duration_s) {
  if (t_s <= 0.0) return {};
  if (t_s >= duration_s) return {1.0, 0.0, 0.0};
  const double u = t_s / duration_s, left = 1.0 - u;
  return {u * u * u * (10.0 + u * (6.0 * u - 15.0)), 30.0 * u * u * left * left / duration_s,
          60.0 * u * left * (1.0 - 2.0 * u) / (duration_s * duration_s)};
}

// size sin^4(pi t / period): from 0 to the size and back once a period, smooth to the third derivative at its zeros.
inline Jet there_and_back(double t_s, double period_s, double size) {
  const double k = 3.14159265358979323846 / period_s;
  const double s = std::sin(k * t_s), c = std::cos(k * t_s);
  return {size * s * s * s * s, 4.0 * k * size * s * s * s * c, 4.0 * k * k * size * s * s * (3.0 * c * c - s * s)};
}

// How far a quantity that must not be negative is from there: 0 at 0 with no slope, 1 far off, one half at
// `scale`. The product with anything that never exceeds 2 `scale` never exceeds the quantity itself.
inline Jet distance_factor(const Jet& distance, double scale) {
  const double d = distance.value, s2 = scale * scale, sum = d * d + s2;
  const double slope = 2.0 * d * s2 / (sum * sum);
  const double bend = 2.0 * s2 * (s2 - 3.0 * d * d) / (sum * sum * sum);
  return {d * d / sum, slope * distance.rate,
          slope * distance.acceleration + bend * distance.rate * distance.rate};
}

}  // namespace emulator
}  // namespace tfsat
