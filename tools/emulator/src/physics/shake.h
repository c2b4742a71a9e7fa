// The unrest of a hand about one axis: a sum of sines with random phases.
#pragma once

#include <array>

#include "../sensors/noise.h"
#include "jet.h"

namespace tfsat {
namespace emulator {

struct Band {
  double from_hz, to_hz;
};

class Shake {
 public:
  Shake() = default;  // none
  // Draws frequencies in the band, evenly on a logarithmic scale, and phases. Each sine has the same share of
  // the rate, whose root mean square is `rms_rate_rad_s`.
  Shake(double rms_rate_rad_s, Band band, Noise& random);

  Jet at(double t_s) const;
  // Never exceeded by the angle, rad.
  double bound_rad() const;

 private:
  struct Sine {
    double amplitude_rad = 0.0, rad_s = 0.0, phase_rad = 0.0;
  };
  std::array<Sine, 5> sines_;
};

}  // namespace emulator
}  // namespace tfsat
