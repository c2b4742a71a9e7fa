// The watchdog: the board restarts when the main loop has not come round for a second. Start-up code
// turns it on (reset_cause.cpp).
//
// The Arduino core also uses it: an upload begins with the port being closed at 1200 baud, on which
// the core sets a 120 ms timeout and leaves a key in RAM for the bootloader. feed() lets that
// happen only where an upload may interrupt.
#pragma once

#include <stdint.h>

namespace tfsat {
namespace sequencer {

class Watchdog {
 public:
  // Call at the end of the main loop only.
  static void feed(bool upload_allowed);
};

}  // namespace sequencer
}  // namespace tfsat
