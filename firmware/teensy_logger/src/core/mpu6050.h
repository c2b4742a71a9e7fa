// One InvenSense MPU-6050: found, configured, checked and read, one I2C transfer per sampling
// instant.
//
// Sources: "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00 rev. 4.2 (RM),
// and "Product Specification", PS-MPU-6000A-00 rev. 3.4 (PS).
#pragma once

#include "ports.h"

namespace tfsat {
namespace logger {

namespace mpu6050 {

constexpr uint8_t kWhoAmIValue = 0x68;  // RM p. 45: the same at both addresses

// Low-pass filter 42 Hz, delay 4.8 ms, output at 1 kHz (RM p. 13). The paper's 5 Hz (its table of
// the MPU-6050) delays by 18.6 ms and smears a stroke over 0.1 s; narrower filtering can be done
// afterwards.
constexpr uint8_t kDlpfCfg = 3;
// FS_SEL 1 (RM p. 14, 31): the paper's range.
constexpr uint16_t kGyroRangeDegS = 500;
constexpr float kGyroLsbPerDegS = 65.5f;
// AFS_SEL 3 (RM p. 15, 29). The landing is a blow of 10 to 100 g, so its onset is worth the widest
// range. It costs nothing in the fall: one count is 0.49 mg, and noise alone (400 ug/sqrt(Hz), PS
// 6.2) is 2.6 mg.
constexpr uint8_t kAccelRangeG = 16;
constexpr float kAccelLsbPerG = 2048.0f;
// RM p. 30.
constexpr float kTemperatureLsbPerC = 340.0f;
constexpr float kTemperatureOffsetC = 36.53f;

}  // namespace mpu6050

class Mpu6050 {
 public:
  // A sensor that failed is looked for again this often.
  static constexpr uint32_t kRetryUs = 100000;
  // From waking to valid rates: PS 6.1 gives 30 ms.
  static constexpr uint32_t kSettleUs = 50000;

  explicit Mpu6050(uint8_t address) : address_(address) {}

  // Begins the transfer that this instant calls for; false when it calls for none.
  bool start(I2cBus& bus, uint64_t t_us);
  // Takes the outcome of that transfer (anything but kBusy).
  void finish(I2cResult result, uint64_t t_us);

  // It is configured, and its last burst was good.
  bool running() const { return phase_ == Phase::kRunning; }
  // The reading belongs to the last instant.
  bool fresh() const { return fresh_; }
  const protocol::ImuReading& reading() const { return reading_; }
  // An axis stood at the end of its range.
  bool clipped() const;

  // Register 0x75 as last read; 0 when nobody answers.
  uint8_t who_am_i() const { return who_am_i_; }
  // Why it is not running, or none.
  protocol::ErrorCode error() const { return error_; }

 private:
  enum class Phase : uint8_t { kIdentify, kConfigure, kVerify, kSettle, kRunning };

  void fail(protocol::ErrorCode error, uint64_t t_us);
  void accept(uint64_t t_us);
  void accept_burst(uint64_t t_us);

  uint8_t buffer_[protocol::ImuReading::kSize] = {};
  protocol::ImuReading reading_ = {};
  uint64_t wait_until_us_ = 0;
  uint8_t address_;
  uint8_t who_am_i_ = 0;
  uint8_t step_ = 0;
  Phase phase_ = Phase::kIdentify;
  protocol::ErrorCode error_ = protocol::ErrorCode::kNone;
  bool fresh_ = false;
};

}  // namespace logger
}  // namespace tfsat
