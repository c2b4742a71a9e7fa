// The status LED on D6 (PD7), lit when high.
#pragma once

#include <avr/io.h>

namespace tfsat {
namespace sequencer {

class StatusPin {
 public:
  void begin() { DDRD |= _BV(PD7); }
  void set(bool on) {
    if (on) {
      PORTD |= _BV(PD7);
    } else {
      PORTD &= static_cast<uint8_t>(~_BV(PD7));
    }
  }
};

}  // namespace sequencer
}  // namespace tfsat
