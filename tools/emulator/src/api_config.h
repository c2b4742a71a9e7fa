// The C interface's description of a robot as the emulation's own.
#pragma once

#include "api.h"
#include "robot.h"

namespace tfsat {
namespace emulator {

inline Vec3 vector(const double v[3]) { return Vec3{v[0], v[1], v[2]}; }

RobotParameters robot_parameters(const TfsatRobotConfig& config);

}  // namespace emulator
}  // namespace tfsat
