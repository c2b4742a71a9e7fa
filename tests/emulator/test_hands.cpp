#include "physics/hands.h"

#include "check.h"
#include "physics/chain.h"

using namespace tfsat::emulator;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr double kDt = 1e-4;

// Two bodies of one kilogram, hinged about x at the origin.
TreeParameters two_bodies() {
  TreeParameters p;
  p.n_bodies = 2;
  p.n_joints = 1;
  for (int i = 0; i < 2; ++i) {
    p.bodies[i].mass_kg = 1.0;
    p.bodies[i].inertia_kg_m2 = Mat3::identity();
  }
  p.bodies[1].origin_m = {0.1, 0.02, 0.2};
  p.joints[0] = {0, 1, {1.0, 0.0, 0.0}, {0.0, 0.01, 0.1}};
  return p;
}

HandParameters nervous(uint64_t seed = 1) { return {seed, 5.0 * kDeg, 2.0 * kDeg, 0.02}; }

const std::vector<Leg>& there_and_back() {
  static const std::vector<Leg> legs = {{90.0 * kDeg, 1.5, 1.0}, {0.0, 1.5, 1.0}};
  return legs;
}

void check_near(const Vec3& a, const Vec3& b, double tolerance) {
  CHECK_NEAR(a.x, b.x, tolerance);
  CHECK_NEAR(a.y, b.y, tolerance);
  CHECK_NEAR(a.z, b.z, tolerance);
}

// Rate, acceleration and specific force of every body against differences of where it is.
void check_consistent(const std::vector<Chain>& chains, const Vec3& at) {
  const Chain &before = chains[0], &now = chains[1], &after = chains[2];
  for (int body = 0; body < 2; ++body) {
    const Quaternion to_before = conjugate(now.attitude(body)) * before.attitude(body);
    const Quaternion to_after = conjugate(now.attitude(body)) * after.attitude(body);
    check_near((0.5 / kDt) * (rotation_vector(to_after) - rotation_vector(to_before)), now.rate_rad_s(body), 1e-5);
    check_near((0.5 / kDt) * (after.rate_rad_s(body) - before.rate_rad_s(body)),
               now.angular_acceleration_rad_s2(body), 1e-3);
    const Vec3 bend = before.point(body, at).position_m + after.point(body, at).position_m -
                      2.0 * now.point(body, at).position_m;
    const Vec3 world = (1.0 / (kDt * kDt)) * bend + Vec3{0.0, 0.0, kStandardGravity_m_s2};
    check_near(transpose(to_matrix(now.attitude(body))) * world, now.specific_force_m_s2(body, at), 1e-4);
  }
}

// The joint goes along `joint`, the holder of body `held` does as `hand` says.
void check_held(int held, const JointHand& joint, const HoldingHand& hand, double from_s, double to_s) {
  const Vec3 at{0.03, -0.05, 0.08};
  Chain chain(two_bodies());
  chain.hold(1u << held);
  double fastest = 0.0;
  for (double t_s = from_s; t_s < to_s; t_s += 0.0371) {
    std::vector<Chain> chains;
    for (int k = -1; k <= 1; ++k) {
      const Jet moved = joint.at(t_s + k * kDt);
      JointMotion joints;
      joints.angle_rad[0] = moved.value;
      joints.rate_rad_s[0] = moved.rate;
      joints.acceleration_rad_s2[0] = moved.acceleration;
      chain.carry(hand.at(t_s + k * kDt, moved));
      chain.advance(kDt, joints);
      chains.push_back(chain);
    }
    check_consistent(chains, at);
    fastest = std::fmax(fastest, norm(chains[1].rate_rad_s(held)));
  }
  CHECK(fastest > 1.0 * kDeg);  // the held body does move
}

}  // namespace

TEST_CASE(all_sensors_see_a_swaying_holder_and_a_trembling_joint_alike) {
  const LegPath path(0.0, 1.0, there_and_back());
  const JointHand joint(nervous(), path, 0.0, 90.0 * kDeg);
  for (int held = 0; held < 2; ++held)
    check_held(held, joint, HoldingHand::beside(nervous(2), path, 0.0), 0.9, 6.1);
}

TEST_CASE(all_sensors_see_a_turn_of_the_whole_robot_alike) {
  const LegPath path(0.0, 1.0, {{400.0 * kDeg, 4.0, 1.0}, {0.0, 4.0, 1.0}});
  const Vec3 axis = (1.0 / std::sqrt(1.05)) * Vec3{0.1, -0.2, 1.0};
  check_held(1, JointHand(), HoldingHand::turning(nervous(), axis, path), 0.9, 11.0);
}

TEST_CASE(all_sensors_see_a_hand_that_holds_against_a_servo_alike) {
  const JointHand joint({}, LegPath(0.3, 1.0, there_and_back()), 0.0, 90.0 * kDeg);
  const HoldingHand hand = HoldingHand::against_servo(nervous(), 1.0, 0.3);
  check_held(0, joint, hand, 0.9, 6.1);
  CHECK_NEAR(norm(hand.at(1.0, joint.at(1.0)).rate), 0.0, 0.0);
  CHECK_NEAR(norm(rotation_vector(hand.at(1.0, joint.at(1.0)).attitude)), 0.0, 0.0);
}

TEST_CASE(a_trembling_joint_stays_between_its_stops_and_moves_smoothly) {
  double beyond_rms = 0.0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    // Turns back at the upper stop without a rest, in full tremor.
    const LegPath path(0.0, 1.0, {{90.0 * kDeg, 1.5, 0.0}, {0.0, 1.5, 1.0}, {90.0 * kDeg, 1.5, 0.5}});
    const JointHand hand({seed, 10.0 * kDeg, 0.0, 0.0}, path, 0.0, 90.0 * kDeg);
    Jet last = hand.at(0.0);
    for (double t_s = 1e-3; t_s < 7.5; t_s += 1e-3) {
      const Jet now = hand.at(t_s);
      CHECK(now.value >= 0.0);
      CHECK(now.value <= 90.0 * kDeg);
      CHECK_NEAR(now.value - last.value, 0.5e-3 * (now.rate + last.rate), 2e-7);
      CHECK_NEAR(now.rate - last.rate, 0.5e-3 * (now.acceleration + last.acceleration), 2e-5);
      CHECK(std::fabs(now.acceleration - last.acceleration) < 2.0);  // no jump: rad/s^2 in a millisecond
      beyond_rms = std::fmax(beyond_rms, std::fabs(now.rate - path.at(t_s).rate));
      last = now;
    }
  }
  CHECK(beyond_rms > 10.0 * kDeg);  // there is a tremor
}

TEST_CASE(rests_are_rests) {
  const LegPath path(0.0, 1.0, there_and_back());
  const JointHand joint(nervous(), path, 0.0, 90.0 * kDeg);
  const HoldingHand hand = HoldingHand::beside(nervous(), path, 0.0);
  const double rests[][3] = {{0.0, 1.0, 0.0}, {2.5, 3.5, 90.0 * kDeg}, {5.0, 9.0, 0.0}};
  for (const auto& rest : rests)
    for (double t_s = rest[0]; t_s <= rest[1]; t_s += 0.01) {
      const Jet now = joint.at(t_s);
      CHECK_NEAR(now.value, rest[2], 1e-12);
      CHECK_NEAR(now.rate, 0.0, 1e-12);
      const Turning held = hand.at(t_s, now);
      CHECK_NEAR(norm(held.rate), 0.0, 1e-12);
      // What remains of the sway is that the hand gave way.
      CHECK_NEAR(norm(rotation_vector(held.attitude)), 0.02 * rest[2], 1e-9);
    }
}

TEST_CASE(legs_without_a_rest_between_them_are_one_motion) {
  const LegPath path(0.5, 1.0, {{1.0, 1.0, 0.0}, {0.5, 1.0, 0.0}, {1.0, 1.0, 0.5}});
  CHECK_NEAR(path.duration_s(), 4.5, 1e-12);
  CHECK_NEAR(path.at(0.7).value, 0.5, 0.0);
  CHECK_NEAR(path.at(1.5).value, 0.75, 1e-12);
  CHECK_NEAR(path.at(1.5).rate, 1.875 * 0.5, 1e-12);
  CHECK_NEAR(path.at(2.0).value, 1.0, 1e-12);
  CHECK_NEAR(path.at(9.0).value, 1.0, 1e-12);
  CHECK_NEAR(path.unrest(1.0).value, 0.0, 0.0);
  CHECK_NEAR(path.unrest(2.0).value, 1.0, 0.0);
  CHECK_NEAR(path.unrest(4.0).value, 0.0, 0.0);
}

TEST_CASE(a_shake_has_the_rate_that_was_asked_for_and_its_seed_repeats_it) {
  Noise random(7), again(7), other(8);
  const Shake shake(2.0 * kDeg, {0.3, 6.0}, random), same(2.0 * kDeg, {0.3, 6.0}, again),
      different(2.0 * kDeg, {0.3, 6.0}, other);
  double squares = 0.0;
  int n = 0;
  for (double t_s = 0.0; t_s < 300.0; t_s += 0.01, ++n) {
    const Jet now = shake.at(t_s);
    squares += now.rate * now.rate;
    CHECK(now.value == same.at(t_s).value);
    CHECK(std::fabs(now.value) <= shake.bound_rad());
  }
  CHECK_NEAR(std::sqrt(squares / n), 2.0 * kDeg, 0.02 * kDeg);
  CHECK(shake.at(1.0).value != different.at(1.0).value);
}
