#include "body_tree.h"

namespace tfsat {
namespace emulator {

const char* BodyTree::check(const TreeParameters& p) {
  if (p.n_bodies < 1 || p.n_bodies > kMaxBodies) return "the number of bodies must be 1 to 8";
  if (p.n_joints != p.n_bodies - 1) return "a tree has one joint less than bodies";
  if (p.base < 0 || p.base >= p.n_bodies) return "the base is none of the bodies";
  for (int i = 0; i < p.n_bodies; ++i)
    if (!(p.bodies[i].mass_kg > 0.0)) return "every body's mass must be positive";
  uint32_t reached = 1u << p.base;
  for (int j = 0; j < p.n_joints; ++j) {
    const JointParameters& joint = p.joints[j];
    if (joint.inner < 0 || joint.inner >= p.n_bodies || joint.outer < 0 ||
        joint.outer >= p.n_bodies)
      return "a joint names a body that does not exist";
    if (std::fabs(norm(joint.axis) - 1.0) > 1e-9) return "a joint axis is not a unit vector";
  }
  for (int pass = 0; pass < p.n_joints; ++pass)
    for (int j = 0; j < p.n_joints; ++j) {
      const uint32_t ends = 1u << p.joints[j].inner | 1u << p.joints[j].outer;
      if (ends & reached) reached |= ends;
    }
  if (reached != (1u << p.n_bodies) - 1u) return "the joints form a loop or leave a body apart";
  return nullptr;
}

BodyTree::BodyTree(const TreeParameters& p) : p_(p) {
  for (int i = 0; i < p.n_bodies; ++i) mass_ += p.bodies[i].mass_kg;
  uint32_t reached = 1u << p.base;
  uint32_t used = 0;
  int n = 0;
  while (n < p.n_joints) {
    for (int j = 0; j < p.n_joints; ++j) {
      const JointParameters& joint = p.joints[j];
      const bool inner_reached = (reached >> joint.inner) & 1u;
      const bool outer_reached = (reached >> joint.outer) & 1u;
      if ((used >> j) & 1u || inner_reached == outer_reached) continue;
      Link& link = links_[n++];
      link.joint = j;
      link.parent = inner_reached ? joint.inner : joint.outer;
      link.child = inner_reached ? joint.outer : joint.inner;
      link.sign = inner_reached ? 1.0 : -1.0;
      link.axis = joint.axis;
      link.point_parent = joint.point_m - p.bodies[link.parent].origin_m;
      link.point_child = joint.point_m - p.bodies[link.child].origin_m;
      reached |= 1u << link.child;
      used |= 1u << j;
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    far_side_[links_[k].joint] |= 1u << links_[k].child;
    for (int i = 0; i < k; ++i)
      if (links_[i].child == links_[k].parent)
        far_side_[links_[i].joint] |= far_side_[links_[k].joint];
  }
}

void BodyTree::place_com(int body, TreeMotion& motion) const {
  TreeBody& b = motion.bodies[body];
  const Vec3 arm = b.to_base * p_.bodies[body].com_m;
  b.com = b.origin + arm;
  b.com_velocity = b.origin_velocity + cross(b.rate, arm);
  b.com_acceleration =
      b.origin_acceleration + cross(b.acceleration, arm) + cross(b.rate, cross(b.rate, arm));
  const double share = p_.bodies[body].mass_kg / mass_;
  motion.com += share * b.com;
  motion.com_velocity += share * b.com_velocity;
  motion.com_acceleration += share * b.com_acceleration;
}

void BodyTree::place_child(const Link& link, const JointMotion& joints, TreeMotion& motion) const {
  const TreeBody& a = motion.bodies[link.parent];
  TreeBody& b = motion.bodies[link.child];
  const double angle = link.sign * joints.angle_rad[link.joint];
  b.to_base = a.to_base * to_matrix(from_rotation_vector(angle * link.axis));
  const Vec3 axis = a.to_base * link.axis;
  const Vec3 spin = (link.sign * joints.rate_rad_s[link.joint]) * axis;
  b.rate = a.rate + spin;
  b.acceleration = a.acceleration + cross(a.rate, spin) +
                   (link.sign * joints.acceleration_rad_s2[link.joint]) * axis;
  const Vec3 to_joint = a.to_base * link.point_parent;
  const Vec3 from_joint = -(b.to_base * link.point_child);
  b.origin = a.origin + to_joint + from_joint;
  b.origin_velocity = a.origin_velocity + cross(a.rate, to_joint) + cross(b.rate, from_joint);
  b.origin_acceleration = a.origin_acceleration + cross(a.acceleration, to_joint) +
                          cross(a.rate, cross(a.rate, to_joint)) +
                          cross(b.acceleration, from_joint) +
                          cross(b.rate, cross(b.rate, from_joint));
}

TreeMotion BodyTree::motion(const JointMotion& joints, const Vec3& rate,
                            const Vec3& acceleration) const {
  TreeMotion motion;
  TreeBody& base = motion.bodies[p_.base];
  base.to_base = Mat3::identity();
  base.rate = rate;
  base.acceleration = acceleration;
  place_com(p_.base, motion);
  for (int k = 0; k < p_.n_joints; ++k) {
    place_child(links_[k], joints, motion);
    place_com(links_[k].child, motion);
  }
  return motion;
}

Mat3 BodyTree::inertia(const TreeMotion& motion) const {
  Mat3 total;
  for (int i = 0; i < p_.n_bodies; ++i) {
    const TreeBody& b = motion.bodies[i];
    total += b.to_base * p_.bodies[i].inertia_kg_m2 * transpose(b.to_base);
    total += point_inertia(p_.bodies[i].mass_kg, b.com - motion.com);
  }
  return total;
}

Vec3 BodyTree::angular_momentum(const TreeMotion& motion) const {
  Vec3 h;
  for (int i = 0; i < p_.n_bodies; ++i) {
    const TreeBody& b = motion.bodies[i];
    h += b.to_base * (p_.bodies[i].inertia_kg_m2 * (transpose(b.to_base) * b.rate));
    h += p_.bodies[i].mass_kg * cross(b.com - motion.com, b.com_velocity - motion.com_velocity);
  }
  return h;
}

Vec3 BodyTree::angular_momentum_rate(const TreeMotion& motion) const {
  Vec3 rate;
  for (int i = 0; i < p_.n_bodies; ++i) {
    const TreeBody& b = motion.bodies[i];
    const Mat3 inertia = b.to_base * p_.bodies[i].inertia_kg_m2 * transpose(b.to_base);
    rate += inertia * b.acceleration + cross(b.rate, inertia * b.rate);
    rate += p_.bodies[i].mass_kg *
            cross(b.com - motion.com, b.com_acceleration - motion.com_acceleration);
  }
  return rate;
}

double BodyTree::kinetic_energy(const TreeMotion& motion) const {
  double energy = 0.0;
  for (int i = 0; i < p_.n_bodies; ++i) {
    const TreeBody& b = motion.bodies[i];
    const Vec3 rate = transpose(b.to_base) * b.rate;
    const Vec3 velocity = b.com_velocity - motion.com_velocity;
    energy += 0.5 * dot(rate, p_.bodies[i].inertia_kg_m2 * rate);
    energy += 0.5 * p_.bodies[i].mass_kg * dot(velocity, velocity);
  }
  return energy;
}

}  // namespace emulator
}  // namespace tfsat
