#include "mpu6050.h"

#include <string.h>

namespace tfsat {
namespace logger {

using protocol::ErrorCode;

namespace {

constexpr uint8_t kRegSmplrtDiv = 0x19;    // RM p. 11; 0x19 to 0x1C are read back together
constexpr uint8_t kRegAccelXoutH = 0x3B;   // RM p. 29; burst up to GYRO_ZOUT_L 0x48, p. 31
constexpr uint8_t kRegPwrMgmt1 = 0x6B;     // RM p. 40
constexpr uint8_t kRegWhoAmI = 0x75;       // RM p. 45

struct RegisterValue {
  uint8_t reg;
  uint8_t value;
};

constexpr RegisterValue kConfiguration[] = {
    {kRegPwrMgmt1, 0x01},              // awake, clock from the x gyro (RM p. 40 recommends a gyro)
    {0x6C, 0x00},                      // PWR_MGMT_2, RM p. 42: all axes on
    {0x6A, 0x00},                      // USER_CTRL, RM p. 38: no FIFO, no auxiliary bus
    {0x38, 0x00},                      // INT_ENABLE, RM p. 27: the interrupt pin is not wired
    {kRegSmplrtDiv, 0x00},             // output rate = 1 kHz
    {0x1A, mpu6050::kDlpfCfg},         // CONFIG, RM p. 13
    {0x1B, 1 << 3},                    // GYRO_CONFIG, RM p. 14: FS_SEL 1
    {0x1C, 3 << 3},                    // ACCEL_CONFIG, RM p. 15: AFS_SEL 3
};
constexpr uint8_t kSteps = sizeof kConfiguration / sizeof kConfiguration[0];
constexpr uint8_t kVerifiedSteps = 4;  // the last four stand in a row from kRegSmplrtDiv

ErrorCode error_of(I2cResult result) {
  return result == I2cResult::kNack ? ErrorCode::kSensorMissing : ErrorCode::kBusStuck;
}

int16_t big_endian(const uint8_t* bytes) {
  return static_cast<int16_t>(static_cast<uint16_t>((bytes[0] << 8) | bytes[1]));
}

bool at_end_of_range(int16_t value) { return value == INT16_MAX || value == INT16_MIN; }

}  // namespace

bool Mpu6050::start(I2cBus& bus, uint64_t t_us) {
  fresh_ = false;
  if (t_us < wait_until_us_) return false;
  switch (phase_) {
    case Phase::kIdentify:
      bus.start_read(address_, kRegWhoAmI, buffer_, 1);
      return true;
    case Phase::kConfigure:
      bus.start_write(address_, kConfiguration[step_].reg, kConfiguration[step_].value);
      return true;
    case Phase::kVerify:
      bus.start_read(address_, kRegSmplrtDiv, buffer_, kVerifiedSteps);
      return true;
    case Phase::kSettle:
    case Phase::kRunning:
      break;
  }
  bus.start_read(address_, kRegAccelXoutH, buffer_, sizeof buffer_);
  return true;
}

void Mpu6050::finish(I2cResult result, uint64_t t_us) {
  if (result != I2cResult::kDone) {
    if (phase_ == Phase::kIdentify) who_am_i_ = 0;
    fail(error_of(result), t_us);
    return;
  }
  accept(t_us);
}

// A sensor that missed once may have lost its supply, and with it its settings: it is configured
// anew before anything it says is believed again.
void Mpu6050::fail(ErrorCode error, uint64_t t_us) {
  error_ = error;
  phase_ = Phase::kIdentify;
  wait_until_us_ = t_us + kRetryUs;
}

void Mpu6050::accept(uint64_t t_us) {
  switch (phase_) {
    case Phase::kIdentify:
      who_am_i_ = buffer_[0];
      if (who_am_i_ != mpu6050::kWhoAmIValue) {
        fail(ErrorCode::kSensorMissing, t_us);
        return;
      }
      step_ = 0;
      phase_ = Phase::kConfigure;
      return;
    case Phase::kConfigure:
      if (++step_ == kSteps) phase_ = Phase::kVerify;
      return;
    case Phase::kVerify:
      for (uint8_t i = 0; i < kVerifiedSteps; ++i) {
        if (buffer_[i] != kConfiguration[kSteps - kVerifiedSteps + i].value) {
          fail(ErrorCode::kSensorMissing, t_us);
          return;
        }
      }
      phase_ = Phase::kSettle;
      wait_until_us_ = t_us + kSettleUs;
      return;
    case Phase::kSettle:
    case Phase::kRunning:
      accept_burst(t_us);
      return;
  }
}

// All zeros is what a sensor says that restarted and sleeps: the temperature alone would have to be
// 36.53 deg C to the count.
void Mpu6050::accept_burst(uint64_t t_us) {
  static const uint8_t kAsleep[sizeof buffer_] = {};
  if (memcmp(buffer_, kAsleep, sizeof buffer_) == 0) {
    fail(ErrorCode::kSensorMissing, t_us);
    return;
  }
  for (uint8_t axis = 0; axis < 3; ++axis) {
    reading_.accel[axis] = big_endian(buffer_ + 2 * axis);
    reading_.gyro[axis] = big_endian(buffer_ + 8 + 2 * axis);
  }
  reading_.temperature = big_endian(buffer_ + 6);
  phase_ = Phase::kRunning;
  error_ = ErrorCode::kNone;
  fresh_ = true;
}

bool Mpu6050::clipped() const {
  for (uint8_t axis = 0; axis < 3; ++axis) {
    if (at_end_of_range(reading_.accel[axis]) || at_end_of_range(reading_.gyro[axis])) return true;
  }
  return false;
}

}  // namespace logger
}  // namespace tfsat
