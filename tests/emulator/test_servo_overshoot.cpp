#include "check.h"
#include "physics/servo.h"

using namespace tfsat::emulator;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr uint64_t kFrame_us = 20000;
constexpr uint64_t kStep_us = 50;
constexpr double kBeyond_deg = 0.4;

double pulse_for(double angle_deg) { return 1500.0 + (angle_deg - 45.0) * 100.0 / 9.0; }

ServoParameters overshooting(double beyond_deg) {
  ServoParameters p;
  p.errors.overshoot_rad = beyond_deg * kDeg;
  return p;
}

// A servo that overshoots, driven in steps; on the way it sees to it that angle, rate and acceleration belong together.
class Bench {
 public:
  explicit Bench(double beyond_deg = kBeyond_deg) : servo_(overshooting(beyond_deg)) {}

  // Pulses every 20 ms for so long; `jitter_us` more in every other one. The farthest on the way, in degrees.
  double drive(double angle_deg, uint64_t duration_us, double jitter_us = 0.0) {
    const uint64_t from_us = t_us_;
    double farthest = servo_.motion(t_us_).angle_rad;
    for (; t_us_ <= from_us + duration_us; t_us_ += kStep_us) {
      const ServoMotion before = servo_.motion(t_us_);
      const uint64_t frame = (t_us_ - from_us) / kFrame_us;
      if ((t_us_ - from_us) % kFrame_us == 0) servo_.pulse(t_us_, pulse_for(angle_deg) + (frame % 2 ? jitter_us : 0.0));
      const ServoMotion now = servo_.motion(t_us_);
      CHECK_NEAR(now.angle_rad, before.angle_rad, 1e-12);
      CHECK_NEAR(now.rate_rad_s, before.rate_rad_s, 1e-12);
      check_step(now, servo_.motion(t_us_ + kStep_us));
      if (std::fabs(now.angle_rad - start_rad_) > std::fabs(farthest - start_rad_)) farthest = now.angle_rad;
    }
    return farthest / kDeg;
  }
  void begin() { start_rad_ = servo_.motion(t_us_).angle_rad; }
  void fault(ServoFault fault) { servo_.set_fault(t_us_, fault); }
  ServoMotion at(uint64_t t_us) { return servo_.motion(t_us); }
  double angle_deg() { return servo_.motion(t_us_).angle_rad / kDeg; }

 private:
  // The acceleration jumps where the motion's pieces meet; between, the trapezoidal rule holds to the step's cube.
  void check_step(const ServoMotion& a, const ServoMotion& b) {
    const double dt = 1e-6 * kStep_us;
    CHECK_NEAR(b.angle_rad - a.angle_rad, 0.5 * dt * (a.rate_rad_s + b.rate_rad_s), 1e-7);
    const bool corner = std::fabs(b.acceleration_rad_s2 - a.acceleration_rad_s2) > 1000.0 * kDeg;
    if (!corner)
      CHECK_NEAR(b.rate_rad_s - a.rate_rad_s, 0.5 * dt * (a.acceleration_rad_s2 + b.acceleration_rad_s2), 1e-6);
  }

  Servo servo_;
  uint64_t t_us_ = 0;
  double start_rad_ = 0.0;
};

}  // namespace

// 59 deg at 200 deg/s take 0.345 s, of which the last 0.05 s are braking.
TEST_CASE(a_motion_runs_beyond_its_end_by_the_overshoot_and_is_back_after_as_long_as_it_brakes) {
  Bench bench, early;
  CHECK_NEAR(bench.drive(59.0, 345000), 59.0 + kBeyond_deg, 1e-9);
  CHECK_NEAR(bench.at(345000).angle_rad, (59.0 + kBeyond_deg) * kDeg, 1e-12);
  bench.drive(59.0, 48000);
  CHECK(bench.angle_deg() > 59.0);
  bench.drive(59.0, 3000);
  CHECK_NEAR(bench.angle_deg(), 59.0, 1e-12);
  CHECK(bench.at(400000).rate_rad_s == 0.0);
  CHECK_NEAR(early.drive(59.0, 295000), 49.0 + 5.0, 1e-9);  // none of it before the braking
}

TEST_CASE(it_does_not_stop_before_it_turns_back_and_goes_no_faster_than_the_servo) {
  Servo servo(overshooting(kBeyond_deg));
  for (uint64_t t = 0; t < 500000; t += 100) {
    if (t % kFrame_us == 0) servo.pulse(t, pulse_for(59.0));
    const double rate = servo.motion(t).rate_rad_s / kDeg;
    CHECK(rate <= 200.0 + 1e-9);
    if (t > 0 && t < 345000) CHECK(rate > 0.0);
    if (t > 345000 && t < 395000) CHECK(rate < 0.0);
    if (t > 395000) CHECK(rate == 0.0);
  }
}

TEST_CASE(a_motion_that_gets_to_half_the_rate_has_a_quarter_of_it) {
  Bench bench;
  CHECK_NEAR(bench.drive(2.5, 500000), 2.5 + kBeyond_deg / 4.0, 1e-4);
  CHECK_NEAR(bench.angle_deg(), 2.5, 1e-12);
  Bench slow;
  slow.fault(ServoFault::kSlow);
  CHECK_NEAR(slow.drive(40.0, 2000000), 40.0 + kBeyond_deg / 16.0, 1e-4);
}

TEST_CASE(no_joint_goes_through_its_stop) {
  Bench bench;
  CHECK_NEAR(bench.drive(90.0, 1000000), 90.0, 1e-9);
  CHECK_NEAR(bench.drive(60.0, 1000000), 90.0, 1e-9);
  bench.begin();
  CHECK_NEAR(bench.drive(0.1, 1000000), 0.0, 1e-9);
  CHECK_NEAR(bench.angle_deg(), 0.1, 1e-9);
}

TEST_CASE(the_next_command_may_come_at_any_moment_of_it) {
  for (uint64_t meanwhile_us = 290000; meanwhile_us <= 400000; meanwhile_us += 5000) {
    Bench on, back;
    on.drive(59.0, meanwhile_us);
    CHECK_NEAR(on.drive(80.0, 600000), 80.0 + kBeyond_deg, 2e-2);
    CHECK_NEAR(on.angle_deg(), 80.0, 1e-12);
    back.drive(59.0, meanwhile_us);
    back.begin();
    back.drive(20.0, 600000);
    CHECK_NEAR(back.angle_deg(), 20.0, 1e-12);
  }
}

TEST_CASE(what_a_clock_rounds_off_a_pulse_is_no_new_command) {
  Bench bench;
  CHECK_NEAR(bench.drive(59.0, 345000, 0.001), 59.0 + kBeyond_deg, 1e-3);
  CHECK_NEAR(bench.at(345000).angle_rad, (59.0 + kBeyond_deg) * kDeg, 1e-3 * kDeg);
  bench.drive(59.0, 300000, 0.001);
  CHECK_NEAR(bench.angle_deg(), 59.0, 2e-4);
}

TEST_CASE(a_servo_without_overshoot_ends_on_its_target) {
  Bench bench(0.0);
  CHECK(bench.drive(59.0, 1000000) == bench.angle_deg());
}
