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
  double shown = parameters_.zero_offset_rad + parameters_.direction * joint_angle_rad;
  if (parameters_.noise_rad > 0.0) shown += parameters_.noise_rad * noise_.normal();
  const double turns = shown / kTurn;
  // A converter truncates: count k stands for k to k+1 steps.
  const double counts = std::floor((turns - std::floor(turns)) * kCountsPerTurn);
  last_ = static_cast<uint16_t>(counts) % kCountsPerTurn;
  return last_;
}

}  // namespace emulator
}  // namespace tfsat
