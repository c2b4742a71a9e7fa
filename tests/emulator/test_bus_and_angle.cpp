#include "check.h"
#include "sensors/angle_sensor.h"
#include "sensors/mpu6050.h"

using namespace tfsat::emulator;

namespace {
constexpr double kDeg = 0.017453292519943295;
}

TEST_CASE(bus_reaches_the_addressed_device_and_nobody_else_answers) {
  Mpu6050Parameters odd;
  odd.who_am_i = 0x70;
  Mpu6050 first, second(odd);
  I2cBus bus;
  CHECK(bus.attach(0x68, first));
  CHECK(bus.attach(0x69, second));
  CHECK(!bus.attach(0x69, first));
  uint8_t who = 0;
  CHECK(bus.read(0x68, mpu6050::kWhoAmI, &who, 1));
  CHECK(who == 0x68);
  CHECK(bus.read(0x69, mpu6050::kWhoAmI, &who, 1));
  CHECK(who == 0x70);
  CHECK(!bus.read(0x6A, mpu6050::kWhoAmI, &who, 1));
}

TEST_CASE(a_stuck_bus_is_freed_by_clocks_and_a_shorted_one_is_not) {
  Mpu6050 chip;
  I2cBus bus;
  bus.attach(0x68, chip);
  uint8_t who = 0;
  bus.set_stuck(true);
  CHECK(!bus.read(0x68, mpu6050::kWhoAmI, &who, 1));
  bus.clock_free();
  CHECK(bus.read(0x68, mpu6050::kWhoAmI, &who, 1));
  bus.set_stuck(true, true);
  bus.clock_free();
  CHECK(!bus.read(0x68, mpu6050::kWhoAmI, &who, 1));
}

TEST_CASE(bus_transfers_take_their_time) {
  I2cBus bus;
  CHECK(bus.read_duration_us(14, 400000) == 390);
  CHECK(bus.read_duration_us(6, 400000) == 210);
  CHECK(bus.write_duration_us(1, 400000) == 73);
  CHECK(bus.nack_duration_us(400000) == 28);
  // 156 bits, each 0.2 us longer; at 100 kHz the master's own bit leaves time for the rise.
  bus.set_rise_ns(200);
  CHECK(bus.read_duration_us(14, 400000) == 422);
  CHECK(bus.read_duration_us(14, 100000) == 1560);
}

TEST_CASE(angle_sensors_of_a_pair_count_against_each_other) {
  AngleSensorParameters p;
  p.zero_offset_rad = 180.0 * kDeg;
  AngleSensor near_end(p);
  p.direction = -1;
  AngleSensor far_end(p);
  CHECK(near_end.convert(45.01 * kDeg) == 2560);
  CHECK(far_end.convert(45.01 * kDeg) == 1535);
}

TEST_CASE(angle_sensor_wraps_within_twelve_bits) {
  AngleSensorParameters p;
  p.zero_offset_rad = 350.0 * kDeg;
  AngleSensor sensor(p);
  CHECK(sensor.convert(20.0 * kDeg) == 113);
  CHECK(sensor.convert(-355.0 * kDeg) == 4039);
  for (double angle = -13.0; angle < 13.0; angle += 1e-3) CHECK(sensor.convert(angle) < 4096);
  AngleSensor zero;
  CHECK(zero.convert(-1e-17) < 4096);
}

TEST_CASE(a_bent_angle_sensor_shows_once_and_twice_a_turn_terms_of_the_angle_it_ought_to_show) {
  for (int direction = -1; direction <= 1; direction += 2) {
    AngleSensorParameters p;
    p.zero_offset_rad = 3.0;
    p.direction = direction;
    const double bend[4] = {2.0 * kDeg, -1.0 * kDeg, 0.7 * kDeg, -0.4 * kDeg};
    for (int k = 0; k < 4; ++k) p.bend_rad[k] = bend[k];
    AngleSensor sensor(p);
    for (double angle = 0.0; angle < 2.5; angle += 0.01) {
      const double phi = 3.0 + direction * angle;
      const double shown = phi + bend[0] * std::sin(phi) + bend[1] * std::cos(phi) + bend[2] * std::sin(2 * phi) +
                           bend[3] * std::cos(2 * phi);
      const double counts = shown / 6.283185307179586 * 4096.0;
      CHECK_NEAR(sensor.convert(angle) + 0.5, counts, 0.5 + 1e-9);
    }
  }
}

TEST_CASE(angle_sensor_noise_is_seeded) {
  AngleSensorParameters p;
  p.zero_offset_rad = 3.0;
  p.noise_rad = 0.5 * kDeg;
  AngleSensor a(p), b(p);
  double sum = 0.0, squares = 0.0;
  const double truth = 3.0 / 6.283185307179586 * 4096.0 - 0.5;
  for (int k = 0; k < 5000; ++k) {
    const double error = a.convert(0.0) - truth;
    CHECK(b.convert(0.0) == error + truth);
    sum += error;
    squares += error * error;
  }
  CHECK_NEAR(sum / 5000, 0.0, 0.3);
  CHECK_NEAR(std::sqrt(squares / 5000), 0.5 / 360.0 * 4096.0, 0.3);
}

TEST_CASE(angle_sensor_faults) {
  AngleSensor sensor;
  const uint16_t before = sensor.convert(1.0);
  sensor.set_fault(AngleSensorFault::kFrozen);
  CHECK(sensor.convert(2.0) == before);
  sensor.set_fault(AngleSensorFault::kOpen);
  CHECK(sensor.convert(1.0) == 0);
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
  CHECK(bus.read(0x68, mpu6050::kWhoAmI, &who, 1) && who == 0x70);
  CHECK(!bus.read(0x69, mpu6050::kWhoAmI, &who, 1));
}
