// The two release switches: what the releaser does to them, how their contacts bounce, and what their wires show.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>

#include "../sensors/noise.h"

namespace tfsat {
namespace emulator {

enum class SwitchFault : uint8_t {
  kNone,
  kStuckClosed,  // welded contacts, or a short in the cable
  kStuckOpen,    // a broken wire
};

class ReleaseSwitches {
 public:
  static constexpr int kCount = 2;
  // What both boards see of a switch from now on.
  using Wire = std::function<void(int index, bool closed)>;

  ReleaseSwitches(uint64_t seed, Wire wire) : bounce_(seed), wire_(std::move(wire)) {}

  void set(int index, bool closed);
  // A knock: opens for `open_us`, then closes.
  void knock(int index, uint64_t now_us, uint64_t open_us);
  // Both open, one after the other, and bounce. Returns when both have been open for the first time.
  uint64_t release(uint64_t now_us);
  // What still lies ahead does not happen.
  void clear() { changes_.clear(); }

  // Wires keep showing what the fault makes of it, whatever the mechanics do.
  void set_fault(int index, SwitchFault fault);
  // Shows the wire's present level once more.
  void show(int index);
  // How long the contacts chatter at the next release; 0: as the data sheet has it.
  void set_bounce(uint64_t bounce_us) { bounce_us_ = bounce_us; }

  // UINT64_MAX: nothing lies ahead.
  uint64_t next_us() const { return changes_.empty() ? UINT64_MAX : changes_.front().t_us; }
  void apply_due(uint64_t now_us);

 private:
  struct Change {
    uint64_t t_us;
    int index;
    bool closed;
  };

  void open_with_bounce(int index, uint64_t open_at_us);
  void chatter_as_new(int index, uint64_t t_us);
  void chatter_as_worn(int index, uint64_t t_us);

  Noise bounce_;
  Wire wire_;
  uint64_t bounce_us_ = 0;
  std::deque<Change> changes_;  // in order of time
  std::array<bool, kCount> closed_{{true, true}};
  std::array<SwitchFault, kCount> fault_{{SwitchFault::kNone, SwitchFault::kNone}};
};

}  // namespace emulator
}  // namespace tfsat
