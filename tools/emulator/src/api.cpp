#include "api.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>

#include "api_config.h"
#include "api_robot.h"
#include "boards/native_sequencer.h"

#ifdef TFSAT_WITH_SIMAVR
#include "boards/avr_sequencer.h"
#endif

using namespace tfsat::emulator;

namespace {

std::unique_ptr<SequencerBoard> make_sequencer(const char* hex_path, std::string& error) {
  if (hex_path == nullptr) return std::make_unique<NativeSequencer>();
#ifdef TFSAT_WITH_SIMAVR
  try {
    return std::make_unique<AvrSequencer>(hex_path);
  } catch (const std::exception& refused) {
    error = refused.what();
    return nullptr;
  }
#else
  error = "this library was built without the AVR emulation";
  return nullptr;
#endif
}

HandParameters hand(const TfsatHands& h) { return {h.seed, h.tremor_rad_s, h.sway_rad_s, h.reaction}; }

std::vector<Leg> path(const TfsatLeg* legs, size_t n) {
  std::vector<Leg> out;
  for (size_t i = 0; i < n; ++i) out.push_back({legs[i].target_rad, legs[i].duration_s, legs[i].rest_s});
  return out;
}

CardDefect card_defect(int defect) {
  switch (defect) {
    case TFSAT_CARD_WRITE_PROTECTED:
      return CardDefect::kWriteProtected;
    case TFSAT_CARD_UNREADABLE:
      return CardDefect::kUnreadable;
    case TFSAT_CARD_FAILING:
      return CardDefect::kFailing;
    default:
      return CardDefect::kNone;
  }
}

// At most `n` of the bytes.
void copy_out(const std::vector<uint8_t>& bytes, uint8_t* data, size_t n) {
  std::copy_n(bytes.begin(), std::min(n, bytes.size()), data);
}

// The reason why it cannot be emulated; empty when it can.
std::string defect_of(const RobotParameters& robot) {
  if (const char* defect = BodyTree::check(robot.tree)) return defect;
  for (const double ppm : {robot.sequencer_clock_ppm, robot.logger_clock_ppm}) {
    if (BoardClock::takes(ppm)) continue;
    char reason[96];
    std::snprintf(reason, sizeof reason, "a board's clock cannot be off by %g ppm, only by %g either way", ppm,
                  BoardClock::kMostPpm);
    return reason;
  }
  return "";
}

ResetCause reset_cause(int cause) {
  switch (cause) {
    case TFSAT_RESET_WATCHDOG:
      return ResetCause::kWatchdog;
    case TFSAT_RESET_BROWN_OUT:
      return ResetCause::kBrownOut;
    default:
      return ResetCause::kExternal;
  }
}

}  // namespace

size_t tfsat_config_bytes(void) { return sizeof(TfsatRobotConfig); }
size_t tfsat_truth_row_bytes(void) { return sizeof(TruthRow); }

TfsatRobot* tfsat_robot_new(const TfsatRobotConfig* config, const char* hex_path, char* error,
                            size_t error_bytes) {
  const RobotParameters built = robot_parameters(*config);
  std::string reason = defect_of(built);
  std::unique_ptr<SequencerBoard> sequencer;
  if (reason.empty()) sequencer = make_sequencer(hex_path, reason);
  if (!sequencer) {
    std::snprintf(error, error_bytes, "%s", reason.c_str());
    return nullptr;
  }
  return new TfsatRobot(built, std::move(sequencer));
}

void tfsat_robot_free(TfsatRobot* robot) { delete robot; }

uint64_t tfsat_now_us(const TfsatRobot* robot) { return robot->robot.now_us(); }

int tfsat_advance_to(TfsatRobot* robot, uint64_t t_us) {
  if (!robot->crash.empty()) return -1;
  try {
    robot->robot.advance_to(t_us);
  } catch (const std::exception& error) {
    robot->crash = error.what();
    return -1;
  }
  return 0;
}

const char* tfsat_crash(const TfsatRobot* robot) { return robot->crash.c_str(); }

void tfsat_pass_slowly(TfsatRobot* robot, double duration_s) { robot->robot.pass_slowly(duration_s); }

size_t tfsat_write(TfsatRobot* robot, int board, const uint8_t* data, size_t n) {
  return board == TFSAT_SEQUENCER ? robot->robot.sequencer().write(data, n) : robot->robot.logger().write(data, n);
}

size_t tfsat_read(TfsatRobot* robot, int board, uint8_t* data, size_t capacity) {
  return board == TFSAT_SEQUENCER ? robot->robot.sequencer().read(data, capacity)
                                  : robot->robot.logger().read(data, capacity);
}

ptrdiff_t tfsat_read_by(TfsatRobot* robot, int board, uint64_t t_us, uint64_t step_us, uint8_t* data,
                        size_t capacity) {
  for (;;) {
    const size_t size = tfsat_read(robot, board, data, capacity);
    const uint64_t now_us = robot->robot.now_us();
    if (size > 0 || now_us >= t_us) return static_cast<ptrdiff_t>(size);
    if (tfsat_advance_to(robot, std::min(now_us + step_us, t_us)) != 0) return -1;
  }
}

void tfsat_set_power(TfsatRobot* robot, int board, int on) {
  if (board == TFSAT_SEQUENCER) {
    robot->robot.sequencer().set_power(on != 0);
  } else {
    robot->robot.set_logger_power(on != 0);
  }
}

void tfsat_set_cable(TfsatRobot* robot, int board, int plugged) {
  if (board == TFSAT_SEQUENCER) {
    robot->robot.sequencer().set_cable(plugged != 0);
  } else {
    robot->robot.logger().set_cable(plugged != 0);
  }
}

void tfsat_set_port(TfsatRobot* robot, int open) { robot->robot.sequencer().set_port(open != 0); }

void tfsat_reset(TfsatRobot* robot, int cause) { robot->robot.sequencer().reset(reset_cause(cause)); }

void tfsat_eeprom_get(TfsatRobot* robot, uint8_t* image, size_t n) {
  robot->robot.sequencer().eeprom_get(image, n);
}

void tfsat_eeprom_set(TfsatRobot* robot, const uint8_t* image, size_t n) {
  robot->robot.sequencer().eeprom_set(image, n);
}

uint32_t tfsat_eeprom_writes(const TfsatRobot* robot) {
  return robot->robot.sequencer().eeprom_writes();
}

size_t tfsat_logger_memory_bytes(TfsatRobot* robot) { return robot->robot.logger().memory().size(); }

void tfsat_logger_memory_get(TfsatRobot* robot, uint8_t* memory, size_t n) {
  copy_out(robot->robot.logger().memory(), memory, n);
}

void tfsat_logger_memory_set(TfsatRobot* robot, const uint8_t* memory, size_t n) {
  robot->robot.logger().set_memory(std::vector<uint8_t>(memory, memory + n));
}

size_t tfsat_card_size(TfsatRobot* robot) { return robot->robot.card().bytes().size(); }

void tfsat_card_read(TfsatRobot* robot, uint8_t* data, size_t n) {
  copy_out(robot->robot.card().bytes(), data, n);
}

int tfsat_card_next_file(TfsatRobot* robot, int from) {
  return robot->robot.card().next_file(static_cast<uint16_t>(from));
}

size_t tfsat_card_file_size(TfsatRobot* robot, int number) {
  return robot->robot.card().file(static_cast<uint16_t>(number)).size();
}

void tfsat_card_file_read(TfsatRobot* robot, int number, uint8_t* data, size_t n) {
  copy_out(robot->robot.card().file(static_cast<uint16_t>(number)), data, n);
}

void tfsat_card_put_file(TfsatRobot* robot, int number, const uint8_t* data, size_t n) {
  robot->robot.card().put_file(static_cast<uint16_t>(number), std::vector<uint8_t>(data, data + n));
}

void tfsat_card_set_present(TfsatRobot* robot, int present) {
  robot->robot.card().set_present(present != 0);
}

void tfsat_card_set_defect(TfsatRobot* robot, int defect) {
  robot->robot.card().set_defect(card_defect(defect));
}

void tfsat_card_set_mount(TfsatRobot* robot, uint32_t mount_us) {
  robot->robot.card().set_mount_us(mount_us);
}

void tfsat_card_fill(TfsatRobot* robot, uint32_t free_blocks) {
  robot->robot.card().fill_up_to(free_blocks);
}

void tfsat_seat(TfsatRobot* robot) { robot->robot.seat(); }
int tfsat_hold(TfsatRobot* robot, uint32_t body_mask) { return robot->robot.hold(body_mask); }

int tfsat_swing(TfsatRobot* robot, int joint, double amplitude_rad, double period_s, unsigned cycles) {
  return robot->robot.swing(joint, amplitude_rad, period_s, cycles);
}

int tfsat_move_joint(TfsatRobot* robot, const TfsatHands* hands, int joint, const TfsatLeg* legs, size_t n_legs) {
  return robot->robot.move_joint(joint, hand(*hands), hands->lead_s, path(legs, n_legs));
}

void tfsat_turn(TfsatRobot* robot, const TfsatHands* hands, const double axis[3], const TfsatLeg* legs,
                size_t n_legs) {
  robot->robot.turn(vector(axis), hand(*hands), hands->lead_s, path(legs, n_legs));
}

void tfsat_hold_against(TfsatRobot* robot, const TfsatHands* hands, int joint) {
  robot->robot.hold_against(joint, hand(*hands), hands->lead_s);
}

int tfsat_set_joint(TfsatRobot* robot, int joint, double angle_rad) {
  return robot->robot.set_joint(joint, angle_rad);
}

int tfsat_swinging(TfsatRobot* robot) { return robot->robot.swinging(); }

void tfsat_set_switch(TfsatRobot* robot, int index, int closed) {
  robot->robot.set_switch(index, closed != 0);
}

void tfsat_knock(TfsatRobot* robot, int index, uint64_t open_us) { robot->robot.knock(index, open_us); }

void tfsat_drop(TfsatRobot* robot, const double residual_rate_rad_s[3], const double com_velocity_m_s[3],
                uint64_t fall_us) {
  DropParameters drop;
  drop.residual_rate_rad_s = vector(residual_rate_rad_s);
  drop.com_velocity_m_s = vector(com_velocity_m_s);
  drop.fall_us = fall_us;
  robot->robot.drop(drop);
}

int tfsat_falling(const TfsatRobot* robot) { return robot->robot.falling(); }
uint64_t tfsat_released_us(const TfsatRobot* robot) { return robot->robot.released_us(); }

double tfsat_joint_angle_rad(const TfsatRobot* robot, int joint) {
  return robot->robot.joint_angle_rad(joint);
}

void tfsat_com_position(const TfsatRobot* robot, double position_m[3]) {
  const Vec3 at = robot->robot.com_position_m();
  position_m[0] = at.x;
  position_m[1] = at.y;
  position_m[2] = at.z;
}

void tfsat_record_truth(TfsatRobot* robot, uint64_t period_us) { robot->robot.record_truth(period_us); }
size_t tfsat_truth_rows(const TfsatRobot* robot) { return robot->robot.truth().size(); }

void tfsat_truth_read(const TfsatRobot* robot, double* rows, size_t n_rows) {
  std::memcpy(rows, robot->robot.truth().data(), n_rows * sizeof(TruthRow));
}
