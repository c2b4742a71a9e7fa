// What breaks on the robot, where it breaks: in a chip, on a bus, in a servo.
#include "robot.h"

namespace tfsat {
namespace emulator {

void Robot::set_imu_fault(int body, Mpu6050Fault fault) { imus_[static_cast<size_t>(body)].set_fault(fault); }

void Robot::swap_imus(int body, int other) {
  const size_t a = static_cast<size_t>(body), b = static_cast<size_t>(other);
  std::swap(plug_[a], plug_[b]);
  for (const size_t i : {a, b}) bus_of_slot(plug_[i]).plug(kImuAddresses[plug_[i] % 2], imus_[i]);
}

void Robot::glitch_imu(int body) {
  const size_t slot = plug_[static_cast<size_t>(body)];
  bus_of_slot(slot).glitch(kImuAddresses[slot % 2]);
}

void Robot::set_bus_stuck(int bus, bool stuck) { buses_[static_cast<size_t>(bus)].set_stuck(stuck, stuck); }

// A slave that holds its bus lets go with its supply.
void Robot::power_imus() {
  imus_powered_us_ = now_us_;
  slow_s_ = 0.0;
  for (Mpu6050& imu : imus_) imu.power_up(now_us_);
  for (I2cBus& bus : buses_) bus.set_stuck(false);
}

void Robot::set_angle_sensor_fault(int sensor, AngleSensorFault fault) {
  angle_sensors_[static_cast<size_t>(sensor)].set_fault(fault);
}

void Robot::step_gyro_bias(int body, const Vec3& step_rad_s) {
  imus_[static_cast<size_t>(body)].step_gyro_bias(step_rad_s);
}

void Robot::set_magnet_slip(int sensor, double slip_rad) {
  angle_sensors_[static_cast<size_t>(sensor)].set_slip(slip_rad);
}

void Robot::set_servo_fault(int joint, ServoFault fault) {
  servos_[static_cast<size_t>(joint)].set_fault(now_us_, fault);
}

}  // namespace emulator
}  // namespace tfsat
