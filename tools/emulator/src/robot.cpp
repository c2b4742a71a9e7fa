#include "robot.h"

#include <algorithm>
#include <cmath>

namespace tfsat {
namespace emulator {

namespace {

// The world moves in steps of this length; servos and bodies change little in between.
constexpr uint64_t kStepUs = 500;
constexpr uint8_t kStrokeLinePin = 3;
constexpr double kMountRing_rad_s = 6.283185307179586477 * 30.0;  // assumed: a plate on spacers
constexpr double kMountDamping = 0.03;                             // of critical; assumed

LoggerBoardParameters logger_parameters(const RobotParameters& robot) {
  LoggerBoardParameters parameters;
  std::copy(robot.logger_serial.begin(), robot.logger_serial.end(), parameters.identity.board_serial);
  return parameters;
}

}  // namespace

Robot::Robot(const RobotParameters& parameters, std::unique_ptr<SequencerBoard> sequencer)
    : parameters_(parameters),
      sequencer_(std::move(sequencer)),
      sequencer_clock_(parameters.sequencer_clock_ppm),
      logger_clock_(parameters.logger_clock_ppm),
      card_(parameters.card),
      chain_(parameters.tree),
      logger_(parameters.session_seed, logger_parameters(parameters)),
      switches_(parameters.seed ^ 0xB0C4CEu, [this](int index, bool closed) { show_switch(index, closed); }) {
  wires_.fill(PinSources{{0, 1, 2, 3, 4, 5}});
  for (const Mpu6050Parameters& imu : parameters.imus) imus_.emplace_back(imu);
  for (const AngleSensorParameters& sensor : parameters.angle_sensors) angle_sensors_.emplace_back(sensor);
  for (const ServoParameters& servo : parameters.servos) servos_.emplace_back(servo);
  for (size_t i = 0; i < kImus; ++i) bus_of_slot(i).attach(kImuAddresses[i % 2], imus_[i]);
  logger_.attach(buses_, angle_sensors_, card_);
  logger_.set_world([this](uint64_t board_us) {
    const uint64_t t_us = logger_clock_.virtual_us(board_us);
    const uint64_t here_us = std::min(t_us, target_us_);
    while (now_us_ < here_us) step_world_to(next_step_us(here_us));
    if (t_us > now_us_) feed_imus(t_us);
  });
  seat();
  feed_sensors();
}

void Robot::advance_to(uint64_t t_us) {
  target_us_ = t_us;
  while (now_us_ < t_us) {
    const uint64_t next_sample_us = logger_clock_.virtual_us(logger_.next_sample_us());
    step_to(std::min(next_step_us(t_us), std::max(next_sample_us, now_us_ + 1)));
  }
}

uint64_t Robot::next_step_us(uint64_t t_us) const {
  return std::min({t_us, (now_us_ / kStepUs + 1) * kStepUs, std::max(switches_.next_us(), now_us_ + 1)});
}

void Robot::pass_slowly(double duration_s) {
  if (!logger_powered_) return;
  slow_s_ += duration_s;
  for (Mpu6050& imu : imus_) imu.wander(duration_s);
}

// The sensors are brought to the step's end before the logger, whose samples lie there, reads them.
void Robot::step_to(uint64_t t_us) {
  step_world_to(t_us);
  logger_.advance_to(logger_clock_.board_us(t_us));
}

// All but the logger, which asks for it while it samples: reading its sensors takes time.
void Robot::step_world_to(uint64_t t_us) {
  switches_.apply_due(now_us_);
  sequencer_->advance_to(sequencer_clock_.board_us(t_us));
  take_sequencer_outputs();
  move_bodies(t_us);
  load_supply(t_us);
  ring_mounts(static_cast<double>(t_us - now_us_) * 1e-6);
  now_us_ = t_us;
  feed_sensors();
  keep_truth();
}

void Robot::take_sequencer_outputs() {
  PinEdge edge;
  while (sequencer_->take_edge(edge)) {
    if (supply_low_) continue;
    edge.t_ns = sequencer_clock_.virtual_ns(edge.t_ns);
    if (edge.pin == kStrokeLinePin) {
      if (edge.high && wired(Wires::kStrokeLine)[0] == 0) logger_.stroke_edge(logger_clock_.board_ns(edge.t_ns) / 1000);
    } else if (edge.high) {
      pulse_rise_ns_[edge.pin] = edge.t_ns;
    } else if (pulse_rise_ns_[edge.pin] != 0) {
      const int servo = wired(Wires::kServos)[edge.pin];
      if (servo == kNoWire) continue;
      servos_[static_cast<size_t>(servo)].pulse(edge.t_ns / 1000,
                                                static_cast<double>(edge.t_ns - pulse_rise_ns_[edge.pin]) / 1000.0);
    }
  }
}

void Robot::move_bodies(uint64_t t_us) {
  JointMotion joints = chain_.joints();
  for (int i = 0; i < kServoJoints; ++i) {
    const ServoMotion motion = servos_[static_cast<size_t>(i)].motion(t_us);
    joints.angle_rad[i] = motion.angle_rad;
    joints.rate_rad_s[i] = motion.rate_rad_s;
    joints.acceleration_rad_s2[i] = motion.acceleration_rad_s2;
  }
  const double held_s = static_cast<double>(t_us - holding_since_us_) * 1e-6;
  chain_.carry(holding_.at(held_s, {joints.angle_rad[holding_joint_], joints.rate_rad_s[holding_joint_],
                                    joints.acceleration_rad_s2[holding_joint_]}));
  chain_.advance(static_cast<double>(t_us - now_us_) * 1e-6, joints);
  for (int i = 0; i < kServoJoints; ++i) {
    if (chain_.locked(i)) servos_[static_cast<size_t>(i)].stop_at(t_us, chain_.joints().angle_rad[i]);
  }
  if (falling() && t_us >= released_us_ + drop_.fall_us) chain_.land(drop_.landing);
}

// The brown-out detector holds the sequencer in reset while its supply is low: pins fall at once, what the board does
// meanwhile reaches none, and it starts anew afterwards.
void Robot::load_supply(uint64_t t_us) {
  double current_A = 0.0;
  for (Servo& servo : servos_) current_A += servo.current_A(t_us);
  const bool low = supply_.low(current_A);
  if (low == supply_low_) return;
  sequencer_->reset(ResetCause::kBrownOut);
  take_sequencer_outputs();
  supply_low_ = low;
}

void Robot::feed_sensors() {
  for (int i = 0; i < kAngleSensors; ++i) {
    logger_.set_joint(i, chain_.joints().angle_rad[i / 2], chain_.joints().rate_rad_s[i / 2]);
  }
  feed_imus(now_us_);
}

// At this moment or after it: a reading that ends after what the caller asked for is taken while the world stays there.
// Rates go on as they change, for 1.6 ms at the most; what comes after that is the world's again.
void Robot::feed_imus(uint64_t t_us) {
  const double temperature_c = die_temperature_c();
  const double ahead_s = static_cast<double>(t_us - now_us_) * 1e-6;
  update_imu_motions();
  for (size_t i = 0; i < kImus; ++i) {
    const ImuMotion& motion = imu_motions_[i];
    imus_[i].sample(t_us, motion.rate_rad_s + ahead_s * motion.acceleration_rad_s2 + mounts_[i].rate_rad_s,
                    motion.force_m_s2, temperature_c);
  }
}

// Most of the time the robot rests, and they stay as they are.
void Robot::update_imu_motions() {
  if (imu_motions_at_ == chain_.changes()) return;
  imu_motions_at_ = chain_.changes();
  for (int i = 0; i < kImus; ++i) {
    const size_t at = static_cast<size_t>(i);
    imu_motions_[at] = {chain_.rate_rad_s(i), chain_.angular_acceleration_rad_s2(i),
                        chain_.specific_force_m_s2(i, parameters_.imu_positions_m[at])};
  }
}

// A mass on a spring whose foot is the body: symplectic Euler, of which a step is a twentieth of a radian.
void Robot::ring_mounts(double dt_s) {
  if (!(parameters_.mount_ripple_s > 0.0)) return;
  const double stiffness = kMountRing_rad_s * kMountRing_rad_s, drag = 2.0 * kMountDamping * kMountRing_rad_s;
  const double share = parameters_.mount_ripple_s * kMountRing_rad_s;
  for (int i = 0; i < kImus; ++i) {
    Ring& ring = mounts_[static_cast<size_t>(i)];
    ring.rate_rad_s = ring.rate_rad_s - dt_s * (share * chain_.angular_acceleration_rad_s2(i) +
                                                stiffness * ring.turn_rad + drag * ring.rate_rad_s);
    ring.turn_rad = ring.turn_rad + dt_s * ring.rate_rad_s;
  }
}

double Robot::die_temperature_c() const {
  if (parameters_.warming_c == 0.0) return parameters_.temperature_c;
  const double powered_s = static_cast<double>(now_us_ - imus_powered_us_) * 1e-6 + slow_s_;
  return parameters_.temperature_c - parameters_.warming_c * std::expm1(-powered_s / parameters_.warming_s);
}

void Robot::seat() {
  hold(1u << 0);
  switches_.clear();
  for (int i = 0; i < kSwitches; ++i) set_switch(i, true);
}

bool Robot::hold(uint32_t mask) {
  if (!chain_.hold(mask)) return false;
  begin_holding(HoldingHand(), 0);
  return true;
}

void Robot::begin_holding(const HoldingHand& hand, int joint) {
  holding_ = hand;
  holding_joint_ = joint;
  holding_since_us_ = now_us_;
}

bool Robot::swing(int joint, double amplitude_rad, double period_s, unsigned cycles) {
  return servos_[static_cast<size_t>(joint)].swing(now_us_, amplitude_rad, period_s, cycles);
}

bool Robot::move_joint(int joint, const HandParameters& hands, double lead_s, const std::vector<Leg>& legs) {
  const double start_rad = joint_angle_rad(joint);
  if (falling() || !servos_[static_cast<size_t>(joint)].follow(now_us_, hands, lead_s, legs)) return false;
  chain_.hold(chain_.held());
  begin_holding(HoldingHand::beside(hands, LegPath(start_rad, lead_s, legs), start_rad), joint);
  return true;
}

void Robot::turn(const Vec3& axis, const HandParameters& hands, double lead_s, const std::vector<Leg>& legs) {
  chain_.hold(chain_.held());
  begin_holding(HoldingHand::turning(hands, axis, LegPath(0.0, lead_s, legs)), 0);
}

void Robot::hold_against(int joint, const HandParameters& hands, double lead_s) {
  chain_.hold(chain_.held());
  begin_holding(HoldingHand::against_servo(hands, lead_s, joint_angle_rad(joint)), joint);
}

bool Robot::set_joint(int joint, double angle_rad) {
  Servo& servo = servos_[static_cast<size_t>(joint)];
  const ServoParameters& range = servo.parameters();
  if (falling() || !servo.limp(now_us_) || !(angle_rad >= range.min_angle_rad && angle_rad <= range.max_angle_rad)) return false;
  servo.stop_at(now_us_, angle_rad);
  chain_.bend(joint, angle_rad);
  return true;
}

bool Robot::swinging() {
  if (static_cast<double>(now_us_ - holding_since_us_) * 1e-6 < holding_.duration_s()) return true;
  return std::any_of(servos_.begin(), servos_.end(), [this](Servo& servo) { return servo.swinging(now_us_); });
}

void Robot::set_logger_power(bool on) {
  if (!on) card_.power_cut(PowerCut::kLosesCache);
  if (on && !logger_powered_) power_imus();
  logger_powered_ = on;
  logger_.set_power(on);
}

void Robot::drop(const DropParameters& parameters) {
  drop_ = parameters;
  begin_holding(HoldingHand(), 0);
  released_us_ = switches_.release(now_us_);
  chain_.release(parameters.residual_rate_rad_s, parameters.com_velocity_m_s);
}

void Robot::record_truth(uint64_t period_us) {
  truth_period_us_ = period_us;
  next_truth_us_ = now_us_;
  truth_.clear();
}

void Robot::keep_truth() {
  if (truth_period_us_ == 0 || now_us_ < next_truth_us_) return;
  next_truth_us_ += truth_period_us_;
  TruthRow row;
  row.t_s = static_cast<double>(now_us_) * 1e-6;
  for (int i = 0; i < kServoJoints; ++i) row.joint_angle_rad[i] = chain_.joints().angle_rad[i];
  for (int i = 0; i < kImus; ++i) {
    const Quaternion q = chain_.attitude(i);
    const Vec3 rate = chain_.rate_rad_s(i);
    row.attitude_xyzw[i][0] = q.x;
    row.attitude_xyzw[i][1] = q.y;
    row.attitude_xyzw[i][2] = q.z;
    row.attitude_xyzw[i][3] = q.w;
    row.rate_rad_s[i][0] = rate.x;
    row.rate_rad_s[i][1] = rate.y;
    row.rate_rad_s[i][2] = rate.z;
  }
  truth_.push_back(row);
}

}  // namespace emulator
}  // namespace tfsat
