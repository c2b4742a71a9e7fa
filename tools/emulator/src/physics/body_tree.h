// Rigid bodies joined by hinges into a tree: its kinematics and its momentum, seen from one body.
#pragma once

#include <cstdint>

#include "linalg.h"

namespace tfsat {
namespace emulator {

constexpr int kMaxBodies = 8;
constexpr int kMaxJoints = kMaxBodies - 1;

struct BodyParameters {
  double mass_kg = 0.0;
  Vec3 com_m;           // in the body frame
  Mat3 inertia_kg_m2;   // tensor about the CoM, body axes
  Vec3 origin_m;        // of the body frame, global, at zero joint angles
};

// The joint angle is that of `outer` relative to `inner`, positive about `axis`. For the drop tower
// robot outer = body i and inner = body i+1.
struct JointParameters {
  int inner = 0;
  int outer = 0;
  Vec3 axis;      // unit vector; all body frames are parallel at zero angles
  Vec3 point_m;   // a point on the axis, global, at zero joint angles
};

struct TreeParameters {
  int n_bodies = 0;
  int n_joints = 0;  // n_bodies - 1
  int base = 0;      // the body whose attitude is integrated (index 2 = body 3 of the robot)
  BodyParameters bodies[kMaxBodies];
  JointParameters joints[kMaxJoints];
};

struct JointMotion {
  double angle_rad[kMaxJoints] = {};
  double rate_rad_s[kMaxJoints] = {};
  double acceleration_rad_s2[kMaxJoints] = {};
};

// Motion of one body relative to inertial space with the base's origin taken as unaccelerated.
// Every vector is resolved in the base frame.
struct TreeBody {
  Mat3 to_base;
  Vec3 rate, acceleration;                                       // angular
  Vec3 origin, origin_velocity, origin_acceleration;             // of the body frame
  Vec3 com, com_velocity, com_acceleration;                      // of the body's mass
};

struct TreeMotion {
  TreeBody bodies[kMaxBodies];
  Vec3 com, com_velocity, com_acceleration;  // of the whole robot
};

class BodyTree {
 public:
  // Null if `p` describes a tree, else what is wrong with it. Construct only from valid parameters.
  static const char* check(const TreeParameters& p);

  explicit BodyTree(const TreeParameters& p);

  const TreeParameters& parameters() const { return p_; }

  // Motion of all bodies for a base that turns at `rate`, `acceleration` (base frame).
  TreeMotion motion(const JointMotion& joints, const Vec3& rate, const Vec3& acceleration) const;

  // About the robot's CoM, base frame.
  Mat3 inertia(const TreeMotion& motion) const;
  Vec3 angular_momentum(const TreeMotion& motion) const;
  // d/dt of the angular momentum in inertial space.
  Vec3 angular_momentum_rate(const TreeMotion& motion) const;
  double kinetic_energy(const TreeMotion& motion) const;

  // Bodies (bit mask) on the far side of a joint, seen from the base.
  uint32_t far_side(int joint) const { return far_side_[joint]; }

 private:
  struct Link {
    int joint, parent, child;
    double sign;                      // -1 where the base is on the joint's outer side
    Vec3 axis;
    Vec3 point_parent, point_child;   // the axis point in either body frame
  };
  void place_child(const Link& link, const JointMotion& joints, TreeMotion& motion) const;
  void place_com(int body, TreeMotion& motion) const;

  TreeParameters p_;
  Link links_[kMaxJoints];  // parents before children
  uint32_t far_side_[kMaxJoints] = {};
  double mass_ = 0.0;
};

}  // namespace emulator
}  // namespace tfsat
