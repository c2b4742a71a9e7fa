// Drives a Chain from text on stdin and prints its motion, so that a Python test can be the judge.
//
//   robot N BASE                       then N lines: mass, com[3], inertia[9], origin[3]
//                                      then N-1 lines: inner outer, axis[3], point[3]
//   place qx qy qz qw x y z            attitude and position of the base, joints at zero
//   hold MASK | release wx wy wz vx vy vz | land PEAK DURATION
//   step DT then per joint: angle rate acceleration
//   show BODY px py pz                 prints one line: q[4] rate[3] angular_acceleration[3]
//                                      position[3] velocity[3] acceleration[3] specific_force[3]
//                                      momentum[3] energy joint_angles...
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include "physics/chain.h"

using namespace tfsat::emulator;

namespace {

Vec3 read_vec3() {
  Vec3 v;
  std::cin >> v.x >> v.y >> v.z;
  return v;
}

void print(const Vec3& v) { std::printf("%.17g %.17g %.17g ", v.x, v.y, v.z); }

TreeParameters read_robot() {
  TreeParameters p;
  std::cin >> p.n_bodies >> p.base;
  p.n_joints = p.n_bodies - 1;
  for (int i = 0; i < p.n_bodies && i < kMaxBodies; ++i) {
    BodyParameters& b = p.bodies[i];
    std::cin >> b.mass_kg;
    b.com_m = read_vec3();
    for (auto& row : b.inertia_kg_m2.m)
      for (double& entry : row) std::cin >> entry;
    b.origin_m = read_vec3();
  }
  for (int j = 0; j < p.n_joints && j < kMaxJoints; ++j) {
    std::cin >> p.joints[j].inner >> p.joints[j].outer;
    p.joints[j].axis = read_vec3();
    p.joints[j].point_m = read_vec3();
  }
  return p;
}

void show(const Chain& chain, int body, const Vec3& at) {
  const Quaternion q = chain.attitude(body);
  std::printf("%.17g %.17g %.17g %.17g ", q.x, q.y, q.z, q.w);
  print(chain.rate_rad_s(body));
  print(chain.angular_acceleration_rad_s2(body));
  const PointMotion p = chain.point(body, at);
  print(p.position_m);
  print(p.velocity_m_s);
  print(p.acceleration_m_s2);
  print(chain.specific_force_m_s2(body, at));
  print(chain.angular_momentum());
  std::printf("%.17g", chain.kinetic_energy_about_com_j());
  for (int j = 0; j < chain.n_joints(); ++j) std::printf(" %.17g", chain.joints().angle_rad[j]);
  std::printf("\n");
}

bool obey(const std::string& word, Chain& chain) {
  if (word == "place") {
    Quaternion q;
    std::cin >> q.x >> q.y >> q.z >> q.w;
    chain.place(q, read_vec3(), JointMotion());
  } else if (word == "hold") {
    uint32_t mask = 0;
    std::cin >> mask;
    return chain.hold(mask);
  } else if (word == "release") {
    const Vec3 rate = read_vec3();
    chain.release(rate, read_vec3());
  } else if (word == "land") {
    LandingPulse pulse;
    std::cin >> pulse.peak_m_s2 >> pulse.duration_s;
    chain.land(pulse);
  } else if (word == "step") {
    double dt_s = 0.0;
    JointMotion end;
    std::cin >> dt_s;
    for (int j = 0; j < chain.n_joints(); ++j)
      std::cin >> end.angle_rad[j] >> end.rate_rad_s[j] >> end.acceleration_rad_s2[j];
    chain.advance(dt_s, end);
  } else if (word == "show") {
    int body = 0;
    std::cin >> body;
    show(chain, body, read_vec3());
  } else {
    return false;
  }
  return static_cast<bool>(std::cin);
}

}  // namespace

int main() {
  std::string word;
  std::cin >> word;
  const TreeParameters parameters = read_robot();
  if (const char* problem = BodyTree::check(parameters)) {
    std::fprintf(stderr, "%s\n", problem);
    return 2;
  }
  const std::unique_ptr<Chain> chain(new Chain(parameters));
  while (std::cin >> word)
    if (!obey(word, *chain)) {
      std::fprintf(stderr, "cannot do: %s\n", word.c_str());
      return 1;
    }
  return 0;
}
