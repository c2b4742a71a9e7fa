// A servo at its joint: motion, errors, overshoot, faults, and the jigs and persons that move a limp joint.
#include "physics/servo.h"

#include "check.h"

using namespace tfsat::emulator;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr uint64_t kFrame_us = 20000;
constexpr uint64_t kStep_us = 50;
constexpr double kBeyond_deg = 0.4;

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

void pulses(Servo& servo, uint64_t from_us, uint64_t to_us, double angle_deg) {
  for (uint64_t t_us = from_us; t_us <= to_us; t_us += kFrame_us) servo.pulse(t_us, pulse_for(angle_deg));
}

// A servo and its clock.
class Settled {
 public:
  explicit Settled(const ServoErrors& errors) : servo_(with(errors)) {}

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

ServoParameters overshooting(double beyond_deg) {
  ServoParameters p;
  p.errors.overshoot_rad = beyond_deg * kDeg;
  return p;
}

// A servo that overshoots, driven in steps; on the way it sees to it that angle, rate and acceleration belong together.
class Overshooting {
 public:
  explicit Overshooting(double beyond_deg = kBeyond_deg) : servo_(overshooting(beyond_deg)) {}

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

TEST_CASE(a_servo_with_gain_and_offset_reaches_offset_plus_gain_times_the_pulses_angle) {
  ServoErrors errors;
  errors.gain = 0.95;
  errors.offset_rad = 1.5 * kDeg;
  Settled bench(errors);
  CHECK_NEAR(bench.at(59.0), 1.5 + 0.95 * 59.0, 1e-9);
  CHECK_NEAR(bench.at(0.0), 1.5, 1e-9);
  errors.offset_rad = -1.5 * kDeg;
  Settled low(errors);
  CHECK_NEAR(low.at(50.0), -1.5 + 0.95 * 50.0, 1e-9);
  CHECK_NEAR(low.at(0.0), 0.0, 1e-9);  // at its stop
}

TEST_CASE(backlash_keeps_half_of_it_short_of_the_target_on_the_side_it_comes_from) {
  ServoErrors errors;
  errors.backlash_rad = 0.8 * kDeg;
  Settled bench(errors);
  CHECK_NEAR(bench.at(40.0), 39.6, 1e-9);
  CHECK_NEAR(bench.at(60.0), 59.6, 1e-9);
  CHECK_NEAR(bench.at(40.0), 40.4, 1e-9);
  CHECK_NEAR(bench.at(40.5), 40.4, 1e-9);  // within the play
  CHECK_NEAR(bench.at(41.0), 40.6, 1e-9);
}

TEST_CASE(a_servo_never_stops_twice_at_the_same_place_and_its_spread_is_as_given) {
  ServoErrors errors;
  errors.repeat_rad = 0.2 * kDeg;
  Settled bench(errors), again(errors);
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
    Settled bench(errors);
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

// 59 deg at 200 deg/s take 0.345 s, of which the last 0.05 s are braking.
TEST_CASE(a_motion_runs_beyond_its_end_by_the_overshoot_and_is_back_after_as_long_as_it_brakes) {
  Overshooting bench, early;
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
  Overshooting bench;
  CHECK_NEAR(bench.drive(2.5, 500000), 2.5 + kBeyond_deg / 4.0, 1e-4);
  CHECK_NEAR(bench.angle_deg(), 2.5, 1e-12);
  Overshooting slow;
  slow.fault(ServoFault::kSlow);
  CHECK_NEAR(slow.drive(40.0, 2000000), 40.0 + kBeyond_deg / 16.0, 1e-4);
}

TEST_CASE(no_joint_goes_through_its_stop) {
  Overshooting bench;
  CHECK_NEAR(bench.drive(90.0, 1000000), 90.0, 1e-9);
  CHECK_NEAR(bench.drive(60.0, 1000000), 90.0, 1e-9);
  bench.begin();
  CHECK_NEAR(bench.drive(0.1, 1000000), 0.0, 1e-9);
  CHECK_NEAR(bench.angle_deg(), 0.1, 1e-9);
}

TEST_CASE(the_next_command_may_come_at_any_moment_of_it) {
  for (uint64_t meanwhile_us = 290000; meanwhile_us <= 400000; meanwhile_us += 5000) {
    Overshooting on, back;
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
  Overshooting bench;
  CHECK_NEAR(bench.drive(59.0, 345000, 0.001), 59.0 + kBeyond_deg, 1e-3);
  CHECK_NEAR(bench.at(345000).angle_rad, (59.0 + kBeyond_deg) * kDeg, 1e-3 * kDeg);
  bench.drive(59.0, 300000, 0.001);
  CHECK_NEAR(bench.angle_deg(), 59.0, 2e-4);
}

TEST_CASE(a_servo_without_overshoot_ends_on_its_target) {
  Overshooting bench(0.0);
  CHECK(bench.drive(59.0, 1000000) == bench.angle_deg());
}

TEST_CASE(a_dead_servo_is_limp_and_brakes_where_it_is) {
  Servo servo{ServoParameters()};
  pulses(servo, 0, 100000, 80.0);
  const double before = servo.motion(110000).angle_rad;
  servo.set_fault(110000, ServoFault::kDead);
  pulses(servo, 120000, 600000, 80.0);
  CHECK(servo.limp(600000));
  CHECK_NEAR(servo.motion(600000).angle_rad, before + 200.0 * 200.0 / 2.0 / 4000.0 * kDeg, 0.01 * kDeg);
  CHECK(servo.swing(600000, 10.0 * kDeg, 1.0, 1));
}

TEST_CASE(a_servo_that_gets_slow_on_its_way_brakes_to_a_quarter_and_arrives) {
  for (uint64_t at_us = 20000; at_us <= 440000; at_us += 20000) {
    Servo servo{ServoParameters()};
    pulses(servo, 0, at_us, 80.0);
    servo.set_fault(at_us, ServoFault::kSlow);
    double last = servo.motion(at_us).angle_rad;
    for (uint64_t t_us = at_us + 1000; t_us <= at_us + 3000000; t_us += 1000) {
      if (t_us % 20000 == 0) servo.pulse(t_us, pulse_for(80.0));
      const ServoMotion now = servo.motion(t_us);
      CHECK(std::fabs(now.angle_rad - last) < 0.201 * kDeg);
      if (t_us > at_us + 60000) CHECK(now.rate_rad_s < 50.1 * kDeg);
      last = now.angle_rad;
    }
    CHECK_NEAR(last, 80.0 * kDeg, 1e-9);
  }
}

TEST_CASE(a_reversed_servo_mirrors_at_its_reference) {
  Servo servo{ServoParameters()};
  servo.set_fault(0, ServoFault::kReversed);
  pulses(servo, 20000, 1000000, 60.0);
  CHECK_NEAR(servo.motion(1000000).angle_rad, 30.0 * kDeg, 1e-9);
  servo.set_fault(1000000, ServoFault::kNone);
  pulses(servo, 1020000, 2000000, 60.0);
  CHECK_NEAR(servo.motion(2000000).angle_rad, 60.0 * kDeg, 1e-9);
}
