// A rotation in time: attitude, rate and angular acceleration that belong together.
#pragma once

#include "jet.h"
#include "linalg.h"

namespace tfsat {
namespace emulator {

// Rate and acceleration are resolved in the frame that turns.
struct Turning {
  Quaternion attitude;
  Vec3 rate, acceleration;
};

// About an axis that stands still in both frames.
inline Turning turning_about(const Vec3& axis, const Jet& angle) {
  return {from_rotation_vector(angle.value * axis), angle.rate * axis, angle.acceleration * axis};
}

// First `outer`, then `inner` relative to what `outer` made of it.
inline Turning compose(const Turning& outer, const Turning& inner) {
  const Mat3 to_inner = transpose(to_matrix(inner.attitude));
  const Vec3 carried = to_inner * outer.rate;
  return {outer.attitude * inner.attitude, carried + inner.rate,
          to_inner * outer.acceleration + cross(carried, inner.rate) + inner.acceleration};
}

}  // namespace emulator
}  // namespace tfsat
