// The pulse widths that a run will bring, for all joints, and when each began.
//
// One table for all three pulse trains: RAM is scarcer than time on the ATmega32U4. The main loop
// fills it while interrupts are held off; the interrupts plan the pulses and note when they rose.
#pragma once

#include "../protocol/messages.h"
#include "ticks.h"

namespace tfsat {
namespace sequencer {

// How many changes have begun. Lies where a reset does not reach, so that the servos can be held
// where they are even if the main loop hung while strokes went on; two copies tell whether RAM has
// survived.
struct BegunCount {
  uint8_t count;
  uint8_t complement;

  void set(uint8_t begun) {
    count = begun;
    complement = static_cast<uint8_t>(~begun);
  }
  bool intact() const { return (count ^ complement) == 0xFF; }
};

class ChangeTable {
 public:
  struct Change {
    tick_t at;  // scheduled; once begun, when the pulse rose
    uint16_t width_ticks;
    uint8_t joint;
    bool planned;  // its first pulse is the train's next
  };

  explicit ChangeTable(BegunCount& begun) : begun_(begun) {}

  void clear() {
    count_ = 0;
    begun_.set(0);
  }

  // Changes of one joint come in order of time. False when the table is full.
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

  // The next change's pulse rose. Strokes of a maneuver never overlap, so changes begin in order.
  void began(tick_t rise) {
    changes_[begun_.count].at = rise;
    begun_.set(static_cast<uint8_t>(begun_.count + 1));
  }

  uint8_t begun() const { return begun_.count; }
  tick_t began_at(uint8_t index) const { return changes_[index].at; }

 private:
  BegunCount& begun_;
  Change changes_[protocol::kMaxStrokes];
  uint8_t count_ = 0;
};

}  // namespace sequencer
}  // namespace tfsat
