// What survives a reset that is no loss of power: RAM that start-up code leaves alone.
#pragma once

#include <string.h>

#include "../protocol/crc16.h"
#include "../protocol/messages.h"
#include "change_table.h"

namespace tfsat {
namespace sequencer {

// The last run's report: a blow at the landing may reset the board. Under a checksum of its own,
// because it changes while the board runs.
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
  uint16_t checksum() const {
    const uint8_t* bytes = reinterpret_cast<const uint8_t*>(&report);
    uint16_t sum = 0x5EA1;
    for (size_t i = 0; i < sizeof report; ++i) sum = protocol::crc16_update(sum, bytes[i]);
    return sum;
  }
};

// Lies in uninitialised memory: no constructor may touch it. After power-on it holds anything, and
// intact() says no.
struct RetainedState {
  protocol::SequencerState state;
  protocol::ErrorCode fault;
  uint8_t resets;    // while armed
  uint8_t driven;    // bit i: servo i gets pulses
  uint16_t knocks;   // since arming
  uint16_t false_releases;  // likewise
  uint16_t records;  // which maneuver and settings were in force at the arming
  uint16_t token;
  int16_t held_cdeg[protocol::kJointCount];  // what each servo is told
  BegunChanges begun;                        // marked by interrupts: not under the checksum
  RetainedRun run;                           // likewise
  uint16_t crc;

  bool intact() const { return crc == checksum(); }
  void seal() { crc = checksum(); }
  void clear() {
    state = protocol::SequencerState::kSafe;
    fault = protocol::ErrorCode::kNone;
    resets = 0;
    driven = 0;
    knocks = 0;
    records = 0;
    for (int16_t& angle : held_cdeg) angle = 0;
    seal();
  }

 private:
  // Of an own initial value, so that RAM full of zeros is not intact.
  uint16_t checksum() const {
    uint16_t sum = 0x5EA1;
    sum = protocol::crc16_update(sum, static_cast<uint8_t>(state));
    sum = protocol::crc16_update(sum, static_cast<uint8_t>(fault));
    sum = protocol::crc16_update(sum, resets);
    sum = protocol::crc16_update(sum, driven);
    sum = add(sum, knocks);
    sum = add(sum, false_releases);
    sum = add(sum, records);
    sum = add(sum, token);
    for (int16_t angle : held_cdeg) sum = add(sum, static_cast<uint16_t>(angle));
    return sum;
  }

  static uint16_t add(uint16_t sum, uint16_t value) {
    sum = protocol::crc16_update(sum, static_cast<uint8_t>(value));
    return protocol::crc16_update(sum, static_cast<uint8_t>(value >> 8));
  }
};

}  // namespace sequencer
}  // namespace tfsat
