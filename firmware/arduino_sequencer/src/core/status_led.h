// What a person sees on the board without a cable.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

// SAFE: a short blink each two seconds. ARMED: on. RUNNING: off. DONE: slow, even blinking.
// FAULT: fast blinking.
inline bool led_on(protocol::SequencerState state, uint32_t uptime_ms) {
  switch (state) {
    case protocol::SequencerState::kSafe:
      return uptime_ms % 2000 < 50;
    case protocol::SequencerState::kArmed:
      return true;
    case protocol::SequencerState::kRunning:
      return false;
    case protocol::SequencerState::kDone:
      return uptime_ms % 2000 < 1000;
    case protocol::SequencerState::kFault:
      return uptime_ms % 200 < 100;
  }
  return false;
}

}  // namespace sequencer
}  // namespace tfsat
