// The robot as a body in space: held on the bench, in free fall, landing.
//
// Joints are driven (their motion is given); what is integrated is the attitude of the base body.
// World frame: z up, inertial. At zero joint angles and unit attitude it is the global body frame.
#pragma once

#include <cstdint>

#include "body_tree.h"
#include "turning.h"

namespace tfsat {
namespace emulator {

constexpr double kStandardGravity_m_s2 = 9.80665;

enum class ChainMode : uint8_t {
  kHeld,    // some bodies are fixed in the world or carried, the others follow the joints
  kFree,    // angular momentum about the CoM is constant, the CoM is in free fall
  kLanded,  // the base comes to rest under a deceleration pulse, the others follow the joints
};

// Deceleration at the end of the fall: half a sine, then rest.
struct LandingPulse {
  double peak_m_s2 = 50.0 * kStandardGravity_m_s2;
  double duration_s = 0.05;
};

struct PointMotion {
  Vec3 position_m, velocity_m_s, acceleration_m_s2;  // world
};

class Chain {
 public:
  // Starts held by all its bodies, at zero angles, in the global frame. Parameters must pass
  // BodyTree::check.
  explicit Chain(const TreeParameters& parameters);

  // Puts the robot down anew: attitude and origin of the base body, joints at rest. It stays held
  // by the bodies that held it last.
  void place(const Quaternion& base_attitude, const Vec3& base_position_m,
             const JointMotion& joints);
  // Fixes the bodies of `mask` (bit i = body i) where they are now. False, and nothing done, if the
  // mask names no body.
  bool hold(uint32_t mask);
  // How the held bodies turn, as one, against where they were when `hold` took them: about the origin of the
  // first one's frame, resolved in it. Takes effect with the next `advance`; `hold` ends it.
  void carry(const Turning& motion) { carried_ = motion; }
  // Puts a joint of the held robot at this angle, at rest. What is held stays where it is.
  void bend(int joint, double angle_rad);
  // Lets go. `base_rate_rad_s` (base frame) is the residual rate at release; the angular momentum
  // that follows from it and the joints' rates is kept from then on.
  void release(const Vec3& base_rate_rad_s, const Vec3& com_velocity_m_s);
  // The end of the fall. The base stops where it is; its rate fades over the pulse.
  void land(const LandingPulse& pulse);

  // One step of `dt_s` to the joint motion `end`. In free fall a Runge-Kutta-Munthe-Kaas method of
  // order 4, with the joints on the cubic that joins both ends: a stroke's rotation depends on its
  // path alone, so kinks in a joint's rate between two steps cost no accuracy.
  // Locked joints ignore `end`: read back angle_rad().
  void advance(double dt_s, const JointMotion& end);

  // How often rates and accelerations have been worked out anew: while this stays the same, so do they.
  uint64_t changes() const { return changes_; }
  uint32_t held() const { return held_; }  // bit mask of the bodies that `hold` named last
  ChainMode mode() const { return mode_; }
  int n_bodies() const { return tree_.parameters().n_bodies; }
  int n_joints() const { return tree_.parameters().n_joints; }
  // A joint is locked while held bodies stand on both its sides.
  bool locked(int joint) const;
  const JointMotion& joints() const { return joints_; }

  Quaternion attitude(int body) const;   // body frame to world
  Vec3 rate_rad_s(int body) const;       // body frame
  Vec3 angular_acceleration_rad_s2(int body) const;  // body frame
  PointMotion point(int body, const Vec3& position_m) const;  // a body-fixed point
  // What an ideal accelerometer at that point reads, body frame: +g upwards at rest, in free fall
  // only the motion about the CoM.
  Vec3 specific_force_m_s2(int body, const Vec3& position_m) const;
  Vec3 com_position_m() const;
  // Of the motion as it is, about the CoM, world frame.
  Vec3 angular_momentum() const;
  double kinetic_energy_about_com_j() const { return tree_.kinetic_energy(motion_); }

 private:
  Vec3 free_rate(const JointMotion& joints, const Quaternion& attitude) const;
  void integrate_attitude(double dt_s, const JointMotion& end);
  bool rests_at(const JointMotion& next) const;
  void refresh();
  void refresh_held();
  void refresh_free();
  void refresh_landed();
  void set_motion(const Vec3& rate, const Vec3& acceleration);
  Vec3 support_m_s2() const;

  BodyTree tree_;
  ChainMode mode_ = ChainMode::kHeld;
  JointMotion joints_;
  TreeMotion motion_;
  Quaternion attitude_;            // of the base
  PointMotion origin_;             // of the base frame; acceleration includes gravity only in kFree
  uint32_t held_ = 0;
  int holder_ = 0;                 // the held body that fixes the others
  Quaternion holder_attitude_;
  Vec3 holder_position_m_;
  Turning carried_;                // the holder against holder_attitude_
  Turning refreshed_;              // carried_ as of the last refresh
  uint64_t changes_ = 0;
  Vec3 momentum_;                  // world frame, kFree
  Vec3 com_m_, com_velocity_m_s_;  // world frame, kFree
  LandingPulse pulse_;
  Vec3 landing_rate_;              // base frame, at touch-down
  double since_landing_s_ = 0.0;
};

}  // namespace emulator
}  // namespace tfsat
