// One InvenSense MPU-6050, or a part that is register-compatible (protocol::kImuParts): found,
// configured, checked and read, one I2C transfer per sampling instant.
//
// Sources: "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00 rev. 4.2 (RM),
// and "Product Specification", PS-MPU-6000A-00 rev. 3.4 (PS).
#pragma once

#include "freeze_watch.h"
#include "ports.h"

namespace tfsat {
namespace logger {

class Mpu6050 {
 public:
  // A sensor that failed is looked for again this often.
  static constexpr uint32_t kRetryUs = 100000;
  // One that missed transfers while it ran is asked at each instant for so long: a glitch is over by
  // then, and a sensor that is gone costs its bus no more.
  static constexpr uint32_t kPatienceUs = 20000;
  // From waking to valid rates: PS 6.1 gives 30 ms.
  static constexpr uint32_t kSettleUs = 50000;
  // From DEVICE_RESET to the next access (RM p. 41).
  static constexpr uint32_t kResetUs = 100000;
  // A part that wakes up measuring (MPU-6500 and later) may lose its settings without missing a
  // transfer. So each shows every so often that it kept them.
  static constexpr uint32_t kProofEveryUs = 100000;

  explicit Mpu6050(uint8_t address) : address_(address) {}

  // Ranges and filter. The sensor is identified and configured anew; before the first call it is
  // left alone.
  void apply(const protocol::LoggerSettings& settings);

  // A new instant.
  void begin() {
    fresh_ = false;
    missed_ = protocol::ErrorCode::kNone;
  }
  // Begins the transfer that this instant calls for; false when it calls for none.
  bool start(I2cBus& bus, uint64_t t_us);
  // Takes the outcome of that transfer (anything but kBusy).
  void finish(I2cResult result, uint64_t t_us);

  // A burst that nobody looks at, whatever comes of it; finish() is not called. Only while it runs.
  void start_discarded(I2cBus& bus);

  // A transfer failed while it ran: it may have lost its supply, and with it its settings. Until it
  // has shown that it kept them, nothing it says is believed.
  bool doubted() const { return doubted_; }
  // Asks for its settings; finish() takes the outcome. Only while it is doubted.
  void start_check(I2cBus& bus);
  static constexpr uint8_t kCheckBytes = 5;

  // It has not shown its settings for kProofEveryUs.
  bool proof_due(uint64_t t_us) const;
  // Asks for the one setting that a reset would change; finish() takes the outcome. One that fails
  // says nothing, and is due again.
  void start_proof(I2cBus& bus);
  static constexpr uint8_t kProofBytes = 1;

  // It is configured, and did not fail for longer than a glitch lasts.
  bool running() const { return phase_ == Phase::kRunning; }
  // The reading belongs to the last instant.
  bool fresh() const { return fresh_ && !doubted_; }
  // Why it missed the last instant, if it had not missed the one before; else none.
  protocol::ErrorCode missed() const { return missed_; }
  const protocol::ImuReading& reading() const { return reading_; }
  // An axis stood at the end of its range.
  bool clipped() const { return clipped_axes_ > 0; }

  // Register 0x75 as last read; 0 when nobody answers.
  uint8_t who_am_i() const { return who_am_i_; }
  // Why it is not running, or none.
  protocol::ErrorCode error() const { return error_; }
  // For kSensorFrozen: how long before the last burst its output first stood still.
  uint64_t still_us() const { return watch_.still_us(); }
  // When it failed while it ran: for how long before that its readings may be in other scales. A part
  // that sleeps after a reset says zeros instead, and this is 0 unless other settings were seen. Which
  // parts wake up measuring is told by has_accel_filter; of the ICM-20689 that is the safe side.
  uint64_t suspect_us() const { return suspect_us_; }

 private:
  enum class Phase : uint8_t {
    kUnused, kReset, kIdentify, kConfigure, kVerify, kSettle, kRunning
  };
  enum class Shown : uint8_t { kReading, kSettings, kProof };
  static constexpr uint8_t kAxes = 6;

  uint8_t settings_size() const;
  uint64_t unproven_us(uint64_t t_us) const;
  uint8_t proof_index() const;
  uint8_t value_of_step() const;
  void fail(protocol::ErrorCode error, uint64_t t_us, uint32_t retry_us = kRetryUs);
  void miss(protocol::ErrorCode error, uint64_t t_us);
  void accept(uint64_t t_us);
  void accept_identity(uint64_t t_us);
  void accept_settings(uint64_t t_us);
  void accept_check(bool kept, uint64_t t_us);
  void accept_burst(uint64_t t_us);
  bool believable(uint64_t t_us);

  uint8_t buffer_[protocol::ImuReading::kSize] = {};
  uint8_t settings_[kCheckBytes] = {};  // registers SMPLRT_DIV to ACCEL_CONFIG_2
  const protocol::ImuPart* part_ = nullptr;
  protocol::ImuReading reading_ = {};
  FreezeWatch watch_;
  uint64_t wait_until_us_ = 0;
  uint64_t doubted_since_us_ = 0;
  uint64_t proven_us_ = 0;
  uint64_t suspect_us_ = 0;
  uint8_t address_;
  uint8_t who_am_i_ = 0;
  uint8_t step_ = 0;
  uint8_t clipped_axes_ = 0;
  Phase phase_ = Phase::kUnused;
  protocol::ErrorCode error_ = protocol::ErrorCode::kNone;
  protocol::ErrorCode missed_ = protocol::ErrorCode::kNone;
  bool fresh_ = false;
  bool doubted_ = false;
  Shown asked_ = Shown::kReading;  // by the transfer under way, while it runs
  bool mistrusted_ = false;  // it has frozen, and not moved since
};

}  // namespace logger
}  // namespace tfsat
