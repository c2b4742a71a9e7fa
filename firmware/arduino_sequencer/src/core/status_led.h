// What a person sees on the board without a cable.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

// SAFE: a short blink each two seconds. ARMED: on. RUNNING: off. DONE: slow, even blinking.
// FAULT: fast blinking. JOGGING: twice a second. Periods are powers of two: no division on the AVR.
inline bool led_on(protocol::SequencerState state, uint32_t uptime_ms) {
  const uint16_t phase_ms = static_cast<uint16_t>(uptime_ms) & 2047;
  switch (state) {
    case protocol::SequencerState::kSafe:
      return phase_ms < 50;
    case protocol::SequencerState::kArmed:
      return true;
    case protocol::SequencerState::kRunning:
      return false;
    case protocol::SequencerState::kDone:
      return phase_ms < 1024;
    case protocol::SequencerState::kFault:
      return (phase_ms & 255) < 128;
    case protocol::SequencerState::kJogging:
      return (phase_ms & 511) < 256;
  }
  return false;
}

}  // namespace sequencer
}  // namespace tfsat
