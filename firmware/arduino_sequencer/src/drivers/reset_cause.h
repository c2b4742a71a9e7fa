// Why the board last started. Read from MCUSR before anything else runs.
//
// The Arduino bootloader clears MCUSR before it starts the sketch (Caterina.c). Then RAM tells
// power on from the rest: what the last run painted there survives everything but a loss of power.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

// Call once, at start-up.
protocol::ResetCause take_reset_cause();

}  // namespace sequencer
}  // namespace tfsat
