// The pulse widths that a run will bring, for all joints, and which of them have begun, and when.
//
// One table for all three pulse trains: RAM is scarcer than time on the ATmega32U4. The main loop
// fills it while interrupts are held off; the interrupts plan the pulses and note when they rose.
#pragma once

#include "../protocol/messages.h"
#include "ticks.h"

namespace tfsat {
namespace sequencer {

// Which changes have begun: bit i is change i. Lies where a reset does not reach, so that the servos
// can be held where they are even if the main loop hung while strokes went on; two copies tell
// whether RAM has survived.
struct BegunChanges {
  uint16_t bits;
  uint16_t complement;

  void set(uint16_t begun) {
    bits = begun;
    complement = static_cast<uint16_t>(~begun);
  }
  bool intact() const { return (bits ^ complement) == 0xFFFF; }
};
static_assert(protocol::kMaxStrokes <= 16, "a bit for each stroke");

class ChangeTable {
 public:
  struct Change {
    tick_t at;  // scheduled; once begun, when the pulse rose
    uint16_t width_ticks;
    uint8_t joint;
    bool planned;  // the train has taken it up, or it was cancelled
  };

  explicit ChangeTable(BegunChanges& begun) : begun_(begun) {}

  void clear() {
    count_ = 0;
    begun_.set(0);
  }

  // Changes are numbered in the order of these calls. Those of one joint come in order of time.
  // False when the table is full.
  bool add(uint8_t joint, tick_t at, uint16_t width_ticks) {
    if (count_ == protocol::kMaxStrokes) return false;
    changes_[count_].at = at;
    changes_[count_].width_ticks = width_ticks;
    changes_[count_].joint = joint;
    changes_[count_].planned = false;
    ++count_;
    return true;
  }

  // Nothing more is planned; what has begun stays on record.
  void cancel() {
    for (uint8_t i = 0; i < count_; ++i) changes_[i].planned = true;
  }

  // The joint's next change that is not planned, or null.
  Change* next(uint8_t joint) {
    for (uint8_t i = 0; i < count_; ++i) {
      if (changes_[i].joint == joint && !changes_[i].planned) return &changes_[i];
    }
    return nullptr;
  }

  // The first whole pulse of this change rose then.
  void began(Change& change, tick_t rise) {
    change.at = rise;
    begun_.set(static_cast<uint16_t>(begun_.bits | 1u << (&change - changes_)));
  }

  uint16_t begun() const { return begun_.bits; }
  tick_t began_at(uint8_t index) const { return changes_[index].at; }

 private:
  BegunChanges& begun_;
  Change changes_[protocol::kMaxStrokes];
  uint8_t count_ = 0;
};

}  // namespace sequencer
}  // namespace tfsat
