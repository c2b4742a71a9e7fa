// What parts do when they break, and what drives an IMU off, one part at a time.
#include "boards/board_clock.h"
#include "card/block_device.h"
#include "check.h"
#include "physics/servo.h"
#include "sensors/angle_sensor.h"
#include "sensors/mpu6050.h"

using namespace tfsat::emulator;
using namespace tfsat::emulator::mpu6050;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr double kG = 9.80665;

void drive(Servo& servo, uint64_t from_us, uint64_t to_us, double width_us) {
  for (uint64_t t_us = from_us; t_us <= to_us; t_us += 20000) servo.pulse(t_us, width_us);
}

double width_us(double angle_deg) { return 1500.0 + (angle_deg - 45.0) * 100.0 / 9.0; }

int16_t word(Mpu6050& chip, uint8_t reg) {
  uint8_t raw[2] = {};
  CHECK(chip.read(reg, raw, 2));
  return static_cast<int16_t>(static_cast<uint16_t>(raw[0] << 8 | raw[1]));
}

// Awake at +-500 deg/s with DLPF_CFG 0, having seen this for a second.
Mpu6050 started(const Mpu6050Parameters& p, const Vec3& rate, const Vec3& force, double temperature_c) {
  Mpu6050 chip(p);
  chip.sample(0, rate, force, temperature_c);
  const uint8_t awake = 0x01, range = 0x08;
  CHECK(chip.write(kPwrMgmt1, &awake, 1));
  CHECK(chip.write(kGyroConfig, &range, 1));
  chip.sample(1000000, rate, force, temperature_c);
  return chip;
}

}  // namespace

TEST_CASE(a_dead_servo_is_limp_and_brakes_where_it_is) {
  Servo servo{ServoParameters()};
  drive(servo, 0, 100000, width_us(80.0));
  const double before = servo.motion(110000).angle_rad;
  servo.set_fault(110000, ServoFault::kDead);
  drive(servo, 120000, 600000, width_us(80.0));
  CHECK(servo.limp(600000));
  CHECK_NEAR(servo.motion(600000).angle_rad, before + 200.0 * 200.0 / 2.0 / 4000.0 * kDeg, 0.01 * kDeg);
  CHECK(servo.swing(600000, 10.0 * kDeg, 1.0, 1));
}

TEST_CASE(a_servo_that_gets_slow_on_its_way_brakes_to_a_quarter_and_arrives) {
  for (uint64_t at_us = 20000; at_us <= 440000; at_us += 20000) {
    Servo servo{ServoParameters()};
    drive(servo, 0, at_us, width_us(80.0));
    servo.set_fault(at_us, ServoFault::kSlow);
    double last = servo.motion(at_us).angle_rad;
    for (uint64_t t_us = at_us + 1000; t_us <= at_us + 3000000; t_us += 1000) {
      if (t_us % 20000 == 0) servo.pulse(t_us, width_us(80.0));
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
  drive(servo, 20000, 1000000, width_us(60.0));
  CHECK_NEAR(servo.motion(1000000).angle_rad, 30.0 * kDeg, 1e-9);
  servo.set_fault(1000000, ServoFault::kNone);
  drive(servo, 1020000, 2000000, width_us(60.0));
  CHECK_NEAR(servo.motion(2000000).angle_rad, 60.0 * kDeg, 1e-9);
}

TEST_CASE(a_saturated_gyro_fills_its_converter_at_a_tenth_of_the_range) {
  for (const double rate : {-70.0, 3.0, 70.0}) {
    Mpu6050 chip = started(Mpu6050Parameters(), {rate * kDeg, 0, 0}, {0, 0, kG}, 25.0);
    CHECK_NEAR(word(chip, kGyroXoutH), rate * 65.5, 1.0);
    chip.set_fault(Mpu6050Fault::kSaturated);
    chip.sample(1010000, {rate * kDeg, 0, 0}, {0, 0, kG}, 25.0);
    CHECK_NEAR(word(chip, kGyroXoutH), std::fmax(-32768.0, std::fmin(32767.0, rate * 655.0)), 1.0);
    CHECK(word(chip, kAccelXoutH + 4) == 16384);
  }
}

TEST_CASE(a_gyros_bias_follows_forces_and_the_temperature) {
  Mpu6050Parameters p;
  p.gyro_g_sensitivity.m[0][2] = 2.0 * kDeg / kG;
  p.gyro_bias_slope_rad_s_c = {0.0, 0.5 * kDeg, 0.0};
  Mpu6050 chip = started(p, {}, {0, 0, kG}, 31.0);
  CHECK_NEAR(word(chip, kGyroXoutH), 2.0 * 65.5, 1.0);
  CHECK_NEAR(word(chip, kGyroXoutH + 2), 3.0 * 65.5, 1.0);
  CHECK(word(chip, kGyroXoutH + 4) == 0);
}

TEST_CASE(a_blow_beyond_the_limit_drives_all_axes_to_their_ends) {
  Mpu6050Parameters p;
  p.gyro_shock_limit_m_s2 = 20.0 * kG;
  for (const double g : {19.0, 21.0}) {
    Mpu6050 chip = started(p, {}, {1.0, -1.0, g * kG}, 25.0);
    CHECK(word(chip, kGyroXoutH) == (g > 20.0 ? 32767 : 0));
    CHECK(word(chip, kGyroXoutH + 2) == (g > 20.0 ? -32768 : 0));
  }
}

TEST_CASE(a_wandering_bias_is_slow_seeded_and_of_its_size) {
  Mpu6050Parameters p;
  p.gyro_wander_rad_s = 2.0 * kDeg;
  p.gyro_wander_s = 1.0;
  Mpu6050 chip = started(p, {}, {0, 0, kG}, 25.0), same = started(p, {}, {0, 0, kG}, 25.0);
  double squares = 0.0, last = word(chip, kGyroXoutH);
  for (uint64_t t_us = 1010000; t_us < 401000000; t_us += 10000) {
    chip.sample(t_us, {}, {0, 0, kG}, 25.0);
    same.sample(t_us, {}, {0, 0, kG}, 25.0);
    const double shown = word(chip, kGyroXoutH);
    CHECK(shown == word(same, kGyroXoutH));
    CHECK(std::fabs(shown - last) < 6.0 * 2.0 * 65.5 * std::sqrt(2.0 * 0.01));
    squares += shown * shown;
    last = shown;
  }
  CHECK_NEAR(std::sqrt(squares / 40000.0) / 65.5, 2.0, 0.3);
}

TEST_CASE(a_slipped_magnet_wraps_its_sensor) {
  AngleSensorParameters p;
  p.zero_offset_rad = 300.0 * kDeg;
  AngleSensor sensor(p);
  CHECK(sensor.convert(20.05 * kDeg) == 3641);
  sensor.set_slip(50.0 * kDeg);
  CHECK(sensor.convert(20.05 * kDeg) == 114);
  sensor.set_slip(0.0);
  CHECK(sensor.convert(20.05 * kDeg) == 3641);
}

TEST_CASE(exchanged_plugs_exchange_the_answers) {
  Mpu6050Parameters odd;
  odd.who_am_i = 0x70;
  Mpu6050 one, other(odd);
  I2cBus bus;
  bus.attach(0x68, one);
  bus.plug(0x68, other);
  bus.plug(0x69, one);  // nobody is there
  uint8_t who = 0;
  CHECK(bus.read(0x68, kWhoAmI, &who, 1) && who == 0x70);
  CHECK(!bus.read(0x69, kWhoAmI, &who, 1));
}

TEST_CASE(a_slow_card_stalls_now_and_then_or_at_each_block) {
  const uint8_t block[BlockDevice::kBlockBytes] = {};
  for (const uint64_t every_us : {0u, 100000u}) {
    BlockDevice card;
    CHECK(card.preallocate(5000) == CardResult::kOk);
    card.set_stalls(40000, every_us);
    uint64_t written = 0, stalled = 0;
    for (uint64_t t_us = 0; t_us < 4000000; t_us += 1000) {
      if (card.busy(t_us)) continue;
      CHECK(card.write(t_us, static_cast<uint32_t>(written++), block) == CardResult::kOk);
      stalled += card.busy(t_us + 30000);
    }
    CHECK(every_us == 0 ? stalled == written : stalled > 20 && stalled < 40);
    card.set_stalls(0, 0);
    CHECK(card.write(5000000, 0, block) == CardResult::kOk);
    CHECK(!card.busy(5001000));
  }
}

TEST_CASE(a_clock_that_goes_wrong_keeps_what_it_has_counted) {
  BoardClock clock(0.0);
  CHECK(clock.board_us(1000000) == 1000000);
  clock.set_ppm(1000000, 10000.0);
  CHECK(clock.board_us(1000000) == 1000000);
  CHECK(clock.board_us(3000000) == 3020000);
  CHECK(clock.virtual_us(3020000) == 3000000);
  clock.set_ppm(3000000, -10000.0);
  CHECK(clock.board_us(4000000) == 4010000);
  CHECK(clock.virtual_us(4010000) == 4000000);
  CHECK(clock.virtual_us(3000000) == 3000000);  // counted before the change
  CHECK(clock.virtual_us(UINT64_MAX) == UINT64_MAX);
  for (uint64_t t_us = 3000000; t_us < 3010000; t_us += 7) CHECK(clock.board_us(clock.virtual_us(t_us + 20000)) >= t_us + 20000);
}
