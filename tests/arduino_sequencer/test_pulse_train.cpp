// Pulse trains on their own, over many seeded runs at the clock's resolution.
#include "../../firmware/arduino_sequencer/src/core/pulse_train.h"
#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using tfsat_test::draw;
using tfsat_test::Random;

namespace {

constexpr uint32_t kFrame = 20 * kTicksPerMs;

uint16_t pulse_ticks(int16_t angle_cdeg) { return Settings::factory().pulse_ticks(1, angle_cdeg); }

// One joint's train, and the table that it shares with the others.
struct Bench {
  explicit Bench(uint8_t joint) : train(table, joint) { table.clear(); }
  // The next pulse that may begin a change.
  Pulse next_change() {
    Pulse pulse = train.next();
    while (pulse.change == nullptr) pulse = train.next();
    return pulse;
  }
  BegunChanges begun;
  ChangeTable table{begun};
  PulseTrain train;
};

}  // namespace

TEST_CASE(each_change_rises_on_its_tick_and_gaps_stay_even) {
  Random random(1);
  for (int round = 0; round < 20000; ++round) {
    Bench bench(1);
    ChangeTable& table = bench.table;
    PulseTrain& train = bench.train;
    const uint32_t frame = draw(random, 0, 1) == 0 ? kFrame : draw(random, 5, 20) * kTicksPerMs;
    tick_t now = draw(random, 0, 0xFFFFFFFF);
    train.hold(now + kTicksPerMs, pulse_ticks(0), frame);
    Pulse pulse = train.next();
    CHECK(pulse.rise == now + kTicksPerMs && pulse.width_ticks == 2000 && pulse.change == nullptr);
    for (tick_t idle = draw(random, 1, 50); idle > 0; --idle) {
      const tick_t before = pulse.rise;
      pulse = train.next();
      CHECK(pulse.rise - before == frame);
    }
    // As the state machine does: all at once, the first at least 0.69 s ahead.
    std::vector<Pulse> changes;
    tick_t at = pulse.rise + draw(random, 690, 720) * kTicksPerMs + draw(random, 0, 1999);
    tick_t room = tfsat::protocol::kMaxStrokes;
    for (tick_t left = draw(random, 1, room); left > 0; --left, --room) {
      const int16_t angle = static_cast<int16_t>(draw(random, 0, 9000));
      changes.push_back({at, pulse_ticks(angle), nullptr});
      CHECK(table.add(1, at, pulse_ticks(angle)));
      if (room > left && draw(random, 0, 3) == 0) {
        CHECK(table.add(0, at, 5000));  // another joint's is not ours
        --room;
      }
      const tick_t longest_ms = draw(random, 0, 1) == 0 ? 40 : 900;
      at += draw(random, 10 * kTicksPerMs, longest_ms * kTicksPerMs);
    }
    uint16_t width = 2000;
    for (size_t next = 0; next < changes.size();) {
      const tick_t left = changes[next].rise - pulse.rise;
      const tick_t before = pulse.rise;
      pulse = train.next();
      const tick_t gap = pulse.rise - before;
      CHECK(gap >= PulseTrain::kShortestGapTicks && gap <= frame + frame / 2);
      if (left >= frame + frame / 2) CHECK(gap >= frame * 3 / 4);
      if (left >= 690 * kTicksPerMs) CHECK_NEAR(gap, frame, frame / 50);
      CHECK(gap > width);  // the pulse before is over
      CHECK((pulse.change != nullptr) == (pulse.rise == changes[next].rise));
      CHECK(!tick_before(changes[next].rise, pulse.rise));
      if (pulse.change != nullptr) width = changes[next++].width_ticks;
      train.was_whole(pulse);
      CHECK(pulse.width_ticks == width);
    }
    const tick_t last = pulse.rise;
    pulse = train.next();
    CHECK(pulse.rise - last == frame);
    CHECK(pulse.width_ticks == width && pulse.change == nullptr);
  }
}

TEST_CASE(a_change_asked_for_too_late_begins_late_and_cuts_no_pulse) {
  Bench bench(2);
  ChangeTable& table = bench.table;
  PulseTrain& train = bench.train;
  train.hold(1000, 5000, kFrame);
  Pulse pulse = train.next();
  CHECK(table.add(2, pulse.rise - 3, 2000) && table.add(2, pulse.rise + 6999, 3000));
  pulse = train.next();
  CHECK(pulse.rise == 1000 + PulseTrain::kShortestGapTicks);
  CHECK(pulse.change != nullptr && pulse.width_ticks == 2000);
  train.was_whole(pulse);
  pulse = train.next();
  CHECK(pulse.rise == 1000 + 2 * PulseTrain::kShortestGapTicks);
  CHECK(pulse.change != nullptr && pulse.width_ticks == 3000);
}

TEST_CASE(a_table_that_was_cleared_and_a_train_that_was_stopped_forget) {
  Bench bench(0);
  ChangeTable& table = bench.table;
  PulseTrain& train = bench.train;
  train.hold(0, 2000, kFrame);
  train.next();
  for (uint8_t i = 0; i < tfsat::protocol::kMaxStrokes; ++i) CHECK(table.add(0, 100000u * (i + 1u), 3000));
  CHECK(!table.add(0, 9000000, 3000));
  table.clear();
  train.hold(0, 2500, kFrame);
  for (int i = 0; i < 10; ++i) {
    const Pulse pulse = train.next();
    CHECK(pulse.change == nullptr && pulse.width_ticks == 2500);
  }
  train.stop();
  CHECK(!train.running());
  train.hold(77, 2000, kFrame);
  CHECK(train.next().rise == 77);
}

// The pin was held: every pulse of the width is one that may begin the change, until one was whole.
TEST_CASE(a_change_begins_with_its_first_whole_pulse) {
  Bench bench(0);
  ChangeTable& table = bench.table;
  PulseTrain& train = bench.train;
  train.hold(0, 2000, kFrame);
  CHECK(table.add(1, 5, 4000) && table.add(0, 10 * kFrame, 2500) && table.add(0, 20 * kFrame, 3000));
  Pulse pulse = bench.next_change();
  CHECK(pulse.rise == 10 * kFrame && pulse.width_ticks == 2500);
  for (int i = 0; i < 3; ++i) pulse = train.next();
  CHECK(pulse.change != nullptr && pulse.width_ticks == 2500 && table.begun() == 0);
  train.was_whole(pulse);
  CHECK(table.begun() == 2 && table.began_at(1) == 13 * kFrame);
  pulse = train.next();
  CHECK(pulse.change == nullptr && pulse.width_ticks == 2500);
}

TEST_CASE(the_next_change_takes_the_place_of_one_that_has_not_begun) {
  Bench bench(0);
  ChangeTable& table = bench.table;
  PulseTrain& train = bench.train;
  train.hold(0, 2000, kFrame);
  CHECK(table.add(0, 10 * kFrame, 2500) && table.add(0, 20 * kFrame, 3000));
  Pulse pulse = train.next();
  while (pulse.width_ticks != 3000) pulse = train.next();
  CHECK(pulse.rise == 20 * kFrame && pulse.change != nullptr);
  train.was_whole(pulse);
  CHECK(table.begun() == 2 && table.began_at(1) == 20 * kFrame);
  CHECK(train.next().change == nullptr);
}

TEST_CASE(cancelled_changes_leave_the_train_at_the_width_it_has) {
  for (const bool under_way : {false, true}) {
    Bench bench(0);
    ChangeTable& table = bench.table;
    PulseTrain& train = bench.train;
    train.hold(0, 2000, kFrame);
    for (uint16_t i = 1; i <= 3; ++i)
      CHECK(table.add(0, i * 10 * kFrame, static_cast<uint16_t>(2000 + i)));
    Pulse pulse = bench.next_change();
    train.was_whole(pulse);
    pulse = bench.next_change();
    CHECK(pulse.width_ticks == 2002);
    table.cancel();
    train.cancel(under_way ? nullptr : &pulse);
    const uint16_t width = under_way ? 2002 : 2001;
    CHECK((pulse.change != nullptr) == under_way && pulse.width_ticks == width);
    train.was_whole(pulse);
    for (int i = 0; i < 20; ++i) {
      const tick_t before = pulse.rise;
      pulse = train.next();
      CHECK(pulse.width_ticks == width && pulse.change == nullptr && pulse.rise - before == kFrame);
    }
    CHECK(table.begun() == (under_way ? 3 : 1) && table.began_at(0) == 10 * kFrame);
  }
}
