// What survives a reset that is no loss of power: RAM that start-up code leaves alone.
#pragma once

#include <stddef.h>
#include <string.h>

#include "../protocol/crc16.h"
#include "../protocol/messages.h"
#include "change_table.h"

namespace tfsat {
namespace sequencer {

// Of an own initial value, so that RAM full of zeros is not intact.
uint16_t retained_checksum(const void* data, size_t size, uint16_t sum = 0x5EA1);

// The last run's report: a blow at the landing may reset the board. Under a checksum of its own, so
// that what damages the state leaves the run alone.
struct RetainedRun {
  protocol::RunReportReply report;
  uint16_t crc;

  bool intact() const { return crc == checksum(); }
  void seal() { crc = checksum(); }
  void clear() {
    report = protocol::RunReportReply{};
    memset(report.start_us, 0xFF, sizeof report.start_us);
    seal();
  }

 private:
  uint16_t checksum() const { return retained_checksum(&report, sizeof report); }
};

// Lies in uninitialised memory: no constructor may touch it. After power-on it holds anything, and
// intact() says no.
//
// A reset may come between any two bytes that are written. set() says what it is about to write
// before it writes, and recover() ends it: a value is the old one or the new one, its checksum right.
struct RetainedState {
  struct Condition {
    protocol::SequencerState state;
    protocol::ErrorCode fault;
  };
  struct Write {
    volatile uint8_t pending;
    uint8_t at;
    uint8_t size;
    uint8_t value[8];
    uint16_t crc;
  };

  Condition condition;
  uint8_t resets;    // while armed
  uint8_t driven;    // bit i: servo i gets pulses
  uint16_t knocks;   // since arming
  uint16_t false_releases;  // likewise
  uint16_t records;  // which maneuver and settings were in force at the arming
  uint16_t token;
  int16_t held_cdeg[protocol::kJointCount];  // what each servo is told
  uint16_t crc;                              // of all before
  BegunChanges begun;                        // marked by interrupts
  RetainedRun run;
  Write write;

  bool intact() const {
    return crc == retained_checksum(this, offsetof(RetainedState, crc));
  }

  // `target` is of the state or of the run's report, both of which are intact; a longer `value` goes
  // on into what follows it there.
  template <typename Target, typename Value>
  void set(Target& target, const Value& value) {
    static_assert(sizeof value <= sizeof write.value, "fits");
    change(&target, &value, sizeof value);
  }

  // After a reset, before anything is read.
  void recover() {
    if (write.pending == kPending && write.at + write.size <= offsetof(RetainedState, write)) finish();
    write.pending = 0;
  }

  // After power-on.
  void clear() {
    memset(this, 0, offsetof(RetainedState, begun));
    write.pending = 0;
    crc = retained_checksum(this, offsetof(RetainedState, crc));
  }

 private:
  static constexpr uint8_t kPending = 0xB5;

  uint8_t* bytes() { return reinterpret_cast<uint8_t*>(this); }
  bool of_run() const { return write.at >= offsetof(RetainedState, run); }

  void change(const void* target, const void* value, uint8_t size);
  void finish();
};

}  // namespace sequencer
}  // namespace tfsat
