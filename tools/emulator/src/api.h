// The emulated robot for other languages: plain C. Every call works in virtual time; none waits.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct TfsatRobot TfsatRobot;

// SI units; vectors and tensors in the frames of robots/*.toml; matrices row by row.
typedef struct {
  uint64_t seed;          // of noise and contact bounce
  uint64_t session_seed;  // of the logger's session ids
  int32_t base_body;
  int32_t joint_inner[3];
  int32_t joint_outer[3];
  int32_t angle_direction[6];
  double body_mass_kg[4];
  double body_com_m[4][3];
  double body_inertia_kg_m2[4][9];
  double body_origin_m[4][3];
  double joint_axis[3][3];
  double joint_point_m[3][3];
  double servo_reference_pulse_us[3];
  double servo_reference_angle_rad[3];
  double servo_pulse_us_per_rad[3];
  double servo_max_rate_rad_s[3];
  double servo_acceleration_rad_s2[3];
  double servo_gain[3];          // what servos do wrong: ServoErrors of physics/servo_linkage.h
  double servo_offset_rad[3];
  double servo_backlash_rad[3];
  double servo_repeat_rad[3];
  double servo_overshoot_rad[3];
  double servo_delay_s[3];
  double servo_closing_share[3];
  double joint_min_rad[3];
  double joint_max_rad[3];
  double imu_position_m[4][3];
  double imu_sensor_to_body[4][9];
  double gyro_bias_rad_s[4][3];
  double gyro_scale[4][3];
  double gyro_noise_rad_s_rthz;
  double accel_noise_m_s2_rthz;
  double gyro_g_sensitivity[4][9];       // (rad/s) / (m/s^2): as in sensors/mpu6050.h
  double gyro_bias_slope_rad_s_c[4][3];
  double gyro_bend_s[4][3];              // this and the next four as in sensors/mpu6050.h
  double gyro_cross_axis[4][9];
  double gyro_front_end_limit_rad_s[4];
  double imu_late_s[4];
  double imu_clock_ppm[4];
  double mount_ripple_s;                 // of RobotParameters in robot.h
  double gyro_wander_rad_s;
  double gyro_wander_s;
  double gyro_shock_limit_m_s2;
  double angle_zero_offset_rad[6];
  double angle_nonlinearity_rad[6][4];  // bend_rad of sensors/angle_sensor.h
  double angle_noise_rad;
  double temperature_c;
  double warming_c;  // of the IMUs' dies, from power-up on: RobotParameters of robot.h
  double warming_s;
  double sequencer_clock_ppm;  // BoardClock of boards/board_clock.h; positive: fast
  double logger_clock_ppm;
  uint8_t imu_who_am_i[4];   // which parts they are: sensors/mpu6050.h
  uint8_t logger_serial[8];  // what tells this robot's logger from another's
} TfsatRobotConfig;

// A person's way with one motion, which rests for `lead_s` first: HandParameters of physics/hands.h.
typedef struct {
  uint64_t seed;
  double lead_s;
  double tremor_rad_s;
  double sway_rad_s;
  double reaction;
} TfsatHands;

// From where the last leg ended to the target, smoothly, and a rest there.
typedef struct {
  double target_rad;
  double duration_s;
  double rest_s;
} TfsatLeg;

enum { TFSAT_SEQUENCER = 0, TFSAT_LOGGER = 1 };
enum { TFSAT_RESET_WATCHDOG = 0, TFSAT_RESET_BROWN_OUT = 1, TFSAT_RESET_BUTTON = 2 };
enum {
  TFSAT_CARD_GOOD = 0,
  TFSAT_CARD_WRITE_PROTECTED = 1,
  TFSAT_CARD_UNREADABLE = 2,
  TFSAT_CARD_FAILING = 3,
};

// What can be broken: the fault enums of sensors/, physics/servo.h and physics/release_switches.h.
enum { TFSAT_IMU_GOOD = 0, TFSAT_IMU_DEAD = 1, TFSAT_IMU_FROZEN = 2, TFSAT_IMU_SATURATED = 3 };
enum { TFSAT_ANGLE_GOOD = 0, TFSAT_ANGLE_DEAD = 1, TFSAT_ANGLE_FROZEN = 2 };
enum { TFSAT_SERVO_GOOD = 0, TFSAT_SERVO_DEAD = 1, TFSAT_SERVO_SLOW = 2, TFSAT_SERVO_REVERSED = 3 };
enum { TFSAT_WIRES_ANGLE = 0, TFSAT_WIRES_SERVO = 1, TFSAT_WIRES_SEQUENCER_SWITCH = 2, TFSAT_WIRES_LOGGER_SWITCH = 3,
       TFSAT_WIRES_STROKE_LINE = 4 };
enum { TFSAT_SWITCH_GOOD = 0, TFSAT_SWITCH_STUCK_CLOSED = 1, TFSAT_SWITCH_STUCK_OPEN = 2 };

// To see that caller and library mean the same structure.
size_t tfsat_config_bytes(void);
size_t tfsat_truth_row_bytes(void);

// `hex_path` NULL: the sequencer's core runs natively. Else that HEX runs in an emulated ATmega32U4;
// a library built without it refuses. NULL on failure, with the reason in `error`.
TfsatRobot* tfsat_robot_new(const TfsatRobotConfig* config, const char* hex_path, char* error,
                            size_t error_bytes);
void tfsat_robot_free(TfsatRobot* robot);

uint64_t tfsat_now_us(const TfsatRobot* robot);
// 0, or -1 when the emulated processor crashed: tfsat_crash() tells how, and time stands still.
int tfsat_advance_to(TfsatRobot* robot, uint64_t t_us);
const char* tfsat_crash(const TfsatRobot* robot);
// Robot::pass_slowly of robot.h: minutes of warming and wandering in no virtual time.
void tfsat_pass_slowly(TfsatRobot* robot, double duration_s);

// Boards: bytes over the cable, power, cable.
size_t tfsat_write(TfsatRobot* robot, int board, const uint8_t* data, size_t n);
size_t tfsat_read(TfsatRobot* robot, int board, uint8_t* data, size_t capacity);

// The same, letting time pass in steps until a byte is there or it is `t_us`. Negative: a crash, see tfsat_crash.
ptrdiff_t tfsat_read_by(TfsatRobot* robot, int board, uint64_t t_us, uint64_t step_us, uint8_t* data, size_t capacity);
void tfsat_set_power(TfsatRobot* robot, int board, int on);
void tfsat_set_cable(TfsatRobot* robot, int board, int plugged);
// The sequencer's: a program on the host opens or closes its serial port (DTR); it is open at first.
void tfsat_set_port(TfsatRobot* robot, int open);
// The sequencer restarts with its supply on. Nothing happens without power.
void tfsat_reset(TfsatRobot* robot, int cause);
void tfsat_eeprom_get(TfsatRobot* robot, uint8_t* image, size_t n);
void tfsat_eeprom_set(TfsatRobot* robot, const uint8_t* image, size_t n);
// Changes of the EEPROM by the board since it was made.
uint32_t tfsat_eeprom_writes(const TfsatRobot* robot);

// The logger's stored settings, which outlast its power. A board that is to heed what is set gets it
// before its power.
size_t tfsat_logger_memory_bytes(TfsatRobot* robot);
void tfsat_logger_memory_get(TfsatRobot* robot, uint8_t* memory, size_t n);
void tfsat_logger_memory_set(TfsatRobot* robot, const uint8_t* memory, size_t n);

// The card's newest file: its size, its bytes.
size_t tfsat_card_size(TfsatRobot* robot);
void tfsat_card_read(TfsatRobot* robot, uint8_t* data, size_t n);
// All its files, whatever is wrong with the card. The first number from `from` on, or 0 after the
// last; the bytes of one; a file of whole blocks, put there by hand.
int tfsat_card_next_file(TfsatRobot* robot, int from);
size_t tfsat_card_file_size(TfsatRobot* robot, int number);
void tfsat_card_file_read(TfsatRobot* robot, int number, uint8_t* data, size_t n);
void tfsat_card_put_file(TfsatRobot* robot, int number, const uint8_t* data, size_t n);
// Taken out or pushed in; what is wrong with it; files of others leave it this many free blocks.
void tfsat_card_set_present(TfsatRobot* robot, int present);
void tfsat_card_set_defect(TfsatRobot* robot, int defect);
void tfsat_card_fill(TfsatRobot* robot, uint32_t free_blocks);
// From the next time on that the logger meets it, it counts its free room for so long.
void tfsat_card_set_mount(TfsatRobot* robot, uint32_t mount_us);

// What breaks at once, or is well again (..._GOOD, 0). Bodies, joints, buses and switches from 0 on.
void tfsat_fault_imu(TfsatRobot* robot, int body, int kind);
void tfsat_swap_imus(TfsatRobot* robot, int body, int other);  // twice: as it was
void tfsat_glitch_imu(TfsatRobot* robot, int body);  // one transfer is not acknowledged
void tfsat_fault_bus(TfsatRobot* robot, int bus, int stuck);
void tfsat_fault_angle_sensor(TfsatRobot* robot, int sensor, int kind);
// Each axis of a gyro shows so much more from now on.
void tfsat_step_gyro_bias(TfsatRobot* robot, int body, const double step_rad_s[3]);
void tfsat_slip_magnet(TfsatRobot* robot, int sensor, double slip_rad);
void tfsat_fault_servo(TfsatRobot* robot, int joint, int kind);
void tfsat_set_battery_resistance(TfsatRobot* robot, double resistance_ohm);  // negative: as a sound battery's
void tfsat_fault_switch(TfsatRobot* robot, int index, int kind);
// Connects a pin to a source of its kind (TFSAT_WIRES_...), both from 0; source -1: to nothing. 0, or -1: no such pin.
int tfsat_connect(TfsatRobot* robot, int wires, int pin, int source);
// How long the switches' contacts chatter at the next release; 0: as the data sheet has it.
void tfsat_set_bounce(TfsatRobot* robot, uint64_t bounce_us);
void tfsat_card_stalls(TfsatRobot* robot, uint64_t stall_us, uint64_t every_us);
// 0, or -1 for a clock that no board has.
int tfsat_set_clock(TfsatRobot* robot, int board, double ppm);

// What a person does.
void tfsat_seat(TfsatRobot* robot);
int tfsat_hold(TfsatRobot* robot, uint32_t body_mask);
int tfsat_swing(TfsatRobot* robot, int joint, double amplitude_rad, double period_s, unsigned cycles);
int tfsat_move_joint(TfsatRobot* robot, const TfsatHands* hands, int joint, const TfsatLeg* legs, size_t n_legs);
void tfsat_turn(TfsatRobot* robot, const TfsatHands* hands, const double axis[3], const TfsatLeg* legs,
                size_t n_legs);
void tfsat_hold_against(TfsatRobot* robot, const TfsatHands* hands, int joint);
int tfsat_set_joint(TfsatRobot* robot, int joint, double angle_rad);
int tfsat_swinging(TfsatRobot* robot);
void tfsat_set_switch(TfsatRobot* robot, int index, int closed);
void tfsat_knock(TfsatRobot* robot, int index, uint64_t open_us);
// Rates of the base body in its frame, the center of mass's velocity in the world, both at release.
void tfsat_drop(TfsatRobot* robot, const double residual_rate_rad_s[3], const double com_velocity_m_s[3],
                uint64_t fall_us);
int tfsat_falling(const TfsatRobot* robot);
uint64_t tfsat_released_us(const TfsatRobot* robot);
double tfsat_joint_angle_rad(const TfsatRobot* robot, int joint);
void tfsat_com_position(const TfsatRobot* robot, double position_m[3]);  // world

// Truth: rows of 32 doubles: t_s, joint angles (3), attitudes of the bodies (4 x xyzw), rates (4 x 3).
void tfsat_record_truth(TfsatRobot* robot, uint64_t period_us);
size_t tfsat_truth_rows(const TfsatRobot* robot);
void tfsat_truth_read(const TfsatRobot* robot, double* rows, size_t n_rows);

#ifdef __cplusplus
}
#endif
