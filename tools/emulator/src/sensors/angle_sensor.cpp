#include "angle_sensor.h"

#include <cmath>

namespace tfsat {
namespace emulator {

AngleSensor::AngleSensor(const AngleSensorParameters& parameters)
    : parameters_(parameters), noise_(parameters.seed) {}

uint16_t AngleSensor::convert(double joint_angle_rad) {
  constexpr double kTurn = 6.283185307179586477;
  if (fault_ == AngleSensorFault::kOpen) return 0;
  if (fault_ == AngleSensorFault::kFrozen) return last_;
  const double phi = parameters_.zero_offset_rad + parameters_.direction * joint_angle_rad + slip_rad_;
  const double* bend = parameters_.bend_rad;
  double shown = phi + bend[0] * std::sin(phi) + bend[1] * std::cos(phi) + bend[2] * std::sin(2.0 * phi) +
                 bend[3] * std::cos(2.0 * phi);
  if (parameters_.noise_rad > 0.0) shown += parameters_.noise_rad * noise_.normal();
  const double turns = shown / kTurn;
  // A converter truncates: count k stands for k to k+1 steps.
  const double counts = std::floor((turns - std::floor(turns)) * kCountsPerTurn);
  last_ = static_cast<uint16_t>(counts) % kCountsPerTurn;
  return last_;
}

}  // namespace emulator
}  // namespace tfsat
