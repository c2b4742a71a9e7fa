#include "settings.h"

namespace tfsat {
namespace sequencer {

using namespace protocol;

namespace {

// Pulse width in nanoseconds, before any limit. 30 us/deg over 327 deg fits 32 bits.
int32_t pulse_ns(const ServoSetting& servo, int16_t angle_cdeg) {
  const int32_t change =
      static_cast<int32_t>(angle_cdeg) * static_cast<int32_t>(servo.ns_per_deg) / 100;
  return static_cast<int32_t>(servo.zero_us) * 1000 + (servo.reversed != 0 ? -change : change);
}

bool within_servo(int32_t ns) {
  return ns >= static_cast<int32_t>(kServoPulseMinUs) * 1000 &&
         ns <= static_cast<int32_t>(kServoPulseMaxUs) * 1000;
}

bool makes_sense(const ServoSetting& servo) {
  return servo.reversed <= 1 && servo.ns_per_deg >= kServoNsPerDegMin &&
         servo.ns_per_deg <= kServoNsPerDegMax &&
         servo.min_cdeg >= static_cast<int32_t>(kJointAngleMinCdeg) && servo.min_cdeg <= 0 &&
         servo.max_cdeg <= static_cast<int32_t>(kJointAngleMaxCdeg) &&
         servo.max_cdeg > servo.min_cdeg && within_servo(pulse_ns(servo, servo.min_cdeg)) &&
         within_servo(pulse_ns(servo, servo.max_cdeg));
}

}  // namespace

Settings Settings::factory() {
  Settings settings;
  settings.frame_us = kServoFrameUs;
  for (ServoSetting& servo : settings.servo) {
    servo.zero_us = kServoFactoryZeroUs;
    servo.ns_per_deg = kServoFactoryNsPerDeg;
    servo.reversed = 0;
    servo.min_cdeg = kJointAngleMinCdeg;
    servo.max_cdeg = kJointAngleMaxCdeg;
  }
  settings.moving_at_once = kMovingAtOnce;
  return settings;
}

int8_t Settings::find_defect() const {
  for (uint8_t i = 0; i < kJointCount; ++i) {
    if (!makes_sense(servo[i])) return static_cast<int8_t>(i);
  }
  if (frame_us < kServoFrameMinUs || frame_us > kServoFrameMaxUs) {
    return static_cast<int8_t>(kJointCount);
  }
  return moving_at_once <= kJointCount ? -1 : static_cast<int8_t>(kJointCount + 1);
}

bool Settings::allows(uint8_t joint, int16_t angle_cdeg) const {
  const ServoSetting& setting = servo[joint - 1];
  return angle_cdeg >= setting.min_cdeg && angle_cdeg <= setting.max_cdeg;
}

uint16_t Settings::pulse_ticks(uint8_t joint, int16_t angle_cdeg) const {
  constexpr int32_t ns_per_tick = 1000 / static_cast<int32_t>(kTicksPerUs);
  constexpr int32_t least = static_cast<int32_t>(kServoPulseMinUs * kTicksPerUs);
  constexpr int32_t most = static_cast<int32_t>(kServoPulseMaxUs * kTicksPerUs);
  const int32_t ticks = (pulse_ns(servo[joint - 1], angle_cdeg) + ns_per_tick / 2) / ns_per_tick;
  return static_cast<uint16_t>(ticks < least ? least : ticks > most ? most : ticks);
}

}  // namespace sequencer
}  // namespace tfsat
