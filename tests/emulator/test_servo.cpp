#include "physics/servo.h"

#include "check.h"

using namespace tfsat::emulator;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr uint64_t kFrame_us = 20000;

double pulse_for(double angle_deg) { return 1500.0 + (angle_deg - 45.0) * 100.0 / 9.0; }

// Pulses every 20 ms from `from_us` until `to_us`; checks on the way that the motion is smooth.
void drive(Servo& servo, uint64_t from_us, uint64_t to_us, double angle_deg) {
  ServoMotion last = servo.motion(from_us);
  servo.pulse(from_us, pulse_for(angle_deg));
  for (uint64_t t = from_us + 100; t <= to_us; t += 100) {
    if ((t - from_us) % kFrame_us == 0) servo.pulse(t, pulse_for(angle_deg));
    const ServoMotion now = servo.motion(t);
    CHECK(std::fabs(now.rate_rad_s) <= 200.0 * kDeg + 1e-9);
    CHECK(std::fabs(now.rate_rad_s - last.rate_rad_s) <= 4000.0 * kDeg * 100e-6 + 1e-9);
    CHECK_NEAR(now.angle_rad - last.angle_rad, 0.5e-4 * (now.rate_rad_s + last.rate_rad_s), 1e-6);
    last = now;
  }
}

}  // namespace

TEST_CASE(servo_goes_to_the_angle_of_its_pulse_at_170_deg_s_on_average) {
  Servo servo((ServoParameters()));
  drive(servo, 0, 340000, 59.0);
  CHECK(servo.motion(340000).angle_rad < 59.0 * kDeg);
  const uint64_t end_us = 59000000 / 170;
  CHECK_NEAR(servo.motion(end_us).angle_rad, 59.0 * kDeg, 1e-12);
  CHECK_NEAR(servo.motion(end_us).rate_rad_s, 0.0, 0.0);
}

TEST_CASE(servo_takes_a_new_target_while_moving) {
  Servo servo((ServoParameters()));
  drive(servo, 0, 150000, 80.0);
  CHECK(servo.motion(150000).rate_rad_s > 3.0);
  drive(servo, 150100, 700000, 5.0);
  CHECK_NEAR(servo.motion(700000).angle_rad, 5.0 * kDeg, 1e-12);
}

TEST_CASE(servo_lands_on_a_target_just_beyond_its_braking_distance) {
  Servo servo((ServoParameters()));
  drive(servo, 0, 150000, 80.0);
  const double target_deg = servo.motion(150000).angle_rad / kDeg + 7.0;  // braking takes 5 deg
  drive(servo, 150000, 400000, target_deg);
  CHECK_NEAR(servo.motion(400000).angle_rad, target_deg * kDeg, 1e-9);
}

TEST_CASE(servo_without_pulses_goes_limp_and_stays) {
  Servo servo((ServoParameters()));
  CHECK(servo.limp(0));
  servo.pulse(1000, pulse_for(59.0));
  CHECK(!servo.limp(101000));
  CHECK(servo.limp(101001));
  CHECK(servo.motion(101000).rate_rad_s > 3.0);
  const double at = servo.motion(200000).angle_rad;
  CHECK(at > 10.0 * kDeg);
  CHECK(at < 59.0 * kDeg);
  CHECK_NEAR(servo.motion(200000).rate_rad_s, 0.0, 0.0);
  CHECK_NEAR(servo.motion(90000000).angle_rad, at, 0.0);
}

TEST_CASE(servo_ignores_what_is_no_servo_pulse_and_stops_at_its_range) {
  Servo servo((ServoParameters()), 0.5);
  servo.pulse(1000, 3000.0);
  servo.pulse(1100, 0.0);
  CHECK(servo.limp(1200));
  servo.pulse(1300, 2500.0);
  CHECK_NEAR(servo.target_rad(), 90.0 * kDeg, 1e-12);
  servo.pulse(1400, 500.0);
  CHECK_NEAR(servo.target_rad(), 0.0, 1e-12);
}

TEST_CASE(a_reversed_servo_turns_the_other_way) {
  ServoParameters p;
  p.pulse_us_per_rad = -p.pulse_us_per_rad;
  Servo servo(p);
  servo.pulse(0, 1600.0);
  CHECK_NEAR(servo.target_rad(), 36.0 * kDeg, 1e-9);
}

TEST_CASE(a_hand_swings_only_a_limp_joint) {
  Servo servo((ServoParameters()), 0.1);
  servo.pulse(0, pulse_for(20.0));
  CHECK(!servo.swing(1000, 0.5, 2.0, 3));
  const double start = servo.motion(200000).angle_rad;
  CHECK(!servo.swing(200000, 2.0, 2.0, 3));  // beyond the stop
  CHECK(servo.swing(200000, 0.5, 2.0, 3));
  CHECK_NEAR(servo.motion(1200000).angle_rad, start + 0.5, 1e-12);
  CHECK_NEAR(servo.motion(1200000).rate_rad_s, 0.0, 1e-12);
  ServoMotion last = servo.motion(1200000);
  for (uint64_t t = 1201000; t < 6400000; t += 1000) {
    const ServoMotion now = servo.motion(t);
    CHECK_NEAR(now.angle_rad - last.angle_rad, 0.5e-3 * (now.rate_rad_s + last.rate_rad_s), 1e-8);
    CHECK_NEAR(now.rate_rad_s - last.rate_rad_s,
               0.5e-3 * (now.acceleration_rad_s2 + last.acceleration_rad_s2), 1e-7);
    last = now;
  }
  CHECK(!servo.swinging(6200000));
  CHECK_NEAR(servo.motion(6400000).angle_rad, start, 1e-12);
}

TEST_CASE(a_joint_stopped_by_a_jig_starts_again_with_the_next_pulse) {
  Servo servo((ServoParameters()));
  servo.pulse(0, pulse_for(59.0));
  servo.motion(50000);
  servo.stop_at(50000, 0.0);
  CHECK_NEAR(servo.motion(60000).angle_rad, 0.0, 0.0);
  drive(servo, 60000, 500000, 59.0);
  CHECK_NEAR(servo.motion(500000).angle_rad, 59.0 * kDeg, 1e-12);
}
