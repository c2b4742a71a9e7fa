#include "physics/release_switches.h"

#include <vector>

#include "check.h"

using namespace tfsat::emulator;

namespace {

struct Edge {
  uint64_t t_us;
  int index;
  bool closed;
};

// Runs the switches in steps of a microsecond up to the next change, and keeps what their wires show.
struct Wires {
  std::vector<Edge> edges;
  uint64_t now_us = 0;
  ReleaseSwitches switches;

  explicit Wires(uint64_t seed)
      : switches(seed, [this](int index, bool closed) { edges.push_back({now_us, index, closed}); }) {}

  void run_to_the_end() {
    while (switches.next_us() != UINT64_MAX) {
      now_us = switches.next_us();
      switches.apply_due(now_us);
    }
  }
};

}  // namespace

TEST_CASE(a_knock_opens_and_closes) {
  Wires wires(1);
  wires.switches.knock(1, 0, 20000);
  wires.switches.knock(0, 0, 5000);
  wires.run_to_the_end();
  CHECK(wires.edges.size() == 4);
  CHECK(wires.edges[2].t_us == 5000 && wires.edges[2].index == 0 && wires.edges[2].closed);
  CHECK(wires.edges[3].t_us == 20000 && wires.edges[3].index == 1 && wires.edges[3].closed);
}

TEST_CASE(at_a_release_each_switch_alternates_and_stays_open) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    for (const uint64_t bounce_us : {0u, 300u, 5000u, 50000u}) {
      Wires wires(seed);
      wires.switches.set_bounce(bounce_us);
      const uint64_t released_us = wires.switches.release(1000);
      CHECK(released_us >= 1000 && released_us < 1600);
      wires.run_to_the_end();
      for (int index = 0; index < 2; ++index) {
        bool closed = true;
        uint64_t last_us = 0, first_us = 0;
        for (const Edge& edge : wires.edges) {
          if (edge.index != index) continue;
          CHECK(edge.closed != closed);
          closed = edge.closed;
          if (first_us == 0) first_us = edge.t_us;
          last_us = edge.t_us;
        }
        CHECK(!closed);
        CHECK(bounce_us == 0 ? last_us - first_us < 4000 : last_us - first_us == bounce_us);
      }
    }
  }
}

TEST_CASE(a_stuck_switch_shows_its_fault_until_it_is_healed) {
  Wires wires(1);
  wires.switches.set_fault(0, SwitchFault::kStuckClosed);
  wires.switches.set_fault(1, SwitchFault::kStuckOpen);
  CHECK(wires.edges.back().index == 1 && !wires.edges.back().closed);
  wires.switches.release(0);
  wires.run_to_the_end();
  for (const Edge& edge : wires.edges) CHECK(edge.closed == (edge.index == 0));
  wires.switches.set_fault(0, SwitchFault::kNone);
  CHECK(wires.edges.back().index == 0 && !wires.edges.back().closed);
  wires.switches.set(1, true);
  CHECK(!wires.edges.back().closed);
  wires.switches.set_fault(1, SwitchFault::kNone);
  CHECK(wires.edges.back().closed);
}
