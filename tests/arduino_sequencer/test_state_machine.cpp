// The state machine and the link: faults, hours, the turn of the clock, hanging hosts.
#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Answers;
using tfsat_test::Bench;
using tfsat_test::ScriptedServos;

namespace {

// The released run's changes are the factory maneuver's, counted from `released_at`.
void check_changes(const ScriptedServos& servos, tick_t released_at) {
  const Maneuver maneuver = Maneuver::factory();
  // 1000 us + 59/90 and 70/90 of 1000 us, in ticks; then back.
  const uint16_t widths[] = {3311, 3556, 2000, 2000};
  if (!CHECK(servos.changes.size() == 4)) return;
  for (uint8_t i = 0; i < 4; ++i) {
    CHECK(servos.changes[i].joint == maneuver.strokes[i].joint - 1);
    CHECK(servos.changes[i].at == released_at + ticks_from_us(maneuver.strokes[i].start_us));
    CHECK(servos.changes[i].width_ticks == widths[i]);
  }
}

}  // namespace

// Each subset of the strokes: those that did not begin will not begin any more, and are told.
TEST_CASE(a_stroke_that_did_not_begin_is_a_fault_until_somebody_disarms) {
  const Maneuver maneuver = Maneuver::factory();
  for (uint16_t begun = 0; begun < 15; ++begun) {
    Bench bench;
    bench.fly(100);
    bench.strokes_begin(begun);
    bench.run_ms(2400);
    CHECK(bench.is(SequencerState::kFault, ErrorCode::kStrokeMissed));
    CHECK(bench.servos.held && bench.servos.cancelled);  // the joints stay where they are
    const RunReportReply& report = bench.core.run_report();
    CHECK(report.stroke_count == 4);
    int16_t angles[3] = {0, 0, 0};
    uint8_t count = 0;
    for (uint8_t i = 0; i < 4; ++i) {
      const bool has_begun = (begun & 1u << i) != 0;
      CHECK(report.start_us[i] == (has_begun ? maneuver.strokes[i].start_us : kStrokeNotBegunUs));
      if (!has_begun) continue;
      ++count;
      angles[maneuver.strokes[i].joint - 1] = i < 2 ? maneuver.strokes[i].angle_cdeg : 0;
    }
    CHECK(bench.core.strokes_started() == count);
    for (int joint = 0; joint < 3; ++joint) CHECK(bench.core.held_cdeg()[joint] == angles[joint]);
    bench.close_both();
    bench.run_ms(20);
    CHECK(bench.arm() == ErrorCode::kFaultLatched);
    CHECK(!bench.core.may_upload());
    bench.core.disarm();
    CHECK(bench.core.state() == SequencerState::kSafe && bench.core.fault() == ErrorCode::kNone);
    CHECK(!bench.servos.held);
    CHECK(bench.arm() == ErrorCode::kNone);
  }
}

// Its pulse was under way when the run ended: it can begin still, and is noted.
TEST_CASE(a_stroke_that_begins_as_the_run_ends_is_told) {
  Bench bench;
  bench.wait_armed();
  bench.open_both();
  bench.run_ms(2400);
  CHECK(bench.core.fault() == ErrorCode::kStrokeMissed && bench.core.strokes_started() == 0);
  bench.strokes_begin(2);
  bench.run_ms(1);
  CHECK(bench.core.fault() == ErrorCode::kStrokeMissed && bench.core.strokes_started() == 1);
  CHECK(bench.core.held_cdeg()[1] == 7000);
  Bench after(bench, ResetCause::kBrownOut);
  CHECK(after.core.held_cdeg()[1] == 7000 && after.core.strokes_started() == 1);
}

// A jolt on the crane: armed again, and the drop that follows flies all its strokes.
TEST_CASE(both_closed_again_before_the_first_stroke_is_armed_again) {
  for (const uint32_t open_ms : {6u, 480u}) {
    Bench bench;
    bench.fly(open_ms);
    bench.close_both();
    bench.run_ms(199);
    CHECK(bench.is(SequencerState::kRunning));
    bench.run_ms(2);
    CHECK(bench.is(SequencerState::kArmed) && bench.core.false_releases() == 1);
    CHECK(bench.servos.changes.empty() && bench.servos.held && bench.core.strokes_started() == 0);
    CHECK(bench.core.run_report().released == 0 && bench.core.knocks() == 0);
    check_changes(bench.servos, bench.release());
  }
}

// Taken back while the first stroke's first pulse is on its pin: it cannot be called back, so the joint moves.
TEST_CASE(both_closed_again_as_the_first_stroke_begins_is_a_fault) {
  Bench bench;
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.open_both();
  bench.run_ms(490);
  bench.close_both();
  bench.servos.under_way = true;
  bench.run_ms(202);
  CHECK(bench.core.fault() == ErrorCode::kClosedWhileRunning && bench.core.strokes_started() == 0);
  bench.first_strokes_begin(1);
  bench.run_ms(2);
  CHECK(bench.core.strokes_started() == 1 && bench.core.held_cdeg()[0] == 5900);
}

// The first stroke's time is over and no pulse of it was seen: a joint may have moved all the same.
TEST_CASE(both_closed_again_after_the_time_of_a_stroke_that_was_not_seen_is_a_fault) {
  Bench bench;
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.open_both();
  bench.run_ms(600);
  bench.close_both();
  bench.run_ms(202);
  CHECK(bench.core.fault() == ErrorCode::kClosedWhileRunning && bench.core.strokes_started() == 0);
}

// The clock wraps after 35.8 minutes: release, strokes and end on either side of it.
TEST_CASE(released_across_the_turn_of_the_clock) {
  for (int32_t before_ms = -10; before_ms <= 3000; before_ms += 29) {
    const int32_t start_ms = -before_ms - 100;
    Bench bench(static_cast<tick_t>(start_ms * static_cast<int32_t>(kTicksPerMs)));
    CHECK(bench.arm() == ErrorCode::kNone);
    bench.run_ms(100);
    bench.open_both();
    const tick_t released_at = bench.now();
    bench.run_ms(10);
    CHECK(bench.core.state() == SequencerState::kRunning);
    check_changes(bench.servos, released_at);
    bench.first_strokes_begin(4);
    bench.run_ms(2210);
    CHECK(bench.core.state() == SequencerState::kRunning);
    bench.run_ms(25);
    CHECK(bench.core.state() == SequencerState::kDone);
  }
}

// One switch that stays open for more than half a turn of the clock, or a knock after so long.
TEST_CASE(a_switch_open_for_hours_delays_nothing) {
  for (const uint32_t minutes : {1u, 17u, 18u, 19u, 35u, 36u, 37u, 90u}) {
    Bench bench;
    CHECK(bench.arm() == ErrorCode::kNone);
    bench.switches.set(0, true, bench.now());
    for (uint32_t i = 0; i < 60 * minutes; ++i) {
      bench.pass(1000 * kTicksPerMs);
      bench.poll();
    }
    CHECK(bench.core.state() == SequencerState::kArmed);
    bench.switches.set(0, false, bench.now());
    bench.run_ms(10);
    CHECK(bench.core.knocks() == 1);
    bench.open_both();
    const tick_t released_at = bench.now();
    bench.run_ms(10);
    CHECK(bench.core.state() == SequencerState::kRunning);
    check_changes(bench.servos, released_at);
  }
}

TEST_CASE(an_edge_that_hardware_missed_is_made_up_for_by_the_level) {
  for (const int missed : {0, 1, 2, 3}) {
    Bench bench;
    bench.wait_armed();
    const tick_t opened_at = bench.now();
    bench.switches.set(0, true, opened_at, (missed & 1) == 0);
    bench.switches.set(1, true, opened_at, (missed & 2) == 0);
    bench.run_ms(20);
    CHECK(bench.core.state() == SequencerState::kRunning);
    if (bench.servos.changes.empty()) continue;
    const tick_t error = bench.servos.changes[0].at - opened_at - ticks_from_us(700000);
    CHECK(error <= (missed == 0 ? 0 : kTicksPerMs / 10));
  }
}

TEST_CASE(a_store_that_does_not_keep_is_told_once_and_tried_again) {
  Bench bench;
  // In the slot whose turn it is.
  bench.eeprom.worn_address = Sequencer::kManeuverAddress + SlotPair::kSlotBytes;
  Maneuver wanted = Maneuver::factory();
  wanted.stroke_count = 1;
  wanted.strokes[0] = Stroke{1, 1000, 700000};
  bench.send_strokes(wanted);
  std::vector<ErrorCode> codes;
  for (int i = 0; i < 4; ++i) {
    bench.send_commit(wanted);
    bench.finish_storing();
    const Answers answers(bench.received);
    if (!CHECK(answers.types.size() == static_cast<size_t>(3 + i))) return;
    codes.push_back(answers.types.back() == ErrorReply::kType
                        ? static_cast<ErrorCode>(answers.payloads.back()[1])
                        : ErrorCode::kNone);
    // Still writing, not stored.
    if (codes.back() == ErrorCode::kNone) CHECK(answers.payloads.back()[0] == 0);
  }
  CHECK(codes[0] == ErrorCode::kNone && codes[1] == ErrorCode::kStoreFailed);
  CHECK(codes[2] == ErrorCode::kNone && codes[3] == ErrorCode::kStoreFailed);
  CHECK(tfsat_test::same_record(bench.core.maneuvers().current(), Maneuver::factory()));
  CHECK(bench.arm() == ErrorCode::kStoreDamaged);  // the old one is whole, but the board may be worn
}

TEST_CASE(nothing_is_written_unasked_in_any_state) {
  Bench bench;
  bench.run_ms(50);
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.run_ms(50);
  bench.open_both();
  bench.run_ms(100);
  bench.first_strokes_begin(4);
  bench.run_ms(2500);
  CHECK(bench.core.state() == SequencerState::kDone);
  CHECK(bench.received.empty());
}

TEST_CASE(a_host_that_takes_a_byte_at_a_time_gets_whole_answers) {
  for (size_t room = 1; room < 40; ++room) {
    Bench bench;
    bench.stream.room = room;
    for (int i = 0; i < 20; ++i) bench.send(HelloRequest::kType);
    bench.run_ms(200);
    const Answers answers(bench.received);
    CHECK(answers.types.size() == 20);
  }
}

TEST_CASE(one_poll_reads_no_more_than_its_budget) {
  Bench bench;
  bench.write(std::vector<uint8_t>(4000, 0x55));
  bench.link.poll();
  CHECK(bench.stream.bytes_read == 64);
  bench.link.poll(255);
  CHECK(bench.stream.bytes_read == 64 + 255);
}

TEST_CASE(half_an_answer_is_forgotten_when_the_cable_is_pulled) {
  Bench bench;
  bench.stream.room = 5;
  bench.send(HelloRequest::kType);
  bench.poll();
  bench.stream.room = 0;
  bench.poll();
  CHECK(!bench.received.empty());
  bench.stream.set_plugged(false);
  bench.poll();
  bench.stream.set_plugged(true);
  bench.received.clear();
  bench.stream.room = 1000;
  bench.run_ms(5);
  CHECK(bench.received.empty());
  bench.send(DisarmRequest::kType);
  bench.run_ms(5);
  CHECK(Answers(bench.received).types == std::vector<uint8_t>{DisarmReply::kType});
}

TEST_CASE(a_servo_that_a_run_left_far_from_its_start_does_not_snap_back) {
  for (uint8_t joint = 1; joint <= kJointCount; ++joint) {
    for (const int16_t angle : {1, 999, 1000, 1001, 9000}) {
      Maneuver maneuver = Maneuver::factory();
      maneuver.stroke_count = 1;
      maneuver.strokes[0] = Stroke{joint, angle, 700000};
      Bench bench(0, tfsat_test::uploaded_image(maneuver));
      bench.fly();
      bench.first_strokes_begin(1);
      bench.run_ms(2500);
      CHECK(bench.is(SequencerState::kDone));
      bench.close_both();
      bench.run_ms(20);
      CHECK(bench.core.held_cdeg()[joint - 1] == angle);
      const int16_t at_start[kJointCount] = {0, 0, 0};
      CHECK(bench.core.report_joints(at_start));  // what the servo is driven to counts
      if (angle > static_cast<int16_t>(kStartPoseToleranceCdeg)) {
        CHECK(bench.arm() == ErrorCode::kNotAtStartPose);
        CHECK(bench.core.last_refusal() == ErrorCode::kNotAtStartPose);
        bench.run_ms(20);
        CHECK(bench.is(SequencerState::kDone) && bench.servos.held);
        CHECK(bench.core.held_cdeg()[joint - 1] == angle);
        bench.core.disarm();  // limp: from here on a person turns the joints
      }
      CHECK(bench.arm() == ErrorCode::kNone);
    }
  }
}

TEST_CASE(a_release_right_after_the_check_of_the_switches_is_dated_by_its_edges) {
  Bench bench;
  bench.run_ms(20);
  const tick_t released_at = bench.now() + 30;
  bench.switches.after_levels = [&] {
    bench.switches.set(0, true, released_at - 20);
    bench.switches.set(1, true, released_at);
  };
  bench.wait_armed();
  CHECK(bench.core.state() == SequencerState::kRunning);
  const Maneuver& maneuver = bench.core.maneuvers().current();
  CHECK(bench.servos.changes.front().at ==
        released_at + ticks_from_us(maneuver.strokes[0].start_us));
}
