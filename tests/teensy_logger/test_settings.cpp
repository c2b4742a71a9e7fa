// Settings that make no sense, or that the buses cannot carry, are refused; what was stored is
// kept, and what is damaged is not used.
#include "../../firmware/teensy_logger/src/core/settings.h"

#include <cstring>
#include <vector>

#include "../../firmware/teensy_logger/src/core/timing.h"
#include "check.h"
#include "fake_ports.h"

using namespace tfsat;
using namespace tfsat::logger;
using namespace tfsat::protocol;

namespace {

using Memory = tfsat_test::FakeMemory;

bool same(const LoggerSettings& a, const LoggerSettings& b) {
  uint8_t x[LoggerSettings::kSize], y[LoggerSettings::kSize];
  a.encode(x);
  b.encode(y);
  return std::memcmp(x, y, sizeof x) == 0;
}

LoggerSettings fast() {
  LoggerSettings settings = factory_settings();
  settings.rate_hz = 1000;
  settings.after_landing_s = 60;
  settings.file_mib = 40;
  return settings;
}

bool is_factory(const SettingsStore& store) {
  return store.origin() == Origin::kFactory && same(store.settings(), factory_settings());
}

// The outcome of check() and its detail after one change to the factory's settings.
template <typename Change>
std::vector<int32_t> after(Change change) {
  LoggerSettings settings = factory_settings();
  change(settings);
  int32_t detail = 0;
  const ErrorCode error = check(settings, detail);
  return {static_cast<int32_t>(error), error == ErrorCode::kNone ? 0 : detail};
}

std::vector<int32_t> wrong_field(int32_t place) {
  return {static_cast<int32_t>(ErrorCode::kLoggerSettingOutOfRange), place};
}

}  // namespace

TEST_CASE(the_factory_s_settings_are_the_paper_s_and_pass) {
  const LoggerSettings settings = factory_settings();
  CHECK(settings.rate_hz == 280 && settings.gyro_range_deg_s == 500 && settings.bus_khz == 400);
  int32_t detail;
  CHECK(check(settings, detail) == ErrorCode::kNone);
}

// Two bursts of 156 bits, and 200 us: 980 us at 400 kHz, 3,320 us at 100 kHz.
TEST_CASE(the_buses_carry_1000_hz_at_400_khz_and_301_hz_at_100_khz) {
  CHECK(imu_burst_us(400) == 390 && imu_burst_us(100) == 1560);
  CHECK(max_rate_hz(400) == 1000 && max_rate_hz(100) == 283);
  const std::vector<int32_t> fine = {0, 0};
  CHECK(after([](LoggerSettings& s) { s.rate_hz = 1000; }) == fine);
  CHECK(after([](LoggerSettings& s) { s.bus_khz = 100; }) == fine);
  CHECK(after([](LoggerSettings& s) { s.bus_khz = 100, s.rate_hz = 283; }) == fine);
  const std::vector<int32_t> too_high = {static_cast<int32_t>(ErrorCode::kRateTooHigh), 283};
  CHECK(after([](LoggerSettings& s) { s.bus_khz = 100, s.rate_hz = 302; }) == too_high);
  CHECK(after([](LoggerSettings& s) { s.bus_khz = 100, s.rate_hz = 1000; }) == too_high);
}

TEST_CASE(the_first_wrong_field_is_named_by_its_place) {
  CHECK(after([](LoggerSettings& s) { s.rate_hz = 9; }) == wrong_field(0));
  CHECK(after([](LoggerSettings& s) { s.rate_hz = 1001; }) == wrong_field(0));
  CHECK(after([](LoggerSettings& s) { s.gyro_range_deg_s = 501; }) == wrong_field(1));
  CHECK(after([](LoggerSettings& s) { s.accel_range_g = 3; }) == wrong_field(2));
  CHECK(after([](LoggerSettings& s) { s.dlpf_cfg = 7; }) == wrong_field(3));
  CHECK(after([](LoggerSettings& s) { s.bus_khz = 200; }) == wrong_field(4));
  CHECK(after([](LoggerSettings& s) { s.after_landing_s = 1; }) == wrong_field(5));
  CHECK(after([](LoggerSettings& s) { s.after_landing_s = 601; }) == wrong_field(5));
  CHECK(after([](LoggerSettings& s) { s.file_mib = 0; }) == wrong_field(6));
  CHECK(after([](LoggerSettings& s) { s.file_mib = 1025; }) == wrong_field(6));
  CHECK(after([](LoggerSettings& s) { s.dlpf_cfg = 7, s.file_mib = 0; }) == wrong_field(3));
}

TEST_CASE(every_range_of_the_chip_has_its_code_and_scale) {
  const uint16_t gyro[] = {250, 500, 1000, 2000};
  const uint8_t accel[] = {2, 4, 8, 16};
  const double gyro_lsb[] = {131.0, 65.5, 32.8, 16.4};
  for (uint8_t i = 0; i < 4; ++i) {
    LoggerSettings settings = factory_settings();
    settings.gyro_range_deg_s = gyro[i];
    settings.accel_range_g = accel[i];
    CHECK(gyro_fs_sel(gyro[i]) == i && accel_afs_sel(accel[i]) == i);
    CHECK_NEAR(gyro_lsb_per_deg_s(settings), gyro_lsb[i], 1e-5);
    CHECK(accel_lsb_per_g(settings) == 32768.0f / accel[i]);
  }
  CHECK(gyro_fs_sel(0) == 4 && accel_afs_sel(32) == 4);
}

TEST_CASE(memory_that_was_never_written_gives_the_factory_s) {
  for (const int fill : {0xFF, 0x00}) {
    Memory memory;
    std::fill(memory.bytes.begin(), memory.bytes.end(), static_cast<uint8_t>(fill));
    SettingsStore store(memory);
    CHECK(is_factory(store));
    store.load();
    CHECK(is_factory(store) && memory.saves == 0);
  }
}

TEST_CASE(what_is_stored_outlasts_the_power) {
  Memory memory;
  SettingsStore store(memory);
  CHECK(store.store(fast()));
  CHECK(store.origin() == Origin::kUploaded && same(store.settings(), fast()));
  SettingsStore next(memory);
  next.load();
  CHECK(next.origin() == Origin::kUploaded && same(next.settings(), fast()));
}

TEST_CASE(the_same_settings_wear_no_cell) {
  Memory memory;
  SettingsStore store(memory);
  for (int i = 0; i < 3; ++i) CHECK(store.store(fast()));
  CHECK(memory.saves == 1);
}

TEST_CASE(any_damaged_bit_gives_the_factory_s) {
  Memory memory;
  SettingsStore(memory).store(fast());
  for (size_t bit = 0; bit < 8 * (LoggerSettings::kSize + 2); ++bit) {
    Memory damaged = memory;
    damaged.bytes[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    SettingsStore store(damaged);
    store.load();
    CHECK(is_factory(store));
  }
}

// Kept whole, by a firmware that allowed them.
TEST_CASE(settings_out_of_range_are_not_believed) {
  Memory memory;
  LoggerSettings settings = fast();
  settings.rate_hz = static_cast<uint16_t>(kSampleRateMaxHz + 1);
  CHECK(SettingsStore(memory).store(settings));
  SettingsStore store(memory);
  store.load();
  CHECK(is_factory(store));
}

// An earlier firmware allowed up to 301 Hz at 100 kHz.
TEST_CASE(a_rate_that_the_buses_no_longer_carry_is_lowered_and_the_rest_kept) {
  for (const uint16_t rate_hz : {uint16_t{283}, uint16_t{284}, uint16_t{301}, uint16_t{1000}}) {
    Memory memory;
    LoggerSettings settings = fast();
    settings.bus_khz = 100;
    settings.rate_hz = rate_hz;
    settings.gyro_range_deg_s = 1000;
    CHECK(SettingsStore(memory).store(settings));
    SettingsStore store(memory);
    store.load();
    settings.rate_hz = 283;
    CHECK(store.origin() == Origin::kUploaded && same(store.settings(), settings));
    CHECK(memory.saves == 1);
  }
}

TEST_CASE(a_memory_that_does_not_keep_them_changes_nothing) {
  for (int cell = 0; cell < static_cast<int>(LoggerSettings::kSize) + 2; ++cell) {
    Memory memory;
    SettingsStore store(memory);
    LoggerSettings settings = fast();
    memory.worn_cell = cell;
    memory.bytes[static_cast<size_t>(cell)] = 0x55;  // none of the bytes to be stored
    const bool kept = store.store(settings);
    SettingsStore next(memory);
    next.load();
    CHECK(!kept && is_factory(store) && is_factory(next));
  }
}
