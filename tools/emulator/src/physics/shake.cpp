#include "shake.h"

#include <cmath>

namespace tfsat {
namespace emulator {

Shake::Shake(double rms_rate_rad_s, Band band, Noise& random) {
  constexpr double kTurn = 6.283185307179586477;
  const double n = static_cast<double>(sines_.size());
  double part = 0.0;
  for (Sine& sine : sines_) {
    // One in each part of the band: no two of them beat slowly against each other for a whole motion.
    const double place = (part + random.uniform()) / n;
    part += 1.0;
    sine.rad_s = kTurn * band.from_hz * std::pow(band.to_hz / band.from_hz, place);
    sine.phase_rad = kTurn * random.uniform();
    sine.amplitude_rad = rms_rate_rad_s * std::sqrt(2.0 / n) / sine.rad_s;
  }
}

Jet Shake::at(double t_s) const {
  Jet sum;
  for (const Sine& sine : sines_) {
    const double phase = sine.rad_s * t_s + sine.phase_rad;
    const double s = sine.amplitude_rad * std::sin(phase), c = sine.amplitude_rad * std::cos(phase);
    sum = sum + Jet{s, sine.rad_s * c, -sine.rad_s * sine.rad_s * s};
  }
  return sum;
}

double Shake::bound_rad() const {
  double bound = 0.0;
  for (const Sine& sine : sines_) bound += sine.amplitude_rad;
  return bound;
}

}  // namespace emulator
}  // namespace tfsat
