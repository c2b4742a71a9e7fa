#include "api_config.h"

#include <algorithm>
#include <cmath>

namespace tfsat {
namespace emulator {
namespace {

Mat3 matrix(const double m[9]) {
  Mat3 out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out.m[row][column] = m[3 * row + column];
  }
  return out;
}

TreeParameters tree(const TfsatRobotConfig& c) {
  TreeParameters out;
  out.n_bodies = kImus;
  out.n_joints = kServoJoints;
  out.base = c.base_body;
  for (int i = 0; i < kImus; ++i) {
    out.bodies[i] = {c.body_mass_kg[i], vector(c.body_com_m[i]), matrix(c.body_inertia_kg_m2[i]),
                     vector(c.body_origin_m[i])};
  }
  for (int i = 0; i < kServoJoints; ++i) {
    out.joints[i] = {c.joint_inner[i], c.joint_outer[i], vector(c.joint_axis[i]), vector(c.joint_point_m[i])};
  }
  return out;
}

}  // namespace

RobotParameters robot_parameters(const TfsatRobotConfig& c) {
  RobotParameters out;
  out.tree = tree(c);
  out.seed = c.seed;
  out.session_seed = c.session_seed;
  out.sequencer_clock_ppm = c.sequencer_clock_ppm;
  out.logger_clock_ppm = c.logger_clock_ppm;
  out.temperature_c = c.temperature_c;
  out.warming_c = c.warming_c;
  out.warming_s = c.warming_s;
  out.mount_ripple_s = c.mount_ripple_s;
  std::copy_n(c.logger_serial, out.logger_serial.size(), out.logger_serial.begin());
  for (size_t i = 0; i < kServoJoints; ++i) {
    ServoParameters& servo = out.servos[i];
    servo.reference_pulse_us = c.servo_reference_pulse_us[i];
    servo.reference_angle_rad = c.servo_reference_angle_rad[i];
    servo.pulse_us_per_rad = c.servo_pulse_us_per_rad[i];
    servo.max_rate_rad_s = c.servo_max_rate_rad_s[i];
    servo.acceleration_rad_s2 = c.servo_acceleration_rad_s2[i];
    servo.errors = {c.servo_gain[i], c.servo_offset_rad[i], c.servo_backlash_rad[i], c.servo_repeat_rad[i],
                    c.servo_overshoot_rad[i], static_cast<uint64_t>(std::llround(1e6 * c.servo_delay_s[i])),
                    c.servo_closing_share[i], c.seed * 41 + i};
    servo.min_angle_rad = c.joint_min_rad[i];
    servo.max_angle_rad = c.joint_max_rad[i];
  }
  for (size_t i = 0; i < kImus; ++i) {
    Mpu6050Parameters& imu = out.imus[i];
    out.imu_positions_m[i] = vector(c.imu_position_m[i]);
    imu.sensor_to_body = matrix(c.imu_sensor_to_body[i]);
    imu.gyro_bias_rad_s = vector(c.gyro_bias_rad_s[i]);
    imu.gyro_scale = vector(c.gyro_scale[i]);
    imu.gyro_bend_s = vector(c.gyro_bend_s[i]);
    imu.gyro_noise_rad_s_rthz = c.gyro_noise_rad_s_rthz;
    imu.accel_noise_m_s2_rthz = c.accel_noise_m_s2_rthz;
    imu.gyro_g_sensitivity = matrix(c.gyro_g_sensitivity[i]);
    imu.gyro_cross_axis = matrix(c.gyro_cross_axis[i]);
    imu.gyro_front_end_limit_rad_s = c.gyro_front_end_limit_rad_s[i];
    imu.late_s = c.imu_late_s[i];
    imu.clock_ppm = c.imu_clock_ppm[i];
    imu.gyro_bias_slope_rad_s_c = vector(c.gyro_bias_slope_rad_s_c[i]);
    imu.reference_c = c.temperature_c;
    imu.gyro_wander_rad_s = c.gyro_wander_rad_s;
    imu.gyro_wander_s = c.gyro_wander_s;
    imu.gyro_shock_limit_m_s2 = c.gyro_shock_limit_m_s2;
    imu.who_am_i = c.imu_who_am_i[i];
    imu.seed = c.seed * 31 + i;
  }
  for (size_t i = 0; i < kAngleSensors; ++i) {
    AngleSensorParameters& sensor = out.angle_sensors[i];
    sensor.zero_offset_rad = c.angle_zero_offset_rad[i];
    sensor.direction = c.angle_direction[i];
    std::copy_n(c.angle_nonlinearity_rad[i], 4, sensor.bend_rad);
    sensor.noise_rad = c.angle_noise_rad;
    sensor.seed = c.seed * 37 + i;
  }
  return out;
}

}  // namespace emulator
}  // namespace tfsat
