// The emulated robot: both boards, servos, bodies, sensors and card, in lock-step virtual time, and
// what a person can do to it. Each board counts time with a clock of its own.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "boards/board_clock.h"
#include "boards/logger_board.h"
#include "boards/sequencer_board.h"
#include "card/block_device.h"
#include "physics/chain.h"
#include "physics/hands.h"
#include "physics/release_switches.h"
#include "physics/servo.h"
#include "physics/supply.h"
#include "sensors/angle_sensor.h"
#include "sensors/i2c_bus.h"
#include "sensors/mpu6050.h"

namespace tfsat {
namespace emulator {

constexpr int kImus = 4;
constexpr int kServoJoints = 3;
constexpr int kAngleSensors = 6;
constexpr int kSwitches = ReleaseSwitches::kCount;
constexpr int kBuses = 2;
constexpr uint8_t kImuAddresses[2] = {0x68, 0x69};  // on each bus

// What the robot is made of, imperfections included.
struct RobotParameters {
  TreeParameters tree;
  std::array<ServoParameters, kServoJoints> servos;
  std::array<Mpu6050Parameters, kImus> imus;
  std::array<Vec3, kImus> imu_positions_m;  // body frame
  std::array<AngleSensorParameters, kAngleSensors> angle_sensors;
  // A few blocks in the card's own RAM, as real cards have them: a power cut takes what was not synced.
  CardParameters card{250, 1000, 8};
  double temperature_c = 25.0;  // of the air, and of the IMUs when they get their supply
  double warming_c = 0.0;       // by how much their dies get warmer in the end
  double warming_s = 180.0;     // time constant of that
  // What each IMU stands on rings, at kMountRing_hz: the rate about an axis after its body's angular acceleration
  // changed by 1 rad/s^2 at once.
  double mount_ripple_s = 0.0;
  uint64_t seed = 1;          // of noise and contact bounce
  uint64_t session_seed = 1;  // of the logger's session ids
  double sequencer_clock_ppm = 0.0;  // within BoardClock::takes
  double logger_clock_ppm = 0.0;
  std::array<uint8_t, 8> logger_serial{{'e', 'm', 'u', 'L', 'A', 'T', 'E', 'D'}};
};

// A mount's turn against its body about the body's axes, and its rate.
struct Ring {
  Vec3 turn_rad, rate_rad_s;
};

// What an IMU is exposed to, in its body's axes: rate, angular acceleration, specific force.
struct ImuMotion {
  Vec3 rate_rad_s, acceleration_rad_s2, force_m_s2;
};

// The ends of a board's wires, by pin from 0: what each is connected to, from 0; kNoWire: nothing.
enum class Wires : uint8_t { kAngleSensors, kServos, kSequencerSwitches, kLoggerSwitches, kStrokeLine };
constexpr int kWireKinds = 5;
constexpr int kNoWire = -1;
constexpr std::array<int, kWireKinds> kWiresOfKind{{kAngleSensors, kServoJoints, kSwitches, kSwitches, 1}};
using PinSources = std::array<int, kAngleSensors>;  // as many as the largest kind has

// How one drop goes.
struct DropParameters {
  Vec3 residual_rate_rad_s;           // base body, its frame, at release
  Vec3 com_velocity_m_s;     // world, at release
  uint64_t fall_us = 2500000;         // until the capsule decelerates
  LandingPulse landing;
};

// The truth at one instant, for judging what the instruments made of it.
struct TruthRow {
  double t_s;
  double joint_angle_rad[kServoJoints];
  double attitude_xyzw[kImus][4];  // body to world
  double rate_rad_s[kImus][3];     // body frame
};

class Robot {
 public:
  Robot(const RobotParameters& parameters, std::unique_ptr<SequencerBoard> sequencer);

  SequencerBoard& sequencer() { return *sequencer_; }
  const SequencerBoard& sequencer() const { return *sequencer_; }
  LoggerBoard& logger() { return logger_; }
  BlockDevice& card() { return card_; }
  uint64_t now_us() const { return now_us_; }

  // Runs everything to this virtual time.
  void advance_to(uint64_t t_us);
  // Lets so much time pass for what is slow: the dies' warmth and the wandering of the gyros' biases. Virtual time
  // stands, neither board runs, nothing moves; without the logger's supply nothing passes.
  void pass_slowly(double duration_s);

  // Hangs the robot in the releaser: held by body 1's plate, both switches closed, as it stands.
  void seat();
  // Fixes the bodies of `mask` (bit i = body i+1) on the bench; false if it names none.
  bool hold(uint32_t mask);
  // Moves a limp joint (0 to 2) by hand; false if its servo holds it or the joint would leave its range.
  bool swing(int joint, double amplitude_rad, double period_s, unsigned cycles);
  // Moves a limp joint along the legs while the other hand holds what `hold` named; false as with `swing`, or in a fall.
  bool move_joint(int joint, const HandParameters& hands, double lead_s, const std::vector<Leg>& legs);
  // Turns what `hold` named about an axis of its first body; each leg ends at an angle from here.
  void turn(const Vec3& axis, const HandParameters& hands, double lead_s, const std::vector<Leg>& legs);
  // Keeps what `hold` named in the hands while a servo moves the joint, until the next `hold`.
  void hold_against(int joint, const HandParameters& hands, double lead_s);
  // Puts a limp joint of the held robot at this angle; false if its servo holds it, if that is
  // out of its range, or in a fall.
  bool set_joint(int joint, double angle_rad);
  // A hand moves a joint or turns the robot.
  bool swinging();
  void set_switch(int index, bool closed) { switches_.set(index, closed); }
  // A knock: the switch opens for `open_us`, then closes.
  void knock(int index, uint64_t open_us) { switches_.knock(index, now_us_, open_us); }
  // Lets go now; the switches open with contact bounce, and the robot lands after the fall.
  void drop(const DropParameters& parameters);
  // The logger's supply, and with it the card's and the IMUs': what the card had not programmed is lost.
  void set_logger_power(bool on);
  // What breaks, at once, and what is well again (robot_faults.cpp).
  void set_imu_fault(int body, Mpu6050Fault fault);
  // Exchanges the plugs of two IMUs: each answers at the other's bus and address. Twice: as it was.
  void swap_imus(int body, int other);
  // The next transfer with an IMU is disturbed, and not acknowledged.
  void glitch_imu(int body);
  // A slave holds the bus low; nine clocks do not free it, a loss of the logger's supply does.
  void set_bus_stuck(int bus, bool stuck);
  void set_angle_sensor_fault(int sensor, AngleSensorFault fault);
  void step_gyro_bias(int body, const Vec3& step_rad_s);
  void set_magnet_slip(int sensor, double slip_rad);
  void set_servo_fault(int joint, ServoFault fault);
  void set_battery_resistance(double resistance_ohm) { supply_.set_resistance(resistance_ohm); }
  void set_switch_fault(int index, SwitchFault fault) { switches_.set_fault(index, fault); }
  // Connects a pin to a source of the same kind, or to none; false if there is no such pin or source.
  bool connect(Wires wires, int pin, int source);
  void set_bounce(uint64_t bounce_us) { switches_.set_bounce(bounce_us); }
  // Within BoardClock::takes.
  void set_sequencer_clock(double ppm) { sequencer_clock_.set_ppm(now_us_, ppm); }
  void set_logger_clock(double ppm) { logger_clock_.set_ppm(now_us_, ppm); }

  bool falling() const { return chain_.mode() == ChainMode::kFree; }

  // Keeps a TruthRow each `period_us` from now on; 0 ends it.
  void record_truth(uint64_t period_us);
  const std::vector<TruthRow>& truth() const { return truth_; }
  uint64_t released_us() const { return released_us_; }
  double joint_angle_rad(int joint) const { return chain_.joints().angle_rad[joint]; }
  Vec3 com_position_m() const { return chain_.com_position_m(); }

 private:
  void step_to(uint64_t t_us);
  void step_world_to(uint64_t t_us);
  uint64_t next_step_us(uint64_t t_us) const;
  void take_sequencer_outputs();
  void move_bodies(uint64_t t_us);
  void load_supply(uint64_t t_us);
  void begin_holding(const HoldingHand& hand, int joint);
  void feed_sensors();
  void feed_imus(uint64_t t_us);
  void update_imu_motions();
  void keep_truth();
  void show_switch(int index, bool closed);
  const PinSources& wired(Wires wires) const { return wires_[static_cast<size_t>(wires)]; }
  double die_temperature_c() const;
  void ring_mounts(double dt_s);
  void power_imus();
  I2cBus& bus_of_slot(size_t slot) { return buses_[slot / 2]; }

  RobotParameters parameters_;
  std::unique_ptr<SequencerBoard> sequencer_;
  BoardClock sequencer_clock_;
  BoardClock logger_clock_;
  BlockDevice card_;
  std::array<I2cBus, kBuses> buses_;
  std::array<PinSources, kWireKinds> wires_;
  std::array<size_t, kImus> plug_{{0, 1, 2, 3}};  // of each body's IMU: its place on the buses
  std::vector<Mpu6050> imus_;
  std::array<Ring, kImus> mounts_;
  std::array<ImuMotion, kImus> imu_motions_;
  uint64_t imu_motions_at_ = 0;  // which change of the chain they are of
  std::vector<AngleSensor> angle_sensors_;
  std::vector<Servo> servos_;
  Supply supply_;
  bool supply_low_ = false;
  Chain chain_;
  HoldingHand holding_;
  int holding_joint_ = 0;
  uint64_t holding_since_us_ = 0;
  LoggerBoard logger_;
  ReleaseSwitches switches_;
  std::array<uint64_t, kServoJoints> pulse_rise_ns_{};
  DropParameters drop_;
  std::vector<TruthRow> truth_;
  uint64_t truth_period_us_ = 0;
  uint64_t next_truth_us_ = 0;
  uint64_t target_us_ = 0;
  uint64_t now_us_ = 0;
  uint64_t released_us_ = 0;
  uint64_t imus_powered_us_ = 0;
  double slow_s_ = 0.0;  // that passed with the IMUs powered and is not in virtual time
  bool logger_powered_ = false;
};

}  // namespace emulator
}  // namespace tfsat
