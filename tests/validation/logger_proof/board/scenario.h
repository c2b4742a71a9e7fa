// What happens in one run, from its seed.
#pragma once

#include <stdint.h>

#include "../../../../firmware/teensy_logger/src/core/block_ring.h"

namespace proof {

// Finaliser of MurmurHash3 (A. Appleby, public domain).
inline uint32_t mixed(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x85EBCA6Bu;
  x = (x ^ (x >> 13)) * 0xC2B2AE35u;
  return x ^ (x >> 16);
}

// One of many independent sequences, by index.
inline uint32_t drawn_at(uint32_t seed, uint32_t index, uint32_t channel) {
  return mixed(mixed(seed * 0x9E3779B1u + index) + channel * 0x27D4EB2Fu);
}

// One number after another.
class Draw {
 public:
  Draw(uint32_t seed, uint32_t purpose) : seed_(mixed(seed) ^ purpose * 0x9E3779B1u) {}

  uint32_t next() { return drawn_at(seed_, count_++, 0); }
  // At least `least`, below `end`.
  uint32_t between(uint32_t least, uint32_t end) { return least + next() % (end - least); }
  bool one_in(uint32_t n) { return next() % n == 0; }

 private:
  uint32_t seed_;
  uint32_t count_ = 0;
};

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

inline void draw_fall(Scenario& s, Draw& draw) {
  s.release_us = kStartUs + draw.between(1300000, 2500000);
  s.second_switch_us = draw.between(1, 4000);
  s.landing_us = s.release_us + draw.between(2900000, 3200000);
  s.landing_felt = !draw.one_in(8);
}

inline void draw_card(Scenario& s, Draw& draw) {
  s.cache_blocks = draw.between(1, 65);
  s.fate = Fate::kMixed;
  s.stall_one_in = draw.one_in(2) ? 100 : 0;
  s.waits_inside = draw.one_in(2);
  s.busy_when_gone = draw.one_in(2);
  s.holds_older = draw.one_in(4);
}

// Out of its contacts for at most what the ring holds. A later loss comes after the first is over.
inline void draw_pulls(Scenario& s, Draw& draw) {
  uint64_t from_us = kStartUs + draw.between(200000, 5000000);
  const uint32_t longest_us = s.rate_hz == 1000 ? 3000000 : 5000000;
  for (int i = 0; i < 2; ++i) {
    s.pulled_us[i] = from_us;
    s.back_us[i] = from_us + draw.between(2000, longest_us);
    if (draw.one_in(2)) return;
    from_us = s.back_us[i] + draw.between(1500000, 3000000);
  }
}

inline void draw_faults(Scenario& s, Draw& draw) {
  const uint32_t count = draw.between(1, 4);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t imu = draw.next() % 4;
    s.fault[imu] = static_cast<ImuFault>(draw.between(1, 6));
    s.fault_from_us[imu] = kStartUs + draw.between(100000, 6000000);
    const bool for_good = draw.one_in(3);
    s.fault_to_us[imu] = for_good ? kNever : s.fault_from_us[imu] + draw.between(1000, 2000000);
  }
  if (draw.one_in(2)) s.dead_angle = static_cast<uint8_t>(draw.next() % 6);
  s.fault_from_us[0] = s.fault_from_us[0] != 0 ? s.fault_from_us[0] : kStartUs + 1000000;
}

// A knock, or somebody who lifts the robot out and seats it again.
inline void draw_knock(Scenario& s, Draw& draw) {
  s.knock_us = s.release_us;
  s.knock_ends_us = s.knock_us + draw.between(100000, 4000000);
  const uint64_t later_us = s.knock_ends_us + draw.between(300000, 2000000) - s.release_us;
  s.release_us += later_us;
  s.landing_us += later_us;
}

// For good: before, in or after the fall.
inline void draw_loss(Scenario& s, Draw& draw) {
  const uint64_t from_us[] = {kStartUs + 400000, s.release_us, s.landing_us};
  const uint64_t to_us[] = {s.release_us, s.landing_us, s.landing_us + 4900000};
  const uint32_t when = draw.next() % 3;
  s.pulled_us[0] = from_us[when] + draw.next() % static_cast<uint32_t>(to_us[when] - from_us[when]);
  s.landing_felt = draw.one_in(2);
  s.life_us = 45000000;
}

// The file is changed after 13.4 s at 280 Hz and after 8.1 s at 1 kHz: half of the releases come near
// that.
inline void draw_wait(Scenario& s, Draw& draw) {
  const uint32_t change_us = s.rate_hz == 1000 ? 8000000 : 13300000;
  const uint32_t wait_us = draw.one_in(2) ? draw.between(change_us - 200000, change_us + 400000)
                                          : draw.between(change_us, change_us + 4000000);
  const uint64_t later_us = kStartUs + wait_us - s.release_us;
  s.release_us += later_us;
  s.landing_us += later_us;
  s.life_us = s.landing_us + 15000000;
}

inline void draw_ticks(Scenario& s) {
  Draw draw(s.seed, 8);
  if (draw.one_in(2)) s.jitter_us = draw.between(1, 100);
  if (draw.one_in(3)) s.missed_one_in = 300;
}

// The second copy begins 4 s after the release, or 1 s after the landing, and takes 0.3 s on a
// quick card and 3 s on one that stalls.
inline void draw_cut(Scenario& s, Draw& draw) {
  s.cut_us = kStartUs + draw.between(20000, 11000000);
  if (s.kind == Kind::kSecondCopy) {
    const uint64_t landed_us = s.landing_felt ? s.landing_us : s.release_us + 5000000;
    const uint64_t earliest_us = s.release_us + 4000000;
    const uint64_t begin_us = landed_us + 1000000 > earliest_us ? landed_us + 1000000 : earliest_us;
    s.cut_us = begin_us + draw.between(1000, s.stall_one_in != 0 ? 3000000 : 700000);
  }
  if (s.kind == Kind::kReclosed && draw.one_in(2)) {
    s.cut_us = s.landing_us + kAfterLandingS * 1000000u + draw.between(300000, 2500000);
  }
  if (s.kind == Kind::kNextFile) {
    s.cut_us = draw.one_in(2) ? kNever : s.release_us + draw.next() % 11000000 - 1000000;
  }
  if (s.kind == Kind::kFalseRelease && draw.one_in(2)) s.cut_us = kNever;
  const bool uncut =
      s.kind == Kind::kClose || s.kind == Kind::kSpoiled || s.kind == Kind::kCardLost;
  if (uncut) s.cut_us = kNever;
  if (s.kind == Kind::kClose) s.cut_in_close_us = draw.between(1, 12000);
}

inline Scenario scenario_of(uint32_t seed) {
  Draw draw(seed, 1);
  Scenario s = {};
  s.seed = seed;
  s.kind = static_cast<Kind>(seed % kKinds);
  s.rate_hz = seed / kKinds % 2 == 0 ? 280 : 1000;
  s.file_mib = s.rate_hz == 1000 ? 2 : 1;
  s.ring_blocks = tfsat::logger::kRingBlocks;
  s.pulled_us[0] = s.pulled_us[1] = s.back_us[0] = s.back_us[1] = kNever;
  s.dead_angle = 0xFF;
  s.knock_us = s.knock_ends_us = s.reclosed_us = kNever;
  s.life_us = 20000000;
  s.unix_us = 1790000000000000u;
  draw_ticks(s);
  draw_fall(s, draw);
  draw_card(s, draw);
  switch (s.kind) {
    case Kind::kBetween:
      s.cache_blocks = 0;
      s.fate = Fate::kWhole;
      break;
    case Kind::kTorn:
      s.cache_blocks = 1;
      s.fate = Fate::kTorn;
      break;
    case Kind::kCacheLost:
      s.fate = Fate::kLost;
      break;
    case Kind::kOutOfOrder:
    case Kind::kSecondCopy:
      break;
    case Kind::kStale:
    case Kind::kClose:
      s.holds_older = true;
      break;
    case Kind::kStalls:
      s.stall_one_in = 100;
      break;
    case Kind::kPulled:
      draw_pulls(s, draw);
      break;
    case Kind::kDeadSensors:
      draw_faults(s, draw);
      break;
    case Kind::kSmallRing:
      s.stall_one_in = 50;
      s.ring_blocks = s.rate_hz == 1000 ? draw.between(24, 64) : draw.between(10, 20);
      break;
    case Kind::kSpoiled:
      break;
    case Kind::kFalseRelease:
      draw_knock(s, draw);
      break;
    case Kind::kReclosed:
      s.landing_felt = true;
      s.reclosed_us = s.landing_us + draw.between(50000, 3000000);
      break;
    case Kind::kCardLost:
      draw_loss(s, draw);
      break;
    case Kind::kNextFile:
      draw_wait(s, draw);
      break;
  }
  draw_cut(s, draw);
  return s;
}

// An earlier recording that leaves its blocks in the same file.
inline Scenario older_of(const Scenario& scenario) {
  Draw draw(scenario.seed, 2);
  Scenario s = scenario;
  s.seed = mixed(scenario.seed) | 1;
  s.cache_blocks = 0;
  s.fate = Fate::kWhole;
  s.stall_one_in = 0;
  s.holds_older = false;
  s.ring_blocks = tfsat::logger::kRingBlocks;
  for (ImuFault& fault : s.fault) fault = ImuFault::kNone;
  s.pulled_us[0] = s.pulled_us[1] = kNever;
  s.rate_hz = 1000;
  s.file_mib = 2;
  s.unix_us -= 86400000000u;
  s.cut_us = kStartUs + draw.between(50000, 9000000);
  s.cut_in_close_us = 0;
  return s;
}

}  // namespace proof
