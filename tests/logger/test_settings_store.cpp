// Settings in non-volatile memory: kept, and not believed when they are damaged.
#include <algorithm>
#include <cstring>
#include <vector>

#include "../../firmware/teensy_logger/src/core/settings.h"
#include "check.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;

namespace {

struct Memory final : NonVolatile {
  void load(uint8_t* out, uint8_t size) override { std::copy_n(bytes.begin(), size, out); }
  void save(const uint8_t* in, uint8_t size) override {
    ++saves;
    for (uint8_t i = 0; i < size; ++i) {
      if (i != worn_cell) bytes[i] = in[i];
    }
  }
  std::vector<uint8_t> bytes = std::vector<uint8_t>(64, 0xFF);
  int saves = 0;
  int worn_cell = -1;
};

LoggerSettings fast() {
  LoggerSettings settings = factory_settings();
  settings.rate_hz = 1000;
  settings.after_landing_s = 60;
  settings.file_mib = 40;
  return settings;
}

bool same(const LoggerSettings& a, const LoggerSettings& b) {
  uint8_t left[LoggerSettings::kSize], right[LoggerSettings::kSize];
  a.encode(left);
  b.encode(right);
  return std::memcmp(left, right, sizeof left) == 0;
}

bool is_factory(const SettingsStore& store) {
  return store.origin() == Origin::kFactory && same(store.settings(), factory_settings());
}

}  // namespace

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
