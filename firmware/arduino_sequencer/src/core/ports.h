// What the core asks of the hardware. The AVR drivers and the emulator each implement these.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "switch_edge.h"

namespace tfsat {
namespace sequencer {

class ReleaseSwitches {
 public:
  // The oldest edge not yet taken; false when there is none. Where edges came too fast to be taken, the
  // next one says so.
  virtual bool take_edge(SwitchEdge& edge) = 0;
  // Bit 0, 1: switch 1, 2 is open now. From here on edges are taken again.
  virtual uint8_t levels() = 0;

 protected:
  ~ReleaseSwitches() = default;
};

// Three servo signals. Between calls the hardware keeps the pulse trains going by itself.
class ServoOutput {
 public:
  // Starts pulses of this width (ticks) on a joint (0 to 2), or changes the width from the next
  // pulse on, with this frame, and forgets what was scheduled and what had begun.
  virtual void hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) = 0;
  // The first pulse of this width begins exactly at `at`. Changes are numbered from 0 in the order
  // of these calls; those of one joint come in order of time.
  virtual void schedule(uint8_t joint, tick_t at, uint16_t width_ticks) = 0;
  // Forgets the scheduled changes that have not begun; the trains go on with the widths they have.
  // True: a pulse of a new width is on its pin right now, and begins its change once it is whole.
  virtual bool cancel() = 0;
  // Ends all pulses (a pulse that has begun is completed).
  virtual void stop() = 0;
  // Bit i: change i has begun since the last hold() or stop(), that is a whole pulse of its width
  // was on the pin.
  virtual uint16_t changes_begun() = 0;
  // When that pulse rose.
  virtual tick_t change_began_at(uint8_t index) = 0;

 protected:
  ~ServoOutput() = default;
};

// What only the hardware knows of itself while it runs.
class Health {
 public:
  // Low-water mark of free RAM since the board started.
  virtual uint16_t ram_never_used_bytes() = 0;

 protected:
  ~Health() = default;
};

// Bytes that survive power-off.
class NonVolatile {
 public:
  virtual uint8_t read(uint16_t address) = 0;
  // A write is under way; until it ends, neither read nor write may be called.
  virtual bool busy() = 0;
  virtual void write(uint16_t address, uint8_t value) = 0;

 protected:
  ~NonVolatile() = default;
};

}  // namespace sequencer
}  // namespace tfsat
