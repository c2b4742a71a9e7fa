// What happens in one run, from its seed.
#pragma once

#include <stdint.h>

namespace proof {

// What the run is about; campaign.py has the same list.
enum class Kind : uint8_t {
  kBetween,      // the cut comes between two blocks
  kTorn,         // the block under way is torn
  kCacheLost,    // the card's RAM is lost
  kOutOfOrder,   // of the card's RAM, some blocks were programmed, in any order, one is torn
  kStale,        // likewise, in a file full of an older recording
  kStalls,       // 1 % of the writes stall
  kSecondCopy,   // the cut comes while the fall is written again
  kClose,        // the cut comes while the file is closed, which holds an older recording
  kPulled,       // the card loses its contact, and gets it back
  kDeadSensors,  // IMUs, buses and angle sensors fail
  kSmallRing,    // stalls with a ring that is too small for them
  kSpoiled,      // the blow spoils a twentieth of what was on the card, and the first header
  kFalseRelease, // the switches open and close again before the release
  kReclosed,     // both switches close for good after the landing
  kCardLost,     // the card is gone for good: before, in or after the fall
  kNextFile,     // the file is full before the release
};
constexpr uint32_t kKinds = 16;

// What the card makes of the blocks in its RAM when it loses its supply.
enum class Fate : uint8_t { kWhole, kTorn, kLost, kMixed };

enum class ImuFault : uint8_t { kNone, kNack, kHang, kForeign, kFrozen, kStuckBus };

struct Scenario {
  uint32_t seed;
  Kind kind;
  uint16_t rate_hz;
  uint16_t file_mib;
  uint32_t ring_blocks;

  uint32_t cache_blocks;  // the card's own RAM
  Fate fate;
  uint32_t stall_one_in;  // writes; 0: never
  bool waits_inside;      // the driver waits for a card that stalls, instead of calling it busy
  bool busy_when_gone;    // what a card without contact looks like
  bool holds_older;       // the file was not filled with zeros and holds an older recording

  // In us after power-up; UINT64_MAX: never.
  uint64_t release_us;
  uint64_t second_switch_us;  // after the first
  uint64_t knock_us;          // both open before the release, until knock_ends_us
  uint64_t knock_ends_us;
  uint64_t reclosed_us;  // both close after the landing
  uint64_t landing_us;
  bool landing_felt;
  uint64_t cut_us;
  uint32_t cut_in_close_us;  // or so long after the closing began; 0: not
  uint64_t pulled_us[2];
  uint64_t back_us[2];
  uint64_t life_us;       // the run ends then, if nothing ended it
  uint64_t unix_us;       // what the host says that the time is
  uint32_t jitter_us;     // of the sampling ticks, at most
  uint32_t missed_one_in; // ticks: one to three are missed; 0: none

  ImuFault fault[4];
  uint64_t fault_from_us[4];
  uint64_t fault_to_us[4];
  uint8_t dead_angle;  // from fault_from_us[0] on; 0xFF: none
};

constexpr uint64_t kNever = UINT64_MAX;
constexpr uint64_t kSettingsUs = 150000;
constexpr uint64_t kStartUs = 300000;
constexpr uint16_t kAfterLandingS = 5;

Scenario scenario_of(uint32_t seed);
// An earlier recording that leaves its blocks in the same file.
Scenario older_of(const Scenario& scenario);

}  // namespace proof
