// How the servos turn pulses into angles: from a calibration, kept on the board.
#pragma once

#include "../protocol/messages.h"
#include "ticks.h"

namespace tfsat {
namespace sequencer {

using protocol::ErrorCode;
using protocol::ServoSetting;

// Kept as the message that brings them: its payload is their canonical form.
struct Settings : protocol::SettingsWriteRequest {
  // 0 deg at 1000 us, 90 deg at 2000 us, 20 ms frames.
  static Settings factory();

  // Index of the first joint whose setting makes no sense, kJointCount for the frame, one more for
  // moving_at_once, or -1.
  int8_t find_defect() const;
  bool valid() const { return find_defect() < 0; }

  uint32_t frame_ticks() const { return ticks_from_us(frame_us); }
  bool allows(uint8_t joint, int16_t angle_cdeg) const;  // joint 1 to 3
  // Pulse that holds `joint` (1 to 3) at the angle; never outside what a servo takes.
  uint16_t pulse_ticks(uint8_t joint, int16_t angle_cdeg) const;
};

}  // namespace sequencer
}  // namespace tfsat
