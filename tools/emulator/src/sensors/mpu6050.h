// InvenSense MPU-6050, or a later part with the same registers, as an I2C slave at register level.
//
// Sources: "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00 rev. 4.2 (RM),
// and "Product Specification", PS-MPU-6000A-00 rev. 3.4 (PS); of the later parts
// RM-MPU-6500A-00 rev. 2.1, RM-MPU-9250A-00 rev. 1.6 and DS-000143. Not modelled: FIFO, DMP, auxiliary
// master, self-test, motion detection, interrupt pin; their registers keep what is written and do
// nothing.
#pragma once

#include <cstdint>

#include "../physics/linalg.h"
#include "i2c_bus.h"
#include "low_pass.h"
#include "noise.h"

namespace tfsat {
namespace emulator {

namespace mpu6050 {  // RM section 3: register addresses
constexpr uint8_t kSmplrtDiv = 0x19;
constexpr uint8_t kConfig = 0x1A;
constexpr uint8_t kGyroConfig = 0x1B;
constexpr uint8_t kAccelConfig = 0x1C;
constexpr uint8_t kAccelConfig2 = 0x1D;  // of the later parts
constexpr uint8_t kIntEnable = 0x38;
constexpr uint8_t kIntStatus = 0x3A;
constexpr uint8_t kAccelXoutH = 0x3B;
constexpr uint8_t kTempOutH = 0x41;
constexpr uint8_t kGyroXoutH = 0x43;
constexpr uint8_t kGyroZoutL = 0x48;
constexpr uint8_t kPwrMgmt1 = 0x6B;
constexpr uint8_t kWhoAmI = 0x75;
constexpr uint8_t kDeviceReset = 0x80;  // PWR_MGMT_1 bit 7
constexpr uint8_t kSleep = 0x40;        // PWR_MGMT_1 bit 6
constexpr uint8_t kDataReady = 0x01;    // INT_ENABLE and INT_STATUS bit 0
}  // namespace mpu6050

// An ideal chip by default: every error of gyro and accelerometer is off.
struct Mpu6050Parameters {
  Mat3 sensor_to_body = Mat3::identity();  // misalignment: rotation from sensor to body frame
  Vec3 gyro_bias_rad_s;                    // sensor axes
  Vec3 gyro_scale{1.0, 1.0, 1.0};          // reading / truth
  double gyro_noise_rad_s_rthz = 0.0;      // white; PS 6.1 typical: 0.005 deg/s/sqrt(Hz)
  Vec3 gyro_bend_s;                        // what each scale factor gains with the magnitude of the rate, per rad/s
  Mat3 gyro_cross_axis;                    // share of each axis' rate that another axis shows on top: row shows, column turns
  // What the chip's front end shows at most, before its low-pass: no count is at its end then; 0: no such limit.
  double gyro_front_end_limit_rad_s = 0.0;
  double late_s = 0.0;                     // everything it shows comes so much later; at most LowPass::kMostLate_s
  double clock_ppm = 0.0;                  // its own oscillator runs so much faster: conversions, filters, outputs
  Mat3 gyro_g_sensitivity;                 // (rad/s) / (m/s^2); PS 6.1 typical: 0.1 deg/s/g
  Vec3 gyro_bias_slope_rad_s_c;            // of the bias with the temperature, from reference_c on
  double reference_c = 25.0;
  // In-run wander of each axis' bias: standard deviation of a first-order Gauss-Markov process.
  double gyro_wander_rad_s = 0.0;
  double gyro_wander_s = 100.0;            // its correlation time; assumed
  // A blow harder than this drives the gyros' proof masses against their stops; 0: none does.
  double gyro_shock_limit_m_s2 = 0.0;
  Vec3 accel_bias_m_s2;
  Vec3 accel_scale{1.0, 1.0, 1.0};
  double accel_noise_m_s2_rthz = 0.0;      // white; PS 6.2 typical: 400 ug/sqrt(Hz)
  // Of each value. PS gives none; assumed. An output that never moves would be a frozen chip's.
  double temperature_noise_c = 0.01;
  // Which part it is: 0x68, 0x70, 0x71, 0x73 or 0x98. Another answers so and is an MPU-6050.
  uint8_t who_am_i = 0x68;
  uint64_t gyro_startup_us = 30000;        // PS 6.1: from sleep to valid data
  uint64_t reset_us = 10000;               // DEVICE_RESET to acknowledging again; assumed
  uint64_t seed = 1;
};

enum class Mpu6050Fault : uint8_t {
  kNone,
  kDead,              // no acknowledge
  kFrozen,            // the data registers keep their values, whatever the master does
  kFrozenUntilReset,  // the same until DEVICE_RESET or a loss of power
  kSaturated,         // the gyros' drive loop has lost its gain control: a tenth of the range fills the converter
};

class Mpu6050 : public I2cDevice {
 public:
  explicit Mpu6050(const Mpu6050Parameters& parameters = Mpu6050Parameters());

  // The world at `t_us` (not before the last call), body frame. Between two calls the truth is
  // taken as linear, so the step is the world's choice.
  void sample(uint64_t t_us, const Vec3& rate_rad_s, const Vec3& specific_force_m_s2,
              double temperature_c);

  // As of the last sample(). A burst is one instant, its beginning: the chip's bus interface holds what
  // it shows while it is at work (RM p. 31, register 59 to 64).
  bool write(uint8_t reg, const uint8_t* data, size_t n) override;
  bool read(uint8_t reg, uint8_t* data, size_t n) override;

  // From now on each axis shows so much more.
  void step_gyro_bias(const Vec3& step_rad_s) { parameters_.gyro_bias_rad_s = parameters_.gyro_bias_rad_s + step_rad_s; }
  // The biases go on wandering for so long, in one stride.
  void wander(double duration_s);
  void power_up(uint64_t t_us);  // all registers as after power-on
  // Another part in this one's place: powers it up.
  void replace(uint8_t who_am_i, uint64_t t_us) {
    parameters_.who_am_i = who_am_i;
    power_up(t_us);
  }
  void set_fault(Mpu6050Fault fault) { fault_ = fault; }

 private:
  struct Truth {
    double channel[6];  // gyro x y z (rad/s), accel x y z (m/s^2), sensor axes, errors included
    double temperature_c;
  };
  Truth measured(const Vec3& rate_rad_s, const Vec3& specific_force_m_s2,
                 double temperature_c) const;
  bool ready() const { return now_us_ >= reset_until_us_; }
  bool frozen() const {
    return fault_ == Mpu6050Fault::kFrozen || fault_ == Mpu6050Fault::kFrozenUntilReset;
  }
  uint64_t tick_us(uint64_t tick) const {
    return static_cast<uint64_t>(static_cast<double>(tick) * tick_length_us_ + 0.5);
  }
  void reset_registers();
  void configure_filters();
  void write_register(uint8_t reg, uint8_t value);
  void tick(const Truth& truth);
  void update_data_registers(double temperature_c);
  void put_word(uint8_t reg, double value);

  Mpu6050Parameters parameters_;
  double tick_length_us_;  // true time between two conversions
  Mpu6050Fault fault_ = Mpu6050Fault::kNone;
  Noise noise_;
  Noise temperature_noise_;
  Noise wander_noise_;
  uint8_t registers_[128] = {};
  LowPass filters_[6];
  double wander_rad_s_[3] = {};
  double accel_held_[3] = {};       // the accelerometer's output changes at 1 kHz
  Truth last_truth_ = {};
  bool has_truth_ = false;
  bool fill_filters_ = true;        // after waking: start from the present instead of from zero
  uint64_t now_us_ = 0;
  uint64_t tick_ = 0;               // conversions since time zero, 8 kHz by the chip's clock
  uint64_t reset_until_us_ = 0;
  uint64_t awake_since_us_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
