#include "settings.h"

#include <string.h>

#include "../protocol/crc16.h"
#include "file_budget.h"
#include "timing.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::LoggerSettings;

namespace {

constexpr uint8_t kNoRange = 4;
constexpr uint16_t kGyroRangesDegS[] = {250, 500, 1000, 2000};
constexpr float kGyroLsbPerDegS[] = {131.0f, 65.5f, 32.8f, 16.4f};  // register map p. 31
constexpr uint8_t kAccelRangesG[] = {2, 4, 8, 16};
constexpr float kAccelLsbPerG[] = {16384.0f, 8192.0f, 4096.0f, 2048.0f};  // p. 29

constexpr uint8_t kDlpfMax = 6;
constexpr uint8_t kCrcBytes = 2;
constexpr uint8_t kStoredBytes = LoggerSettings::kSize + kCrcBytes;

bool within(uint32_t value, uint32_t least, uint32_t most) {
  return value >= least && value <= most;
}

// The place of the first field that makes no sense, or -1.
int32_t first_wrong(const LoggerSettings& s) {
  using namespace protocol;
  const bool right[] = {
      within(s.rate_hz, kSampleRateMinHz, kSampleRateMaxHz),
      gyro_fs_sel(s.gyro_range_deg_s) != kNoRange,
      accel_afs_sel(s.accel_range_g) != kNoRange,
      s.dlpf_cfg <= kDlpfMax,
      s.bus_khz == 100 || s.bus_khz == 400,
      within(s.after_landing_s, kAfterLandingMinS, kAfterLandingMaxS),
      within(s.file_mib, least_file_mib(s.rate_hz, s.after_landing_s), protocol::kFileMaxMib),
  };
  for (size_t i = 0; i < sizeof right / sizeof right[0]; ++i) {
    if (!right[i]) return static_cast<int32_t>(i);
  }
  return -1;
}

uint16_t crc_of(const uint8_t* bytes) { return protocol::crc16(bytes, LoggerSettings::kSize); }

}  // namespace

LoggerSettings factory_settings() {
  LoggerSettings settings;
  settings.rate_hz = protocol::kSampleRateHz;
  settings.gyro_range_deg_s = protocol::kGyroRangeFactoryDegS;
  settings.accel_range_g = protocol::kAccelRangeFactoryG;
  settings.dlpf_cfg = protocol::kDlpfFactory;
  settings.bus_khz = protocol::kBusFactoryKhz;
  settings.after_landing_s = protocol::kAfterLandingFactoryS;
  settings.file_mib = protocol::kFileFactoryMib;
  return settings;
}

ErrorCode check(const LoggerSettings& settings, int32_t& detail) {
  detail = first_wrong(settings);
  if (detail >= 0) return ErrorCode::kLoggerSettingOutOfRange;
  const uint16_t most_hz = max_rate_hz(settings.bus_khz);
  if (settings.rate_hz <= most_hz) return ErrorCode::kNone;
  detail = most_hz;
  return ErrorCode::kRateTooHigh;
}

uint8_t gyro_fs_sel(uint16_t range_deg_s) {
  uint8_t sel = 0;
  while (sel < kNoRange && kGyroRangesDegS[sel] != range_deg_s) ++sel;
  return sel;
}

uint8_t accel_afs_sel(uint8_t range_g) {
  uint8_t sel = 0;
  while (sel < kNoRange && kAccelRangesG[sel] != range_g) ++sel;
  return sel;
}

float gyro_lsb_per_deg_s(const LoggerSettings& settings) {
  return kGyroLsbPerDegS[gyro_fs_sel(settings.gyro_range_deg_s)];
}

float accel_lsb_per_g(const LoggerSettings& settings) {
  return kAccelLsbPerG[accel_afs_sel(settings.accel_range_g)];
}

void SettingsStore::load() {
  LoggerSettings stored;
  int32_t detail;
  ErrorCode wrong = read(stored) ? check(stored, detail) : ErrorCode::kLoggerSettingOutOfRange;
  if (wrong == ErrorCode::kRateTooHigh) {
    stored.rate_hz = static_cast<uint16_t>(detail);
    wrong = check(stored, detail);
  }
  const bool usable = wrong == ErrorCode::kNone;
  settings_ = usable ? stored : factory_settings();
  origin_ = usable ? protocol::Origin::kUploaded : protocol::Origin::kFactory;
}

bool SettingsStore::store(const LoggerSettings& settings) {
  uint8_t bytes[kStoredBytes];
  uint8_t present[kStoredBytes];
  settings.encode(bytes);
  protocol::Writer crc(bytes + LoggerSettings::kSize);
  crc.u16(crc_of(bytes));
  memory_.load(present, kStoredBytes);
  if (memcmp(bytes, present, kStoredBytes) != 0) {
    memory_.save(bytes, kStoredBytes);
    memory_.load(present, kStoredBytes);
  }
  if (memcmp(bytes, present, kStoredBytes) != 0) return false;
  settings_ = settings;
  origin_ = protocol::Origin::kUploaded;
  return true;
}

// False when what is there was never written, or is damaged.
bool SettingsStore::read(LoggerSettings& settings) {
  uint8_t bytes[kStoredBytes];
  memory_.load(bytes, kStoredBytes);
  protocol::Reader crc(bytes + LoggerSettings::kSize);
  return crc.u16() == crc_of(bytes) && settings.decode(bytes, LoggerSettings::kSize);
}

}  // namespace logger
}  // namespace tfsat
