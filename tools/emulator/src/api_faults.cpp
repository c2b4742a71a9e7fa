// The part of the C interface that breaks things.
#include "api_config.h"
#include "api_robot.h"

using namespace tfsat::emulator;

namespace {

Mpu6050Fault imu_fault(int kind) {
  switch (kind) {
    case TFSAT_IMU_DEAD:
      return Mpu6050Fault::kDead;
    case TFSAT_IMU_FROZEN:
      return Mpu6050Fault::kFrozen;
    case TFSAT_IMU_SATURATED:
      return Mpu6050Fault::kSaturated;
    default:
      return Mpu6050Fault::kNone;
  }
}

AngleSensorFault angle_sensor_fault(int kind) {
  switch (kind) {
    case TFSAT_ANGLE_DEAD:
      return AngleSensorFault::kOpen;
    case TFSAT_ANGLE_FROZEN:
      return AngleSensorFault::kFrozen;
    default:
      return AngleSensorFault::kNone;
  }
}

ServoFault servo_fault(int kind) {
  switch (kind) {
    case TFSAT_SERVO_DEAD:
      return ServoFault::kDead;
    case TFSAT_SERVO_SLOW:
      return ServoFault::kSlow;
    case TFSAT_SERVO_REVERSED:
      return ServoFault::kReversed;
    default:
      return ServoFault::kNone;
  }
}

SwitchFault switch_fault(int kind) {
  switch (kind) {
    case TFSAT_SWITCH_STUCK_CLOSED:
      return SwitchFault::kStuckClosed;
    case TFSAT_SWITCH_STUCK_OPEN:
      return SwitchFault::kStuckOpen;
    default:
      return SwitchFault::kNone;
  }
}

}  // namespace

void tfsat_fault_imu(TfsatRobot* robot, int body, int kind) { robot->robot.set_imu_fault(body, imu_fault(kind)); }
void tfsat_swap_imus(TfsatRobot* robot, int body, int other) { robot->robot.swap_imus(body, other); }
void tfsat_glitch_imu(TfsatRobot* robot, int body) { robot->robot.glitch_imu(body); }
void tfsat_fault_bus(TfsatRobot* robot, int bus, int stuck) { robot->robot.set_bus_stuck(bus, stuck != 0); }

void tfsat_fault_angle_sensor(TfsatRobot* robot, int sensor, int kind) {
  robot->robot.set_angle_sensor_fault(sensor, angle_sensor_fault(kind));
}

void tfsat_step_gyro_bias(TfsatRobot* robot, int body, const double step_rad_s[3]) {
  robot->robot.step_gyro_bias(body, vector(step_rad_s));
}

void tfsat_slip_magnet(TfsatRobot* robot, int sensor, double slip_rad) {
  robot->robot.set_magnet_slip(sensor, slip_rad);
}

void tfsat_fault_servo(TfsatRobot* robot, int joint, int kind) {
  robot->robot.set_servo_fault(joint, servo_fault(kind));
}

void tfsat_set_battery_resistance(TfsatRobot* robot, double resistance_ohm) {
  robot->robot.set_battery_resistance(resistance_ohm < 0.0 ? kBatteryResistance_ohm : resistance_ohm);
}

void tfsat_fault_switch(TfsatRobot* robot, int index, int kind) {
  robot->robot.set_switch_fault(index, switch_fault(kind));
}

int tfsat_connect(TfsatRobot* robot, int wires, int pin, int source) {
  if (wires < 0 || wires >= kWireKinds) return -1;
  return robot->robot.connect(static_cast<Wires>(wires), pin, source) ? 0 : -1;
}

void tfsat_set_bounce(TfsatRobot* robot, uint64_t bounce_us) { robot->robot.set_bounce(bounce_us); }

void tfsat_card_stalls(TfsatRobot* robot, uint64_t stall_us, uint64_t every_us) {
  robot->robot.card().set_stalls(stall_us, every_us);
}

int tfsat_set_clock(TfsatRobot* robot, int board, double ppm) {
  if (!BoardClock::takes(ppm)) return -1;
  if (board == TFSAT_SEQUENCER) {
    robot->robot.set_sequencer_clock(ppm);
  } else {
    robot->robot.set_logger_clock(ppm);
  }
  return 0;
}
