#include "scenario.h"

#include "../../../firmware/teensy_logger/src/core/block_ring.h"
#include "draw.h"

namespace proof {

namespace {

void draw_fall(Scenario& s, Draw& draw) {
  s.release_us = kStartUs + draw.between(1300000, 2500000);
  s.second_switch_us = draw.between(1, 4000);
  s.landing_us = s.release_us + draw.between(2900000, 3200000);
  s.landing_felt = !draw.one_in(8);
}

void draw_card(Scenario& s, Draw& draw) {
  s.cache_blocks = draw.between(1, 65);
  s.fate = Fate::kMixed;
  s.stall_one_in = draw.one_in(2) ? 100 : 0;
  s.waits_inside = draw.one_in(2);
  s.busy_when_gone = draw.one_in(2);
  s.holds_older = draw.one_in(4);
}

// Out of its contacts for at most what the ring holds. A later loss comes after the first is over.
void draw_pulls(Scenario& s, Draw& draw) {
  uint64_t from_us = kStartUs + draw.between(200000, 5000000);
  const uint32_t longest_us = s.rate_hz == 1000 ? 3000000 : 5000000;
  for (int i = 0; i < 2; ++i) {
    s.pulled_us[i] = from_us;
    s.back_us[i] = from_us + draw.between(2000, longest_us);
    if (draw.one_in(2)) return;
    from_us = s.back_us[i] + draw.between(1500000, 3000000);
  }
}

void draw_faults(Scenario& s, Draw& draw) {
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
void draw_knock(Scenario& s, Draw& draw) {
  s.knock_us = s.release_us;
  s.knock_ends_us = s.knock_us + draw.between(100000, 4000000);
  const uint64_t later_us = s.knock_ends_us + draw.between(300000, 2000000) - s.release_us;
  s.release_us += later_us;
  s.landing_us += later_us;
}

// For good: before, in or after the fall.
void draw_loss(Scenario& s, Draw& draw) {
  const uint64_t from_us[] = {kStartUs + 400000, s.release_us, s.landing_us};
  const uint64_t to_us[] = {s.release_us, s.landing_us, s.landing_us + 4900000};
  const uint32_t when = draw.next() % 3;
  s.pulled_us[0] = from_us[when] + draw.next() % static_cast<uint32_t>(to_us[when] - from_us[when]);
  s.landing_felt = draw.one_in(2);
  s.life_us = 45000000;
}

// The file is changed after 13.4 s at 280 Hz and after 8.1 s at 1 kHz: half of the releases come near
// that.
void draw_wait(Scenario& s, Draw& draw) {
  const uint32_t change_us = s.rate_hz == 1000 ? 8000000 : 13300000;
  const uint32_t wait_us = draw.one_in(2) ? draw.between(change_us - 200000, change_us + 400000)
                                          : draw.between(change_us, change_us + 4000000);
  const uint64_t later_us = kStartUs + wait_us - s.release_us;
  s.release_us += later_us;
  s.landing_us += later_us;
  s.life_us = s.landing_us + 15000000;
}

void draw_ticks(Scenario& s) {
  Draw draw(s.seed, 8);
  if (draw.one_in(2)) s.jitter_us = draw.between(1, 100);
  if (draw.one_in(3)) s.missed_one_in = 300;
}

// The second copy begins 4 s after the release, or 1 s after the landing, and takes 0.3 s on a
// quick card and 3 s on one that stalls.
void draw_cut(Scenario& s, Draw& draw) {
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

}  // namespace

Scenario scenario_of(uint32_t seed) {
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

Scenario older_of(const Scenario& scenario) {
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
