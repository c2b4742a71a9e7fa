#include "chain.h"

#include <cstring>

namespace tfsat {
namespace emulator {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Vec3 kUp{0.0, 0.0, 1.0};

Quaternion quaternion_from(const Mat3& r) {
  const double trace = r.m[0][0] + r.m[1][1] + r.m[2][2];
  if (trace > 0.0)
    return normalized({r.m[2][1] - r.m[1][2], r.m[0][2] - r.m[2][0], r.m[1][0] - r.m[0][1],
                       1.0 + trace});
  int i = r.m[1][1] > r.m[0][0] ? 1 : 0;
  if (r.m[2][2] > r.m[i][i]) i = 2;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  double v[3];
  v[i] = 1.0 + r.m[i][i] - r.m[j][j] - r.m[k][k];
  v[j] = r.m[j][i] + r.m[i][j];
  v[k] = r.m[k][i] + r.m[i][k];
  return normalized({v[0], v[1], v[2], r.m[k][j] - r.m[j][k]});
}

// Middle of the cubic (Hermite) joint path from `a` to `b`.
JointMotion middle(const JointMotion& a, const JointMotion& b, int n, double dt_s) {
  JointMotion m;
  for (int j = 0; j < n; ++j) {
    m.angle_rad[j] = 0.5 * (a.angle_rad[j] + b.angle_rad[j]) +
                     0.125 * dt_s * (a.rate_rad_s[j] - b.rate_rad_s[j]);
    m.rate_rad_s[j] = 1.5 * (b.angle_rad[j] - a.angle_rad[j]) / dt_s -
                      0.25 * (a.rate_rad_s[j] + b.rate_rad_s[j]);
  }
  return m;
}

// Inverse of the exponential's differential, body frame, to the order that RK4 needs.
Vec3 dexpinv(const Vec3& u, const Vec3& rate) {
  const Vec3 c = cross(u, rate);
  return rate + 0.5 * c + (1.0 / 12.0) * cross(u, c);
}

}  // namespace

Chain::Chain(const TreeParameters& parameters) : tree_(parameters) {
  held_ = (1u << parameters.n_bodies) - 1u;
  place(Quaternion(), parameters.bodies[parameters.base].origin_m, JointMotion());
}

void Chain::place(const Quaternion& base_attitude, const Vec3& base_position_m,
                  const JointMotion& joints) {
  joints_ = joints;
  for (int j = 0; j < kMaxJoints; ++j) joints_.rate_rad_s[j] = joints_.acceleration_rad_s2[j] = 0.0;
  attitude_ = normalized(base_attitude);
  origin_ = PointMotion();
  origin_.position_m = base_position_m;
  set_motion(Vec3(), Vec3());
  hold(held_);
}

bool Chain::hold(uint32_t mask) {
  mask &= (1u << n_bodies()) - 1u;
  if (mask == 0) return false;
  held_ = mask;
  holder_ = 0;
  while (!((mask >> holder_) & 1u)) ++holder_;
  holder_attitude_ = attitude(holder_);
  carried_ = Turning();
  holder_position_m_ = point(holder_, Vec3()).position_m;
  mode_ = ChainMode::kHeld;
  for (int j = 0; j < n_joints(); ++j)
    if (locked(j)) joints_.rate_rad_s[j] = joints_.acceleration_rad_s2[j] = 0.0;
  refresh();
  return true;
}

void Chain::bend(int joint, double angle_rad) {
  joints_.angle_rad[joint] = angle_rad;
  joints_.rate_rad_s[joint] = joints_.acceleration_rad_s2[joint] = 0.0;
  refresh();
}

void Chain::release(const Vec3& base_rate_rad_s, const Vec3& com_velocity_m_s) {
  com_m_ = com_position_m();
  com_velocity_m_s_ = com_velocity_m_s;
  const TreeMotion moving = tree_.motion(joints_, base_rate_rad_s, Vec3());
  momentum_ = to_matrix(attitude_) * tree_.angular_momentum(moving);
  mode_ = ChainMode::kFree;
  refresh();
}

void Chain::land(const LandingPulse& pulse) {
  pulse_ = pulse;
  since_landing_s_ = 0.0;
  landing_rate_ = motion_.bodies[tree_.parameters().base].rate;
  mode_ = ChainMode::kLanded;
  refresh();
}

bool Chain::locked(int joint) const {
  if (mode_ != ChainMode::kHeld) return false;
  const uint32_t far = tree_.far_side(joint);
  return (held_ & far) != 0 && (held_ & ~far) != 0;
}

void Chain::advance(double dt_s, const JointMotion& end) {
  JointMotion next = end;
  for (int j = 0; j < n_joints(); ++j)
    if (locked(j)) {
      next.angle_rad[j] = joints_.angle_rad[j];
      next.rate_rad_s[j] = next.acceleration_rad_s2[j] = 0.0;
    }
  if (rests_at(next)) return;
  if (mode_ == ChainMode::kFree) {
    if (dt_s > 0.0) integrate_attitude(dt_s, next);
    com_m_ += dt_s * com_velocity_m_s_ - (0.5 * kStandardGravity_m_s2 * dt_s * dt_s) * kUp;
    com_velocity_m_s_ = com_velocity_m_s_ - (kStandardGravity_m_s2 * dt_s) * kUp;
  } else if (mode_ == ChainMode::kLanded) {
    // The fading rate keeps its direction in the base frame: its integral is in closed form.
    const double t0 = std::fmin(since_landing_s_, pulse_.duration_s);
    const double t1 = std::fmin(since_landing_s_ + dt_s, pulse_.duration_s);
    const double k = kPi / pulse_.duration_s;
    const double turned = 0.5 * (t1 - t0 + (std::sin(k * t1) - std::sin(k * t0)) / k);
    attitude_ = normalized(attitude_ * from_rotation_vector(turned * landing_rate_));
    since_landing_s_ += dt_s;
  }
  joints_ = next;
  refresh();
}

// Held, and neither a joint nor the hands have moved since the last step: all follows from them.
bool Chain::rests_at(const JointMotion& next) const {
  return mode_ == ChainMode::kHeld && std::memcmp(&next, &joints_, sizeof next) == 0 &&
         std::memcmp(&carried_, &refreshed_, sizeof carried_) == 0;
}

Vec3 Chain::free_rate(const JointMotion& joints, const Quaternion& attitude) const {
  const TreeMotion shape = tree_.motion(joints, Vec3(), Vec3());
  const Vec3 momentum = transpose(to_matrix(attitude)) * momentum_;
  return solve(tree_.inertia(shape), momentum - tree_.angular_momentum(shape));
}

void Chain::integrate_attitude(double dt_s, const JointMotion& end) {
  const JointMotion half = middle(joints_, end, n_joints(), dt_s);
  const auto stage = [&](const JointMotion& joints, const Vec3& u) {
    return dexpinv(u, free_rate(joints, attitude_ * from_rotation_vector(u)));
  };
  const Vec3 k1 = stage(joints_, Vec3());
  const Vec3 k2 = stage(half, (0.5 * dt_s) * k1);
  const Vec3 k3 = stage(half, (0.5 * dt_s) * k2);
  const Vec3 k4 = stage(end, dt_s * k3);
  const Vec3 u = (dt_s / 6.0) * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  attitude_ = normalized(attitude_ * from_rotation_vector(u));
}

void Chain::refresh() {
  ++changes_;
  refreshed_ = carried_;
  switch (mode_) {
    case ChainMode::kHeld: refresh_held(); break;
    case ChainMode::kFree: refresh_free(); break;
    case ChainMode::kLanded: refresh_landed(); break;
  }
}

void Chain::set_motion(const Vec3& rate, const Vec3& acceleration) {
  motion_ = tree_.motion(joints_, rate, acceleration);
}

void Chain::refresh_held() {
  // The base's own motion is what makes the holder's: rest, or that of the hands.
  set_motion(Vec3(), Vec3());
  const Mat3 to_base = motion_.bodies[holder_].to_base;
  const Vec3 rate = -(motion_.bodies[holder_].rate - to_base * carried_.rate);
  set_motion(rate, Vec3());
  set_motion(rate, -(motion_.bodies[holder_].acceleration - to_base * carried_.acceleration));
  const TreeBody& holder = motion_.bodies[holder_];
  attitude_ = normalized(holder_attitude_ * carried_.attitude * conjugate(quaternion_from(holder.to_base)));
  const Mat3 to_world = to_matrix(attitude_);
  origin_.position_m = holder_position_m_ - to_world * holder.origin;
  origin_.velocity_m_s = -(to_world * holder.origin_velocity);
  origin_.acceleration_m_s2 = -(to_world * holder.origin_acceleration);
}

void Chain::refresh_free() {
  const Vec3 rate = free_rate(joints_, attitude_);
  set_motion(rate, Vec3());
  set_motion(rate, -solve(tree_.inertia(motion_), tree_.angular_momentum_rate(motion_)));
  const Mat3 to_world = to_matrix(attitude_);
  origin_.position_m = com_m_ - to_world * motion_.com;
  origin_.velocity_m_s = com_velocity_m_s_ - to_world * motion_.com_velocity;
  origin_.acceleration_m_s2 =
      -(to_world * motion_.com_acceleration) - kStandardGravity_m_s2 * kUp;
}

void Chain::refresh_landed() {
  const double t = std::fmin(since_landing_s_, pulse_.duration_s);
  const double k = kPi / pulse_.duration_s;
  set_motion((0.5 * (1.0 + std::cos(k * t))) * landing_rate_,
             (-0.5 * k * std::sin(k * t)) * landing_rate_);
  origin_.velocity_m_s = Vec3();
  origin_.acceleration_m_s2 = Vec3();
}

Quaternion Chain::attitude(int body) const {
  return normalized(attitude_ * quaternion_from(motion_.bodies[body].to_base));
}

Vec3 Chain::rate_rad_s(int body) const {
  const TreeBody& b = motion_.bodies[body];
  return transpose(b.to_base) * b.rate;
}

Vec3 Chain::angular_acceleration_rad_s2(int body) const {
  const TreeBody& b = motion_.bodies[body];
  return transpose(b.to_base) * b.acceleration;
}

PointMotion Chain::point(int body, const Vec3& position_m) const {
  const TreeBody& b = motion_.bodies[body];
  const Mat3 to_world = to_matrix(attitude_);
  const Vec3 arm = b.to_base * position_m;
  PointMotion p = origin_;
  p.position_m += to_world * (b.origin + arm);
  p.velocity_m_s += to_world * (b.origin_velocity + cross(b.rate, arm));
  p.acceleration_m_s2 += to_world * (b.origin_acceleration + cross(b.acceleration, arm) +
                                     cross(b.rate, cross(b.rate, arm)));
  return p;
}

Vec3 Chain::support_m_s2() const {
  if (mode_ != ChainMode::kLanded) return kStandardGravity_m_s2 * kUp;
  if (since_landing_s_ >= pulse_.duration_s) return kStandardGravity_m_s2 * kUp;
  // The ground takes over the weight while it stops the fall, so that the reading has no step.
  const double phase = since_landing_s_ / pulse_.duration_s;
  return (pulse_.peak_m_s2 * std::sin(kPi * phase) + kStandardGravity_m_s2 * phase) * kUp;
}

Vec3 Chain::specific_force_m_s2(int body, const Vec3& position_m) const {
  const Vec3 world = point(body, position_m).acceleration_m_s2 + support_m_s2();
  return transpose(to_matrix(attitude(body))) * world;
}

Vec3 Chain::com_position_m() const {
  return origin_.position_m + to_matrix(attitude_) * motion_.com;
}

Vec3 Chain::angular_momentum() const {
  return to_matrix(attitude_) * tree_.angular_momentum(motion_);
}

}  // namespace emulator
}  // namespace tfsat
