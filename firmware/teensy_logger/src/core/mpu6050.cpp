#include "mpu6050.h"

#include <string.h>

#include "settings.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;

namespace {

// RM p. 11; 0x19 to 0x1C are written and read in a row, and ACCEL_CONFIG_2, 0x1D, where there is
// one (RM-MPU-6500A-00 rev. 2.1, register 29).
constexpr uint8_t kRegSmplrtDiv = 0x19;
constexpr uint8_t kRegAccelXoutH = 0x3B;  // RM p. 29; burst up to GYRO_ZOUT_L 0x48, p. 31
constexpr uint8_t kRegPwrMgmt1 = 0x6B;    // RM p. 40
constexpr uint8_t kRegWhoAmI = 0x75;      // RM p. 45
constexpr uint8_t kDeviceReset = 0x80;    // PWR_MGMT_1

struct RegisterValue {
  uint8_t reg;
  uint8_t value;
};

// The same for all settings.
constexpr RegisterValue kWakeUp[] = {
    {kRegPwrMgmt1, 0x01},  // awake, clock from the x gyro (RM p. 40 recommends a gyro)
    {0x6C, 0x00},          // PWR_MGMT_2, RM p. 42: all axes on
    {0x6A, 0x00},          // USER_CTRL, RM p. 38: no FIFO, no auxiliary bus
    {0x38, 0x00},          // INT_ENABLE, RM p. 27: the interrupt pin is not wired
};
constexpr uint8_t kWakeUpSteps = sizeof kWakeUp / sizeof kWakeUp[0];

const protocol::ImuPart* find_part(uint8_t who_am_i) {
  for (const protocol::ImuPart& part : protocol::kImuParts) {
    if (part.who_am_i == who_am_i) return &part;
  }
  return nullptr;
}

ErrorCode error_of(I2cResult result) {
  return result == I2cResult::kNack ? ErrorCode::kSensorMissing : ErrorCode::kBusStuck;
}

int16_t big_endian(const uint8_t* bytes) {
  return static_cast<int16_t>(static_cast<uint16_t>((bytes[0] << 8) | bytes[1]));
}

bool at_end_of_range(int16_t value) { return value == INT16_MAX || value == INT16_MIN; }

}  // namespace

void Mpu6050::apply(const protocol::LoggerSettings& settings) {
  settings_[0] = 0;                  // SMPLRT_DIV, RM p. 11: the output is as fast as it can be
  settings_[1] = settings.dlpf_cfg;  // CONFIG, RM p. 13
  settings_[2] = static_cast<uint8_t>(gyro_fs_sel(settings.gyro_range_deg_s) << 3);  // RM p. 14
  settings_[3] = static_cast<uint8_t>(accel_afs_sel(settings.accel_range_g) << 3);   // RM p. 15
  settings_[4] = settings.dlpf_cfg;  // ACCEL_CONFIG_2: A_DLPF_CFG
  phase_ = Phase::kIdentify;
  wait_until_us_ = 0;
  error_ = ErrorCode::kNone;
  fresh_ = doubted_ = false;
}

uint8_t Mpu6050::settings_size() const {
  return part_->has_accel_filter ? kCheckBytes : kCheckBytes - 1;
}

uint8_t Mpu6050::value_of_step() const {
  return step_ < kWakeUpSteps ? kWakeUp[step_].value : settings_[step_ - kWakeUpSteps];
}

bool Mpu6050::start(I2cBus& bus, uint64_t t_us) {
  if (t_us < wait_until_us_) return false;
  switch (phase_) {
    case Phase::kUnused:
      return false;
    case Phase::kReset:
      bus.start_write(address_, kRegPwrMgmt1, kDeviceReset);
      return true;
    case Phase::kIdentify:
      bus.start_read(address_, kRegWhoAmI, buffer_, 1);
      return true;
    case Phase::kConfigure: {
      const uint8_t reg = step_ < kWakeUpSteps
                              ? kWakeUp[step_].reg
                              : static_cast<uint8_t>(kRegSmplrtDiv + step_ - kWakeUpSteps);
      bus.start_write(address_, reg, value_of_step());
      return true;
    }
    case Phase::kVerify:
      bus.start_read(address_, kRegSmplrtDiv, buffer_, settings_size());
      return true;
    case Phase::kSettle:
    case Phase::kRunning:
      break;
  }
  bus.start_read(address_, kRegAccelXoutH, buffer_, sizeof buffer_);
  return true;
}

void Mpu6050::start_discarded(I2cBus& bus) {
  bus.start_read(address_, kRegAccelXoutH, buffer_, sizeof buffer_);
}

void Mpu6050::start_check(I2cBus& bus) {
  asked_ = Shown::kSettings;
  bus.start_read(address_, kRegSmplrtDiv, buffer_, settings_size());
}

// The first setting that is not 0, which all are after a reset. Where none is, there is nothing to
// lose.
uint8_t Mpu6050::proof_index() const {
  uint8_t index = 0;
  while (index < settings_size() && settings_[index] == 0) ++index;
  return index;
}

bool Mpu6050::proof_due(uint64_t t_us) const {
  return fresh() && t_us - proven_us_ >= kProofEveryUs && proof_index() < settings_size();
}

void Mpu6050::start_proof(I2cBus& bus) {
  asked_ = Shown::kProof;
  bus.start_read(address_, static_cast<uint8_t>(kRegSmplrtDiv + proof_index()), buffer_,
                 kProofBytes);
}

void Mpu6050::finish(I2cResult result, uint64_t t_us) {
  const Shown asked = asked_;
  asked_ = Shown::kReading;
  if (result != I2cResult::kDone) {
    if (asked == Shown::kProof) return;  // no evidence of anything: it stays due
    if (phase_ == Phase::kIdentify) who_am_i_ = 0;
    if (phase_ == Phase::kRunning) return miss(error_of(result), t_us);
    return fail(error_of(result), t_us);
  }
  switch (asked) {
    case Shown::kReading:
      return accept(t_us);
    case Shown::kSettings:
      return accept_check(memcmp(buffer_, settings_, settings_size()) == 0, t_us);
    case Shown::kProof:
      return accept_check(buffer_[0] == settings_[proof_index()], t_us);
  }
}

// It is identified and configured anew before anything it says is believed again. What wakes up
// measuring may have lost its settings before it failed, and gone on in other scales.
void Mpu6050::fail(ErrorCode error, uint64_t t_us, uint32_t retry_us) {
  const bool may_have_gone_on = running() && part_->has_accel_filter;
  suspect_us_ = may_have_gone_on && proof_index() < settings_size() ? unproven_us(t_us) : 0;
  error_ = error;
  fresh_ = doubted_ = false;
  phase_ = Phase::kIdentify;
  wait_until_us_ = t_us + retry_us;
}

// A glitch costs the sample that it hits, a sensor that stays silent is started anew.
void Mpu6050::miss(ErrorCode error, uint64_t t_us) {
  if (!doubted_) {
    doubted_ = true;
    doubted_since_us_ = t_us;
    missed_ = error;
  }
  if (t_us - doubted_since_us_ >= kPatienceUs) fail(error, t_us);
}

void Mpu6050::accept(uint64_t t_us) {
  switch (phase_) {
    case Phase::kUnused:
      return;
    case Phase::kReset:
      phase_ = Phase::kIdentify;
      wait_until_us_ = t_us + kResetUs;
      return;
    case Phase::kIdentify:
      accept_identity(t_us);
      return;
    case Phase::kConfigure:
      if (++step_ == kWakeUpSteps + settings_size()) phase_ = Phase::kVerify;
      return;
    case Phase::kVerify:
      accept_settings(t_us);
      return;
    case Phase::kSettle:
    case Phase::kRunning:
      accept_burst(t_us);
      return;
  }
}

void Mpu6050::accept_identity(uint64_t t_us) {
  who_am_i_ = buffer_[0];
  part_ = find_part(who_am_i_);
  if (part_ == nullptr) {
    fail(ErrorCode::kSensorForeign, t_us);
    return;
  }
  step_ = 0;
  phase_ = Phase::kConfigure;
}

// What does not keep its ranges has other registers, and thus other scales.
void Mpu6050::accept_settings(uint64_t t_us) {
  if (memcmp(buffer_, settings_, settings_size()) != 0) {
    fail(ErrorCode::kSensorForeign, t_us);
    return;
  }
  proven_us_ = t_us;
  phase_ = Phase::kSettle;
  wait_until_us_ = t_us + kSettleUs;
  watch_.restart();
}

// Lost settings come back with a full start, at once. What was read since they were last shown may
// be in the scales of a reset; at that moment it was not.
void Mpu6050::accept_check(bool kept, uint64_t t_us) {
  doubted_ = false;
  if (!kept) {
    fail(ErrorCode::kSensorReset, t_us, 0);
    suspect_us_ = unproven_us(t_us);
  }
  proven_us_ = t_us;
}

uint64_t Mpu6050::unproven_us(uint64_t t_us) const {
  return t_us > proven_us_ ? t_us - proven_us_ - 1 : 0;
}

void Mpu6050::accept_burst(uint64_t t_us) {
  for (uint8_t axis = 0; axis < 3; ++axis) {
    reading_.accel[axis] = big_endian(buffer_ + 2 * axis);
    reading_.gyro[axis] = big_endian(buffer_ + 8 + 2 * axis);
  }
  reading_.temperature = big_endian(buffer_ + 6);
  clipped_axes_ = 0;
  for (uint8_t axis = 0; axis < 3; ++axis) {
    clipped_axes_ += at_end_of_range(reading_.accel[axis]);
    clipped_axes_ += at_end_of_range(reading_.gyro[axis]);
  }
  if (!believable(t_us)) return;
  phase_ = Phase::kRunning;
  error_ = ErrorCode::kNone;
  fresh_ = true;
}

// All zeros is what a sensor says that restarted and sleeps: the temperature alone would have to be
// 36.53 deg C to the count. One that stands still is reset; then its output must move before it is
// believed.
bool Mpu6050::believable(uint64_t t_us) {
  static const uint8_t kAsleep[sizeof buffer_] = {};
  if (memcmp(buffer_, kAsleep, sizeof buffer_) == 0) {
    if (mistrusted_) {
      fail(ErrorCode::kSensorFrozen, t_us);
    } else {
      fail(ErrorCode::kSensorReset, t_us, 0);
    }
    return false;
  }
  watch_.take(buffer_, clipped_axes_ == kAxes, t_us);
  if (watch_.frozen()) {
    fail(ErrorCode::kSensorFrozen, t_us);
    phase_ = Phase::kReset;
    wait_until_us_ = t_us;
    mistrusted_ = true;
    return false;
  }
  mistrusted_ = mistrusted_ && !watch_.moved();
  return !mistrusted_;
}

}  // namespace logger
}  // namespace tfsat
