// Copied from firmware/arduino_sequencer/src/core/switch_edge.h by tools/generate_protocol.py.
// A change of a release switch.
#ifndef TFSAT_RELEASE_SWITCH_EDGE_H
#define TFSAT_RELEASE_SWITCH_EDGE_H

#include "ticks.h"

namespace tfsat {
namespace sequencer {

struct SwitchEdge {
  tick_t at;      // stamped by hardware
  uint8_t index;  // 0 or 1
  bool open;
  bool lost;  // edges since the one before may be missing; this one may be no change
};

}  // namespace sequencer
}  // namespace tfsat

#endif
