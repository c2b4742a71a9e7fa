// How the logger samples and records: factory values, checks, and their place in non-volatile
// memory.
#pragma once

#include "ports.h"

namespace tfsat {
namespace logger {

// 280 Hz, +-500 deg/s, +-16 g, 42 Hz, 400 kHz, 30 s, 32 MiB.
protocol::LoggerSettings factory_settings();

// kNone, kRateTooHigh or kLoggerSettingOutOfRange. For the first, `detail` is the highest rate that
// the buses carry; for the second, the place of the first wrong field in LoggerSettings, from 0.
protocol::ErrorCode check(const protocol::LoggerSettings& settings, int32_t& detail);

// MPU-6050 FS_SEL and AFS_SEL (register map p. 14, 15): 0 to 3 for its four ranges, else 4.
uint8_t gyro_fs_sel(uint16_t range_deg_s);
uint8_t accel_afs_sel(uint8_t range_g);
// Scales of these ranges, LSB/(deg/s) and LSB/g.
float gyro_lsb_per_deg_s(const protocol::LoggerSettings& settings);
float accel_lsb_per_g(const protocol::LoggerSettings& settings);

class SettingsStore {
 public:
  explicit SettingsStore(NonVolatile& memory) : memory_(memory) {}

  // What is stored, or the factory's where that is nothing, damaged or out of range. A rate that an
  // earlier firmware allowed and that the buses do not carry is lowered to what they do.
  void load();
  // Checks nothing. False when the memory did not keep it; then what was in force stays.
  bool store(const protocol::LoggerSettings& settings);

  const protocol::LoggerSettings& settings() const { return settings_; }
  protocol::Origin origin() const { return origin_; }

 private:
  bool read(protocol::LoggerSettings& settings);

  NonVolatile& memory_;
  protocol::LoggerSettings settings_ = factory_settings();
  protocol::Origin origin_ = protocol::Origin::kFactory;
};

}  // namespace logger
}  // namespace tfsat
