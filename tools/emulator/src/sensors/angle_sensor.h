// Absolute angle sensor on a joint axis: one turn on a 12-bit converter, seen from either end.
#pragma once

#include <cstdint>

#include "noise.h"

namespace tfsat {
namespace emulator {

struct AngleSensorParameters {
  double zero_offset_rad = 0.0;   // what it shows at joint angle zero
  int direction = 1;              // -1: it looks at the axis from the other end
  // The magnet is not quite centred and the field not quite even: with phi the angle it ought to show, it shows
  // phi + b[0] sin phi + b[1] cos phi + b[2] sin 2 phi + b[3] cos 2 phi.
  double bend_rad[4] = {};
  double noise_rad = 0.0;         // standard deviation of one reading
  uint64_t seed = 1;
};

enum class AngleSensorFault : uint8_t { kNone, kFrozen, kOpen };  // kOpen: the pull-down reads 0

class AngleSensor {
 public:
  static constexpr uint16_t kCountsPerTurn = 4096;

  explicit AngleSensor(const AngleSensorParameters& parameters = AngleSensorParameters());

  void set_fault(AngleSensorFault fault) { fault_ = fault; }
  // Its magnet has slipped on the axis: from now on it stands this far from where it was glued.
  void set_slip(double slip_rad) { slip_rad_ = slip_rad; }
  // One conversion of the true joint angle: 0..4095, wrapping at a full turn.
  uint16_t convert(double joint_angle_rad);

 private:
  AngleSensorParameters parameters_;
  Noise noise_;
  AngleSensorFault fault_ = AngleSensorFault::kNone;
  double slip_rad_ = 0.0;
  uint16_t last_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
