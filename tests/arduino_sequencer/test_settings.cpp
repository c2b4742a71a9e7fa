// Servo settings: angle to pulse against exact arithmetic, what makes sense, what servos get.
#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Bench;

namespace {

ServoSetting servo(uint16_t zero_us, uint16_t ns_per_deg, uint8_t reversed,
                   int16_t max_cdeg = 9000) {
  ServoSetting setting;
  setting.zero_us = zero_us;
  setting.ns_per_deg = ns_per_deg;
  setting.reversed = reversed;
  setting.min_cdeg = 0;
  setting.max_cdeg = max_cdeg;
  return setting;
}

Settings with(uint8_t joint, const ServoSetting& setting) {
  Settings settings = Settings::factory();
  settings.servo[joint - 1] = setting;
  return settings;
}

// The width in hundredths of a nanosecond, which are whole.
int64_t exact(const ServoSetting& setting, int32_t angle_cdeg) {
  const int64_t change = int64_t{angle_cdeg} * setting.ns_per_deg;
  return int64_t{setting.zero_us} * 100000 + (setting.reversed != 0 ? -change : change);
}

std::vector<uint8_t> payload(const Settings& settings) {
  std::vector<uint8_t> bytes(Settings::kSize);
  settings.encode(bytes.data());
  return bytes;
}

void store(Bench& bench, const Settings& settings) {
  bench.send(SettingsWriteRequest::kType, payload(settings));
  bench.finish_storing();
  CHECK(bench.core.settings().origin() == Origin::kUploaded && !bench.core.storing());
  CHECK(payload(bench.core.settings().current()) == payload(settings));
}

}  // namespace

// Half a tick, and the nanosecond that whole-number arithmetic may lose.
TEST_CASE(every_angle_is_the_nearest_tick_for_any_servo) {
  const int64_t tick = 50000;
  const int64_t tolerance = tick / 2 + 100;
  const ServoSetting servos[] = {
      servo(1000, 11111, 0), servo(500, 2000, 0), servo(500, 22222, 0), servo(500, 30000, 0, 6666),
      servo(2000, 11111, 1), servo(2500, 2000, 1), servo(2500, 22222, 1),
      servo(999, 12345, 0), servo(1501, 9999, 1), servo(2500, 30000, 1, 6666)};
  for (const ServoSetting& setting : servos) {
    for (uint8_t joint = 1; joint <= kJointCount; ++joint) {
      const Settings settings = with(joint, setting);
      CHECK(settings.valid());
      for (int16_t angle = 0; angle <= setting.max_cdeg; ++angle) {
        const int64_t error = settings.pulse_ticks(joint, angle) * tick - exact(setting, angle);
        CHECK(error <= tolerance && error >= -tolerance);
        CHECK(settings.allows(joint, angle));
      }
      CHECK(!settings.allows(joint, -1));
      CHECK(!settings.allows(joint, static_cast<int16_t>(setting.max_cdeg + 1)));
    }
  }
}

TEST_CASE(no_angle_of_the_wire_is_a_pulse_that_hurts_a_servo) {
  const ServoSetting servos[] = {servo(65535, 65535, 0), servo(0, 65535, 1), servo(2500, 30000, 1)};
  for (const ServoSetting& setting : servos) {
    const Settings settings = with(2, setting);
    for (int32_t angle = -32768; angle <= 32767; ++angle) {
      const uint16_t width = settings.pulse_ticks(2, static_cast<int16_t>(angle));
      CHECK(width >= ticks_from_us(kServoPulseMinUs) && width <= ticks_from_us(kServoPulseMaxUs));
    }
  }
}

TEST_CASE(settings_are_valid_up_to_their_limits_and_no_further) {
  struct {
    ServoSetting setting;
    bool valid;
  } const cases[] = {
      {servo(500, 2000, 0), true},          {servo(499, 2000, 0), false},
      {servo(2500, 2000, 1), true},         {servo(2501, 2000, 1), false},
      {servo(1000, 1999, 0), false},        {servo(500, 30000, 0, 6666), true},
      {servo(500, 30001, 0, 6666), false},  {servo(500, 30000, 0, 6667), false},
      {servo(2500, 30000, 1, 6666), true},  {servo(2500, 30000, 1, 6667), false},
      {servo(500, 22222, 0), true},         {servo(500, 22223, 0), false},
      {servo(1600, 10000, 0), true},        {servo(1601, 10000, 0), false},
      {servo(1400, 10000, 1), true},        {servo(1399, 10000, 1), false},
      {servo(1000, 11111, 2), false},       {servo(1000, 11111, 255), false},
      {servo(1000, 11111, 0, 1), true},     {servo(1000, 11111, 0, 0), false},
      {servo(1000, 11111, 0, 9001), false}, {servo(1000, 11111, 0, -1), false},
  };
  for (const auto& one : cases) {
    for (uint8_t joint = 1; joint <= kJointCount; ++joint) {
      CHECK(with(joint, one.setting).find_defect() == (one.valid ? -1 : joint - 1));
    }
  }
  Settings settings = Settings::factory();
  CHECK(settings.valid());
  for (const int16_t min_cdeg : {-1, 1, -32768}) {
    settings.servo[1].min_cdeg = min_cdeg;
    CHECK(settings.find_defect() == 1);
  }
}

TEST_CASE(the_first_defect_is_named) {
  Settings settings = Settings::factory();
  settings.frame_us = 4999;
  CHECK(settings.find_defect() == kJointCount);
  settings.servo[2].ns_per_deg = 0;
  CHECK(settings.find_defect() == 2);
  settings.servo[0].reversed = 2;
  CHECK(settings.find_defect() == 0);
  for (const uint16_t frame_us : {5000, 20000}) {
    settings = Settings::factory();
    settings.frame_us = frame_us;
    CHECK(settings.valid());
  }
  for (const uint16_t frame_us : {0, 4999, 20001, 65535}) {
    settings.frame_us = frame_us;
    CHECK(settings.find_defect() == kJointCount);
  }
  settings = Settings::factory();
  settings.moving_at_once = kJointCount;
  CHECK(settings.valid());
  settings.moving_at_once = kJointCount + 1;
  CHECK(settings.find_defect() == kJointCount + 1);
}

TEST_CASE(servos_get_the_frame_and_widths_of_the_settings_before_and_after_a_reset) {
  Settings settings = with(1, servo(2100, 11000, 1));
  settings.frame_us = 7003;
  Bench bench;
  store(bench, settings);
  bench.wait_armed();
  Bench after(bench, ResetCause::kWatchdog);
  for (Bench* board : {&bench, &after}) {
    for (const uint32_t frame : board->servos.frames) CHECK(frame == ticks_from_us(7003));
    CHECK(board->servos.widths[0] == 4200);
    CHECK(board->servos.widths[1] == 2000 && board->servos.widths[2] == 2000);
  }
  after.run_ms(20);
  after.open_both();
  after.run_ms(20);
  if (CHECK(after.servos.changes.size() == 4)) {
    CHECK(after.servos.changes[0].width_ticks == 4200 - 1298);  // 59 deg at 11 us/deg, shorter
    CHECK(after.servos.changes[1].width_ticks == 3556);
    CHECK(after.servos.changes[2].width_ticks == 4200);
  }
}
