#include "sensors/mpu6050.h"

#include <cstring>
#include <initializer_list>

#include "check.h"

using namespace tfsat::emulator;
using namespace tfsat::emulator::mpu6050;

namespace {

constexpr double kDeg = 0.017453292519943295;
constexpr double kG = 9.80665;
constexpr uint64_t kAwake_us = 40000;

struct Reading {
  double accel[3], temperature, gyro[3];  // LSB
};

bool set(Mpu6050& chip, uint8_t reg, uint8_t value) { return chip.write(reg, &value, 1); }

uint8_t get(Mpu6050& chip, uint8_t reg) {
  uint8_t value = 0;
  CHECK(chip.read(reg, &value, 1));
  return value;
}

Reading burst(Mpu6050& chip) {
  uint8_t raw[14];
  CHECK(chip.read(kAccelXoutH, raw, sizeof raw));
  double word[7];
  for (int i = 0; i < 7; ++i)
    word[i] = static_cast<int16_t>(static_cast<uint16_t>(raw[2 * i] << 8 | raw[2 * i + 1]));
  return {{word[0], word[1], word[2]}, word[3], {word[4], word[5], word[6]}};
}

// Awake, +-500 deg/s, +-2 g, with this DLPF_CFG, having seen all this for 100 ms or longer.
Mpu6050 started(const Mpu6050Parameters& p, uint8_t dlpf, const Vec3& rate, const Vec3& force = {0, 0, kG},
                double temperature_c = 25.0, uint64_t for_us = 100000) {
  Mpu6050 chip(p);
  chip.sample(0, rate, force, temperature_c);
  set(chip, kPwrMgmt1, 0x01);
  set(chip, kConfig, dlpf);
  set(chip, kGyroConfig, 0x08);
  chip.sample(for_us, rate, force, temperature_c);
  return chip;
}

}  // namespace

TEST_CASE(mpu_sleeps_after_power_up_and_reads_nothing) {
  Mpu6050 chip;
  for (uint64_t t = 0; t < 100000; t += 1000) chip.sample(t, {1, 1, 1}, {0, 0, kG}, 25.0);
  CHECK(get(chip, kWhoAmI) == 0x68);
  CHECK(get(chip, kPwrMgmt1) == 0x40);
  CHECK(burst(chip).accel[2] == 0.0);
}

TEST_CASE(mpu_scales_quantises_and_orders_its_burst) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {10.0 * kDeg, -20.0 * kDeg, 0.01 * kDeg});
  const Reading r = burst(chip);
  CHECK(r.gyro[0] == 655.0);
  CHECK(r.gyro[1] == -1310.0);
  CHECK(r.gyro[2] == 1.0);  // 0.655 LSB
  CHECK(r.accel[0] == 0.0);
  CHECK(r.accel[2] == 16384.0);
  CHECK_NEAR(r.temperature, -3920.0, 20.0);  // (25 - 36.53) * 340, noise of 3.4
  set(chip, kGyroConfig, 0x18);
  set(chip, kAccelConfig, 0x10);
  chip.sample(102000, {10.0 * kDeg, -20.0 * kDeg, 0.01 * kDeg}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == 164.0);
  CHECK(burst(chip).accel[2] == 4096.0);
}

TEST_CASE(mpu_clips_at_full_scale) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {600.0 * kDeg, -600.0 * kDeg, 0.0});
  CHECK(burst(chip).gyro[0] == 32767.0);
  CHECK(burst(chip).gyro[1] == -32768.0);
}

TEST_CASE(mpu_shows_bias_scale_misalignment_and_g_sensitivity) {
  Mpu6050Parameters p;
  p.gyro_bias_rad_s = {1.0 * kDeg, 0.0, 0.0};
  p.gyro_scale = {1.0, 1.03, 1.0};
  p.gyro_g_sensitivity.m[2][0] = 0.1 * kDeg / kG;
  p.accel_bias_m_s2 = {0.0, 0.0, 0.05 * kG};
  // The sensor's x axis is the body's z axis, its y axis the body's x axis.
  p.sensor_to_body = Mat3();
  p.sensor_to_body.m[2][0] = p.sensor_to_body.m[0][1] = p.sensor_to_body.m[1][2] = 1.0;
  Mpu6050 chip = started(p, 3, {100.0 * kDeg, 0.0, 20.0 * kDeg});
  const Reading r = burst(chip);
  CHECK(r.gyro[0] == std::nearbyint(21.0 * 65.5));
  CHECK(r.gyro[1] == std::nearbyint(103.0 * 65.5));
  CHECK(r.gyro[2] == std::nearbyint(0.1 * 65.5));
  CHECK(r.accel[0] == 16384.0);
  CHECK(r.accel[2] == std::nearbyint(0.05 * 16384.0));
}

TEST_CASE(mpu_updates_its_registers_at_its_own_rate) {
  const struct {
    uint8_t dlpf, divider;
    int per_second;
  } rates[] = {{0, 0, 8000}, {0, 7, 1000}, {1, 0, 1000}, {6, 4, 200}};
  for (const auto& rate : rates) {
    Mpu6050 chip = started(Mpu6050Parameters(), rate.dlpf, {});
    set(chip, kSmplrtDiv, rate.divider);
    set(chip, kIntEnable, kDataReady);
    get(chip, kIntStatus);
    int updates = 0;
    for (uint64_t t = 100000; t < 1100000; t += 25) {
      chip.sample(t, {}, {0, 0, kG}, 25.0);
      updates += get(chip, kIntStatus) & kDataReady;
    }
    CHECK_NEAR(updates, rate.per_second, 1);
  }
}

TEST_CASE(mpu_accelerometer_changes_at_1_khz_even_when_the_gyro_runs_at_8) {
  Mpu6050 chip = started(Mpu6050Parameters(), 0, {});
  int accel_changes = 0, gyro_changes = 0;
  Reading last = burst(chip);
  for (uint64_t t = 100125; t <= 200000; t += 125) {
    const double ramp = 1e-5 * static_cast<double>(t);
    chip.sample(t, {ramp, 0, 0}, {5.0 * ramp, 0, kG}, 25.0);
    const Reading now = burst(chip);
    accel_changes += now.accel[0] != last.accel[0];
    gyro_changes += now.gyro[0] != last.gyro[0];
    last = now;
  }
  CHECK_NEAR(accel_changes, 100, 1);
  CHECK_NEAR(gyro_changes, 800, 10);
}

TEST_CASE(mpu_holds_a_sample_between_two_instants) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {});
  chip.sample(100000, {}, {0, 0, kG}, 25.0);
  chip.sample(200000, {1, 1, 1}, {0, 0, kG}, 25.0);
  const Reading before = burst(chip);
  chip.sample(200999, {3, 3, 3}, {0, 0, kG}, 25.0);
  const Reading same = burst(chip);
  CHECK(std::memcmp(&before, &same, sizeof same) == 0);
  chip.sample(201000, {3, 3, 3}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] > before.gyro[0]);
  CHECK(burst(chip).gyro[0] == burst(chip).gyro[2]);
}

TEST_CASE(mpu_low_pass_delays_as_the_datasheet_says_for_every_setting) {
  const double gyro_ms[7] = {0.98, 1.9, 2.8, 4.8, 8.3, 13.4, 18.6};
  const double accel_ms[7] = {0.0, 2.0, 3.0, 4.9, 8.5, 13.8, 19.0};
  for (uint8_t dlpf = 0; dlpf < 7; ++dlpf) {
    Mpu6050 chip = started(Mpu6050Parameters(), dlpf, {});
    const double slope = 800.0 * kDeg, slope_g = 3.0 * kG;  // per second
    double t = 0.0;
    for (uint64_t k = 1; k <= 500; ++k) {
      t = 1e-3 * static_cast<double>(k);
      chip.sample(100000 + 1000 * k, {slope * t, 0, 0}, {slope_g * t, 0, kG}, 25.0);
    }
    const Reading r = burst(chip);
    CHECK_NEAR(t - r.gyro[0] / 65.5 * kDeg / slope, 1e-3 * gyro_ms[dlpf], 30e-6);
    CHECK_NEAR(t - r.accel[0] / 16384.0 * kG / slope_g, 1e-3 * accel_ms[dlpf], 30e-6);
  }
}

TEST_CASE(mpu_low_pass_has_the_stated_bandwidth_where_delay_allows_it) {
  const double gyro_hz[7] = {256, 188, 98, 42, 20, 11.9, 8.6};
  for (uint8_t dlpf = 0; dlpf < 7; ++dlpf) {
    Mpu6050 chip = started(Mpu6050Parameters(), dlpf, {});
    double largest = 0.0;
    for (uint64_t t_us = 100000; t_us < 1100000; t_us += 25) {
      const double phase = 6.283185307179586 * gyro_hz[dlpf] * 1e-6 * static_cast<double>(t_us);
      chip.sample(t_us, {400.0 * kDeg * std::sin(phase), 0, 0}, {0, 0, kG}, 25.0);
      if (t_us > 600000) largest = std::fmax(largest, burst(chip).gyro[0] / 65.5);
    }
    CHECK_NEAR(largest / 400.0, 0.7071, 0.03);
  }
}

TEST_CASE(mpu_low_pass_is_causal) {
  Mpu6050 chip = started(Mpu6050Parameters(), 6, {});
  chip.sample(200000, {}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == 0.0);
  chip.sample(201000, {5, 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] > 0.0);
}

TEST_CASE(mpu_does_not_depend_on_the_step_of_the_world) {
  Mpu6050 coarse = started(Mpu6050Parameters(), 2, {});
  Mpu6050 fine = started(Mpu6050Parameters(), 2, {});
  for (uint64_t t = 100050; t <= 200000; t += 50)
    fine.sample(t, {3e-5 * static_cast<double>(t - 100000), 0, 0}, {0, 0, kG}, 25.0);
  for (uint64_t t = 101000; t <= 200000; t += 1000)
    coarse.sample(t, {3e-5 * static_cast<double>(t - 100000), 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(coarse).gyro[0] == burst(fine).gyro[0]);
}

TEST_CASE(mpu_noise_has_its_density_and_its_seed) {
  Mpu6050Parameters p;
  p.gyro_noise_rad_s_rthz = 0.05 * kDeg;
  p.seed = 7;
  Mpu6050 a = started(p, 3, {}), b = started(p, 3, {});
  p.seed = 8;
  Mpu6050 c = started(p, 3, {});
  double sum = 0.0, squares = 0.0;
  int differ = 0;
  const int n = 20000;
  for (int k = 1; k <= n; ++k) {
    const uint64_t t = 100000 + 1000 * static_cast<uint64_t>(k);
    a.sample(t, {}, {0, 0, kG}, 25.0);
    b.sample(t, {}, {0, 0, kG}, 25.0);
    c.sample(t, {}, {0, 0, kG}, 25.0);
    const double x = burst(a).gyro[1] / 65.5;
    CHECK(burst(b).gyro[1] == burst(a).gyro[1]);
    differ += burst(c).gyro[1] != burst(a).gyro[1];
    sum += x;
    squares += x * x;
  }
  // One pole at 42 Hz passes white noise as an ideal filter of 42 Hz * pi/2 would.
  CHECK_NEAR(std::sqrt(squares / n), 0.05 * std::sqrt(42.0 * 1.5708), 0.02);
  CHECK_NEAR(sum / n, 0.0, 0.03);
  CHECK(differ > n / 2);
}

TEST_CASE(mpu_reset_takes_its_time_and_ends_asleep) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {1, 1, 1});
  CHECK(set(chip, kPwrMgmt1, kDeviceReset));
  chip.sample(105000, {1, 1, 1}, {0, 0, kG}, 25.0);
  uint8_t byte = 0;
  CHECK(!chip.read(kWhoAmI, &byte, 1));
  chip.sample(110000, {1, 1, 1}, {0, 0, kG}, 25.0);
  CHECK(get(chip, kPwrMgmt1) == 0x40);
  CHECK(get(chip, kGyroConfig) == 0x00);
  CHECK(burst(chip).gyro[0] == 0.0);
}

TEST_CASE(mpu_has_no_data_before_its_gyro_has_started) {
  Mpu6050 chip;
  chip.sample(0, {1, 0, 0}, {0, 0, kG}, 25.0);
  set(chip, kPwrMgmt1, 0x00);
  set(chip, kConfig, 3);
  chip.sample(29000, {1, 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == 0.0);
  chip.sample(kAwake_us, {1, 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == std::nearbyint(131.0 / kDeg));
}

TEST_CASE(mpu_read_only_registers_keep_their_value) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {});
  set(chip, kWhoAmI, 0x12);
  set(chip, kAccelXoutH, 0x12);
  CHECK(get(chip, kWhoAmI) == 0x68);
  CHECK(burst(chip).accel[0] == 0.0);
  uint8_t beyond[4] = {1, 1, 1, 1};
  CHECK(chip.read(0x7E, beyond, 4));
  CHECK(beyond[3] == 0);
}

TEST_CASE(mpu_faults) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {1, 0, 0});
  const double before = burst(chip).gyro[0];
  chip.set_fault(Mpu6050Fault::kFrozen);
  chip.sample(200000, {2, 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == before);
  chip.set_fault(Mpu6050Fault::kDead);
  uint8_t byte = 0;
  CHECK(!chip.read(kWhoAmI, &byte, 1));
  CHECK(!chip.write(kConfig, &byte, 1));
}

TEST_CASE(mpu_output_moves_by_its_temperature_s_noise_alone) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {});
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < 2000; ++k) {
    chip.sample(static_cast<uint64_t>(101000 + 1000 * k), {}, {0, 0, kG}, 25.0);
    const double error = burst(chip).temperature + 3920.0;
    sum += error;
    squares += error * error;
  }
  CHECK_NEAR(sum / 2000, 0.0, 0.5);
  CHECK_NEAR(std::sqrt(squares / 2000), 3.4, 0.3);
}

TEST_CASE(mpu_freezes_of_two_kinds) {
  for (const Mpu6050Fault fault : {Mpu6050Fault::kFrozen, Mpu6050Fault::kFrozenUntilReset}) {
    Mpu6050 chip = started(Mpu6050Parameters(), 3, {1, 0, 0});
    const double before = burst(chip).gyro[0];
    chip.set_fault(fault);
    set(chip, kPwrMgmt1, kDeviceReset);
    chip.sample(150000, {2, 0, 0}, {0, 0, kG}, 25.0);
    CHECK(get(chip, kPwrMgmt1) == 0x40 && get(chip, kConfig) == 0);
    set(chip, kPwrMgmt1, 0x01);
    set(chip, kGyroConfig, 0x08);
    chip.sample(250000, {2, 0, 0}, {0, 0, kG}, 25.0);
    const bool cured = fault == Mpu6050Fault::kFrozenUntilReset;
    CHECK(burst(chip).gyro[0] == (cured ? std::nearbyint(2.0 * 65.5 / kDeg) : before));
  }
}

TEST_CASE(mpu_replaced_by_another_part_says_so) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {1, 0, 0});
  chip.replace(0x12, 200000);
  CHECK(get(chip, kWhoAmI) == 0x12 && get(chip, kPwrMgmt1) == 0x40);
  CHECK(burst(chip).gyro[0] == 0.0);
}

// With the settings of a reset: 250 deg/s, 2 g, and its widest filters.
TEST_CASE(mpu_9250_wakes_up_measuring) {
  Mpu6050 chip = started(Mpu6050Parameters(), 3, {1, 0, 0});
  chip.replace(0x71, 200000);
  CHECK(get(chip, kWhoAmI) == 0x71 && get(chip, kPwrMgmt1) == 0x01);
  CHECK(burst(chip).gyro[0] == 0.0);
  chip.sample(300000, {1, 0, 0}, {0, 0, kG}, 25.0);
  CHECK(burst(chip).gyro[0] == std::nearbyint(131.0 / kDeg) && burst(chip).accel[2] == 16384.0);
}

// The accelerometer's filter is a setting of its own.
TEST_CASE(mpu_later_parts_have_their_own_delays_and_temperature) {
  for (const uint8_t who : {uint8_t{0x70}, uint8_t{0x71}, uint8_t{0x73}, uint8_t{0x98}}) {
    Mpu6050Parameters parameters;
    parameters.who_am_i = who;
    Mpu6050 chip = started(parameters, 3, {});
    set(chip, kAccelConfig2, 4);
    const double slope = 800.0 * kDeg, slope_g = 3.0 * kG;  // per second
    double t = 0.0;
    for (uint64_t k = 1; k <= 500; ++k) {
      t = 1e-3 * static_cast<double>(k);
      chip.sample(100000 + 1000 * k, {slope * t, 0, 0}, {slope_g * t, 0, kG}, 31.0);
    }
    const Reading r = burst(chip);
    CHECK_NEAR(t - r.gyro[0] / 65.5 * kDeg / slope, 5.9e-3, 30e-6);
    CHECK_NEAR(t - r.accel[0] / 16384.0 * kG / slope_g, 8.87e-3, 30e-6);
    CHECK_NEAR(r.temperature, who == 0x98 ? 1960.8 : 3338.7, 20.0);
  }
}

TEST_CASE(a_saturated_gyro_fills_its_converter_at_a_tenth_of_the_range) {
  for (const double rate : {-70.0, 3.0, 70.0}) {
    Mpu6050 chip = started(Mpu6050Parameters(), 0, {rate * kDeg, 0, 0}, {0, 0, kG}, 25.0);
    CHECK_NEAR(burst(chip).gyro[0], rate * 65.5, 1.0);
    chip.set_fault(Mpu6050Fault::kSaturated);
    chip.sample(1010000, {rate * kDeg, 0, 0}, {0, 0, kG}, 25.0);
    CHECK_NEAR(burst(chip).gyro[0], std::fmax(-32768.0, std::fmin(32767.0, rate * 655.0)), 1.0);
    CHECK(burst(chip).accel[2] == 16384);
  }
}

TEST_CASE(a_gyros_bias_follows_forces_and_the_temperature) {
  Mpu6050Parameters p;
  p.gyro_g_sensitivity.m[0][2] = 2.0 * kDeg / kG;
  p.gyro_bias_slope_rad_s_c = {0.0, 0.5 * kDeg, 0.0};
  Mpu6050 chip = started(p, 0, {}, {0, 0, kG}, 31.0);
  CHECK_NEAR(burst(chip).gyro[0], 2.0 * 65.5, 1.0);
  CHECK_NEAR(burst(chip).gyro[1], 3.0 * 65.5, 1.0);
  CHECK(burst(chip).gyro[2] == 0);
}

TEST_CASE(a_blow_beyond_the_limit_drives_all_axes_to_their_ends) {
  Mpu6050Parameters p;
  p.gyro_shock_limit_m_s2 = 20.0 * kG;
  for (const double g : {19.0, 21.0}) {
    Mpu6050 chip = started(p, 0, {}, {1.0, -1.0, g * kG}, 25.0);
    CHECK(burst(chip).gyro[0] == (g > 20.0 ? 32767 : 0));
    CHECK(burst(chip).gyro[1] == (g > 20.0 ? -32768 : 0));
  }
}

TEST_CASE(a_wandering_bias_is_slow_seeded_and_of_its_size) {
  Mpu6050Parameters p;
  p.gyro_wander_rad_s = 2.0 * kDeg;
  p.gyro_wander_s = 1.0;
  Mpu6050 chip = started(p, 0, {}, {0, 0, kG}, 25.0, 1000000), same = started(p, 0, {}, {0, 0, kG}, 25.0, 1000000);
  double squares = 0.0, last = burst(chip).gyro[0];
  for (uint64_t t_us = 1010000; t_us < 401000000; t_us += 10000) {
    chip.sample(t_us, {}, {0, 0, kG}, 25.0);
    same.sample(t_us, {}, {0, 0, kG}, 25.0);
    const double shown = burst(chip).gyro[0];
    CHECK(shown == burst(same).gyro[0]);
    CHECK(std::fabs(shown - last) < 6.0 * 2.0 * 65.5 * std::sqrt(2.0 * 0.01));
    squares += shown * shown;
    last = shown;
  }
  CHECK_NEAR(std::sqrt(squares / 40000.0) / 65.5, 2.0, 0.3);
}
