#include "check.h"
#include "physics/servo.h"

using namespace tfsat::emulator;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr uint64_t kFrame_us = 20000;

double pulse_for(double angle_deg) { return 1500.0 + (angle_deg - 45.0) * 100.0 / 9.0; }

// A servo and its clock.
class Bench {
 public:
  explicit Bench(const ServoErrors& errors) : servo_(with(errors)) {}

  // Where the joint is, in degrees, after a second of pulses.
  double at(double command_deg) {
    for (int k = 0; k < 50; ++k) pulse(command_deg);
    return angle_deg();
  }
  void pulse(double command_deg) {
    t_us_ += kFrame_us;
    servo_.pulse(t_us_, pulse_for(command_deg));
  }
  void let_go() { t_us_ += 1000000; }
  double angle_deg() { return servo_.motion(t_us_ + kFrame_us - 1).angle_rad / kDeg; }

 private:
  static ServoParameters with(const ServoErrors& errors) {
    ServoParameters p;
    p.errors = errors;
    return p;
  }
  Servo servo_;
  uint64_t t_us_ = 0;
};

}  // namespace

TEST_CASE(a_servo_with_gain_and_offset_reaches_offset_plus_gain_times_the_pulses_angle) {
  ServoErrors errors;
  errors.gain = 0.95;
  errors.offset_rad = 1.5 * kDeg;
  Bench bench(errors);
  CHECK_NEAR(bench.at(59.0), 1.5 + 0.95 * 59.0, 1e-9);
  CHECK_NEAR(bench.at(0.0), 1.5, 1e-9);
  errors.offset_rad = -1.5 * kDeg;
  Bench low(errors);
  CHECK_NEAR(low.at(50.0), -1.5 + 0.95 * 50.0, 1e-9);
  CHECK_NEAR(low.at(0.0), 0.0, 1e-9);  // at its stop
}

TEST_CASE(backlash_keeps_half_of_it_short_of_the_target_on_the_side_it_comes_from) {
  ServoErrors errors;
  errors.backlash_rad = 0.8 * kDeg;
  Bench bench(errors);
  CHECK_NEAR(bench.at(40.0), 39.6, 1e-9);
  CHECK_NEAR(bench.at(60.0), 59.6, 1e-9);
  CHECK_NEAR(bench.at(40.0), 40.4, 1e-9);
  CHECK_NEAR(bench.at(40.5), 40.4, 1e-9);  // within the play
  CHECK_NEAR(bench.at(41.0), 40.6, 1e-9);
}

TEST_CASE(a_servo_never_stops_twice_at_the_same_place_and_its_spread_is_as_given) {
  ServoErrors errors;
  errors.repeat_rad = 0.2 * kDeg;
  Bench bench(errors), again(errors);
  double sum = 0.0, squares = 0.0;
  constexpr int kMoves = 400;
  for (int k = 0; k < kMoves; ++k) {
    const double target = 30.0 + 15.0 * (k % 3);
    const double error = bench.at(target) - target;
    CHECK(again.at(target) == error + target || std::fabs(again.angle_deg() - error - target) < 1e-12);
    sum += error;
    squares += error * error;
    CHECK_NEAR(bench.at(target), target + error, 0.0);  // and there it stays
  }
  CHECK_NEAR(sum / kMoves, 0.0, 0.04);
  CHECK_NEAR(std::sqrt(squares / kMoves), 0.2, 0.03);
  const double before = bench.at(30.0);
  CHECK(std::fabs((bench.at(60.0) - 60.0) - (bench.at(80.0) - 80.0)) > 1e-6);  // one way, and a stop between
  bench.at(30.0);
  bench.let_go();
  bench.at(60.0);
  bench.let_go();
  CHECK(std::fabs(bench.at(30.0) - before) > 1e-6);
}

TEST_CASE(a_jog_has_no_jumps_whatever_the_servo_does_wrong) {
  ServoErrors errors;
  errors.gain = 0.95;
  errors.backlash_rad = 0.8 * kDeg;
  errors.repeat_rad = 0.3 * kDeg;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    errors.seed = seed;
    Bench bench(errors);
    bench.at(20.0);
    double last = bench.angle_deg();
    for (int k = 1; k <= 600; ++k) {  // out and back at 10 deg/s
      bench.pulse(20.0 + 0.2 * (k <= 300 ? k : 600 - k));
      const double now = bench.angle_deg();
      CHECK(std::fabs(now - last) < 0.3);
      last = now;
    }
  }
}

TEST_CASE(a_servo_without_errors_stands_at_its_pulses_angle_to_the_bit) {
  Servo servo((ServoParameters()));
  const ServoParameters p;
  for (double width = 1000.0; width <= 2000.0; width += 7.0) {
    servo.pulse(static_cast<uint64_t>(width) * 1000, width);
    CHECK(servo.target_rad() == p.reference_angle_rad + (width - p.reference_pulse_us) / p.pulse_us_per_rad ||
          servo.target_rad() == p.min_angle_rad || servo.target_rad() == p.max_angle_rad);
  }
}

TEST_CASE(a_hand_leads_only_a_limp_joint_and_only_within_its_range) {
  Servo servo((ServoParameters()));
  servo.pulse(0, pulse_for(20.0));
  CHECK(!servo.follow(1000, {}, 1.0, {{1.0, 1.0, 1.0}}));
  const double start = servo.motion(500000).angle_rad;
  CHECK(!servo.follow(500000, {}, 1.0, {{1.0, 1.0, 1.0}, {1.6, 1.0, 1.0}}));
  CHECK(!servo.follow(500000, {}, 1.0, {{-0.01, 1.0, 1.0}}));
  CHECK(!servo.follow(500000, {}, 1.0, {{1.0, 0.0, 1.0}}));
  CHECK(servo.follow(500000, {}, 1.0, {{1.0, 1.0, 1.0}}));
  CHECK(servo.swinging(3499999));
  CHECK_NEAR(servo.motion(1500000).angle_rad, start, 1e-12);
  CHECK_NEAR(servo.motion(2000000).angle_rad, 0.5 * (start + 1.0), 1e-12);
  CHECK_NEAR(servo.motion(2500000).angle_rad, 1.0, 1e-12);
  CHECK(!servo.swinging(3500000));
  CHECK_NEAR(servo.motion(9000000).angle_rad, 1.0, 1e-12);
  CHECK_NEAR(servo.motion(9000000).rate_rad_s, 0.0, 0.0);
  servo.pulse(9000000, pulse_for(20.0));  // the servo takes the joint back
  CHECK_NEAR(servo.motion(9090000).rate_rad_s < -1.0, 1.0, 0.0);
}
