// Jogging: never faster than 15 deg/s, never outside the joint's limits, one joint at a time.
#include <algorithm>

#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Bench;

namespace {

JogRequest order(uint8_t joint, int16_t from_cdeg, int16_t to_cdeg) {
  JogRequest request;
  request.joint = joint;
  request.from_cdeg = from_cdeg;
  request.to_cdeg = to_cdeg;
  request.confirm = kJogConfirm;
  return request;
}

// Angle after `ms` milliseconds, in whole hundredths of a degree.
int16_t on_the_way(int16_t from_cdeg, int16_t to_cdeg, uint32_t ms) {
  const int32_t way = to_cdeg - from_cdeg;
  const int32_t most = static_cast<int32_t>(ms * kJogSpeedCdegS / 1000);
  const int32_t gone = std::min<int32_t>(way < 0 ? -way : way, most);
  return static_cast<int16_t>(from_cdeg + (way < 0 ? -gone : gone));
}

void poll_after_ms(Bench& bench, uint32_t ms) {
  bench.pass(ms * kTicksPerMs);
  bench.poll();
}

// As a host does that wants the joint to move on: it repeats its order.
void go_on(Bench& bench, const JogRequest& request, uint32_t ms) {
  CHECK(bench.core.jog(request) == ErrorCode::kNone);
  poll_after_ms(bench, ms);
}

}  // namespace

TEST_CASE(a_jog_goes_15_degrees_a_second_however_often_it_is_polled) {
  const Settings settings = Settings::factory();
  for (const uint32_t interval_ms : {1u, 2u, 3u, 7u, 20u, 64u, 333u, kJogIdleMs - 1}) {
    for (const bool up : {true, false}) {
      for (const int16_t target : {1, 2, 1499, 1500, 1501, 9000}) {
        const int16_t from = up ? 0 : target;
        const int16_t to = up ? target : 0;
        Bench bench;
        CHECK(bench.core.jog(order(2, from, to)) == ErrorCode::kNone);
        for (uint32_t ms = 0; ms < 6000 + 2 * interval_ms; ms += interval_ms) {
          const int16_t expected = on_the_way(from, to, ms);
          CHECK(bench.core.held_cdeg()[1] == expected);
          CHECK(bench.servos.widths[1] == settings.pulse_ticks(2, expected));
          CHECK(bench.core.jogging().arrived() == (expected == to));
          go_on(bench, order(2, from, to), interval_ms);
        }
        CHECK(bench.core.held_cdeg()[1] == to);
        CHECK(bench.servos.widths[0] == 0 && bench.servos.widths[2] == 0);  // limp
        CHECK(bench.core.held_cdeg()[0] == 0 && bench.core.held_cdeg()[2] == 0);
      }
    }
  }
}

TEST_CASE(a_new_target_on_the_way_turns_the_joint_without_a_jump) {
  Bench bench;
  CHECK(bench.core.jog(order(1, 3000, 9000)) == ErrorCode::kNone);
  int16_t angle = 3000;
  const int16_t targets[] = {0, 9000, 4000, 4000, 5000, 100};
  for (const int16_t target : targets) {
    // Where the host believes the joint to be is heeded at the start only.
    CHECK(bench.core.jog(order(1, 8999, target)) == ErrorCode::kNone);
    for (int ms = 0; ms < 700; ++ms) {
      poll_after_ms(bench, 1);
      const int16_t now = bench.core.held_cdeg()[0];
      const int16_t step = static_cast<int16_t>(now > angle ? now - angle : angle - now);
      CHECK(step <= 2);
      CHECK(now == target || (now > angle) == (target > angle) || now == angle);
      angle = now;
    }
  }
}

// Waiting at the target earns no speed for the next order.
TEST_CASE(a_rest_between_orders_is_no_head_start) {
  Bench bench;
  CHECK(bench.core.jog(order(1, 0, 1)) == ErrorCode::kNone);
  for (int i = 0; i < 150; ++i) go_on(bench, order(1, 0, 1), 100);
  go_on(bench, order(1, 0, 9000), 100);
  CHECK(bench.core.held_cdeg()[0] >= 150 && bench.core.held_cdeg()[0] <= 152);
}

// By the settings before, the first pulse would drive the joint from where it stands at full speed.
TEST_CASE(a_jog_by_settings_that_are_not_the_last_committed_is_refused) {
  Settings mounted = Settings::factory();
  mounted.servo[0].zero_us = 2000;
  mounted.servo[0].reversed = 1;
  tfsat_test::ScriptedEeprom memory(tfsat_test::factory_image());
  CHECK(tfsat_test::put(memory, Sequencer::kSettingsAddress, Settings::factory()));
  CHECK(tfsat_test::put(memory, Sequencer::kSettingsAddress, mounted));
  int refused = 0;
  for (uint16_t at = 0; at < 2 * SlotPair::kSlotBytes; ++at) {
    tfsat_test::ScriptedEeprom::Image damaged = memory.image();
    damaged[Sequencer::kSettingsAddress + at] ^= 0x10;
    Bench bench(0, damaged);
    const ErrorCode error = bench.core.jog(order(1, 0, 100));
    if (error == ErrorCode::kNone) {
      CHECK(bench.servos.widths[0] == 4000);
    } else {
      CHECK(error == ErrorCode::kStoreDamaged && bench.limp());
      ++refused;
    }
  }
  CHECK(refused > 0);
}

TEST_CASE(a_jog_without_orders_ends_after_a_second_and_each_order_counts_anew) {
  Bench bench;
  CHECK(bench.core.jog(order(3, 0, 9000)) == ErrorCode::kNone);
  bench.run_ms(kJogIdleMs - 1);
  CHECK(bench.core.state() == SequencerState::kJogging);
  CHECK(bench.core.jog(order(3, 0, 9000)) == ErrorCode::kNone);
  bench.run_ms(kJogIdleMs - 1);
  CHECK(bench.core.state() == SequencerState::kJogging);
  CHECK(bench.core.jog(order(3, 0, 9001)) == ErrorCode::kAngleOutOfRange);  // no order
  bench.run_ms(1);
  CHECK(bench.limp());
}

TEST_CASE(a_jog_across_the_turn_of_the_clock_and_after_hours) {
  for (int32_t before_ms = 0; before_ms <= 7000; before_ms += 250) {
    Bench bench(static_cast<tick_t>(-before_ms * static_cast<int32_t>(kTicksPerMs)));
    CHECK(bench.core.jog(order(1, 0, 9000)) == ErrorCode::kNone);
    for (uint32_t ms = 0; ms <= 7000; ms += 10) {
      CHECK(bench.core.held_cdeg()[0] == on_the_way(0, 9000, ms));
      go_on(bench, order(1, 0, 9000), 10);
    }
  }
  Bench bench;
  bench.run_hours(30);
  CHECK(bench.core.jog(order(1, 0, 9000)) == ErrorCode::kNone);
  poll_after_ms(bench, 900);
  CHECK(bench.core.held_cdeg()[0] == 1350);
  bench.run_ms(kJogIdleMs);
  CHECK(bench.limp());
}
