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

bool Robot::connect(Wires wires, int pin, int source) {
  const int count = kWiresOfKind[static_cast<size_t>(wires)];
  if (pin < 0 || pin >= count || source < kNoWire || source >= count) return false;
  wires_[static_cast<size_t>(wires)][static_cast<size_t>(pin)] = source;
  logger_.wire_angle_sensors(wired(Wires::kAngleSensors));
  for (int i = 0; i < kSwitches; ++i) switches_.show(i);
  return true;
}

// A pin without a wire is open by its pull-up.
void Robot::show_switch(int index, bool closed) {
  for (int pin = 0; pin < kSwitches; ++pin) {
    const int at_sequencer = wired(Wires::kSequencerSwitches)[static_cast<size_t>(pin)];
    if (at_sequencer == index || at_sequencer == kNoWire) sequencer_->set_switch(pin, closed && at_sequencer == index);
    const int at_logger = wired(Wires::kLoggerSwitches)[static_cast<size_t>(pin)];
    if (at_logger != index && at_logger != kNoWire) continue;
    logger_.set_switch(pin, closed && at_logger == index, logger_clock_.board_us(now_us_));
  }
}

}  // namespace emulator
}  // namespace tfsat
