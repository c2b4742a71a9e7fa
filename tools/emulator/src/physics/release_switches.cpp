#include "release_switches.h"

#include <algorithm>

namespace tfsat {
namespace emulator {

namespace {

// The switches do not open at the same instant, and their contacts chatter (OMRON SS-5GL data sheet:
// a few milliseconds).
constexpr double kSpreadUs = 600.0;
constexpr double kChatterUs = 1500.0;
constexpr int kMaxChatter = 3;
// Worn contacts, or an actuator that swings: closed and open again for up to so long each.
constexpr double kWornUs = 1500.0;

}  // namespace

void ReleaseSwitches::set(int index, bool closed) {
  closed_[static_cast<size_t>(index)] = closed;
  show(index);
}

void ReleaseSwitches::set_fault(int index, SwitchFault fault) {
  fault_[static_cast<size_t>(index)] = fault;
  show(index);
}

void ReleaseSwitches::show(int index) {
  const size_t at = static_cast<size_t>(index);
  const bool stuck = fault_[at] != SwitchFault::kNone;
  wire_(index, stuck ? fault_[at] == SwitchFault::kStuckClosed : closed_[at]);
}

void ReleaseSwitches::knock(int index, uint64_t now_us, uint64_t open_us) {
  set(index, false);
  const Change close{now_us + open_us, index, true};
  const auto later = std::find_if(changes_.begin(), changes_.end(),
                                  [&](const Change& change) { return change.t_us > close.t_us; });
  changes_.insert(later, close);
}

uint64_t ReleaseSwitches::release(uint64_t now_us) {
  changes_.clear();
  const int first = bounce_.uniform() < 0.5 ? 0 : 1;
  open_with_bounce(first, now_us);
  const uint64_t released_us = now_us + static_cast<uint64_t>(bounce_.uniform() * kSpreadUs);
  open_with_bounce(1 - first, released_us);
  std::stable_sort(changes_.begin(), changes_.end(),
                   [](const Change& a, const Change& b) { return a.t_us < b.t_us; });
  return released_us;
}

void ReleaseSwitches::open_with_bounce(int index, uint64_t open_at_us) {
  changes_.push_back({open_at_us, index, false});
  if (bounce_us_ == 0) {
    chatter_as_new(index, open_at_us);
  } else {
    chatter_as_worn(index, open_at_us);
  }
}

void ReleaseSwitches::chatter_as_new(int index, uint64_t t_us) {
  const int chatter = static_cast<int>(bounce_.uniform() * (kMaxChatter + 1));
  for (int i = 0; i < chatter; ++i) {
    t_us += 30 + static_cast<uint64_t>(bounce_.uniform() * kChatterUs / kMaxChatter);
    changes_.push_back({t_us, index, true});
    t_us += 20 + static_cast<uint64_t>(bounce_.uniform() * 200.0);
    changes_.push_back({t_us, index, false});
  }
}

// The last bounce ends with the duration, to the microsecond.
void ReleaseSwitches::chatter_as_worn(int index, uint64_t t_us) {
  const uint64_t end_us = t_us + bounce_us_;
  while (true) {
    const uint64_t closes_us = t_us + 50 + static_cast<uint64_t>(bounce_.uniform() * kWornUs);
    const uint64_t opens_us = closes_us + 50 + static_cast<uint64_t>(bounce_.uniform() * kWornUs);
    if (closes_us >= end_us) break;
    changes_.push_back({closes_us, index, true});
    t_us = std::min(opens_us, end_us);
    changes_.push_back({t_us, index, false});
  }
  changes_.push_back({t_us, index, true});
  changes_.push_back({end_us, index, false});
}

void ReleaseSwitches::apply_due(uint64_t now_us) {
  while (!changes_.empty() && changes_.front().t_us <= now_us) {
    const Change change = changes_.front();
    changes_.pop_front();
    set(change.index, change.closed);
  }
}

}  // namespace emulator
}  // namespace tfsat
