// What a board needs before it arms: a maneuver that somebody uploaded, and servos near their start.
#include "bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Bench;
using tfsat_test::bytes_of;
using tfsat_test::erased_eeprom;
using tfsat_test::uploaded_eeprom;

namespace {

void check_refused(Bench& bench, ErrorCode reason) {
  const bool held = bench.servos.held;
  const SequencerState state = bench.core.state();
  CHECK(bench.arm() == reason && bench.core.last_refusal() == reason);
  bench.run_ms(20);
  CHECK(bench.core.state() == state && bench.servos.held == held);
}

Maneuver one_stroke(uint8_t joint, int16_t angle_cdeg) {
  Maneuver maneuver = Maneuver::factory();
  maneuver.stroke_count = 1;
  maneuver.strokes[0] = Stroke{joint, angle_cdeg, 700000};
  return maneuver;
}

// Flies what is stored and hangs the robot up again.
void fly(Bench& bench, uint8_t strokes) {
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.run_ms(20);
  bench.open_both();
  bench.run_ms(20);
  bench.first_strokes_begin(strokes);
  bench.run_ms(2500);
  CHECK(bench.core.state() == SequencerState::kDone);
  bench.close_both();
  bench.run_ms(20);
}

}  // namespace

TEST_CASE(a_board_to_which_nothing_was_uploaded_does_not_arm) {
  Bench bench(0, erased_eeprom());
  CHECK(bench.core.maneuvers().origin() == Origin::kFactory);
  check_refused(bench, ErrorCode::kNoManeuver);
  bench.send(SettingsWriteRequest::kType, bytes_of(Settings::factory()));
  bench.run_ms(100);
  CHECK(bench.core.settings().origin() == Origin::kUploaded);
  check_refused(bench, ErrorCode::kNoManeuver);
  bench.send_strokes(Maneuver::factory());
  bench.run_ms(100);
  check_refused(bench, ErrorCode::kUploadInterrupted);
  bench.send_commit(Maneuver::factory());
  bench.run_ms(100);
  CHECK(bench.arm() == ErrorCode::kNone);
}

// What another sketch left there: two slots of each store are damaged, and two commits mend them.
TEST_CASE(a_board_with_a_foreign_eeprom_arms_once_both_are_uploaded) {
  Bench bench(0, std::vector<uint8_t>(1024, 0x33));
  CHECK(bench.core.maneuvers().origin() == Origin::kFactory);
  bench.send_strokes(Maneuver::factory());
  for (int slot = 0; slot < 2; ++slot) {
    check_refused(bench, ErrorCode::kStoreDamaged);
    bench.send_commit(Maneuver::factory());
    bench.send(SettingsWriteRequest::kType, bytes_of(Settings::factory()));
    bench.run_ms(300);
    bench.send(SettingsWriteRequest::kType, bytes_of(Settings::factory()));
    bench.run_ms(300);
  }
  CHECK(bench.arm() == ErrorCode::kNone);
}

TEST_CASE(a_servo_that_a_run_left_far_from_its_start_does_not_snap_back) {
  for (uint8_t joint = 1; joint <= kJointCount; ++joint) {
    for (const int16_t angle : {1, 999, 1000, 1001, 9000}) {
      Bench bench(0, uploaded_eeprom(one_stroke(joint, angle)));
      fly(bench, 1);
      CHECK(bench.core.held_cdeg()[joint - 1] == angle);
      const int16_t at_start[kJointCount] = {0, 0, 0};
      CHECK(bench.core.report_joints(at_start));  // what is told to the servo counts
      if (angle > static_cast<int16_t>(kStartPoseToleranceCdeg)) {
        check_refused(bench, ErrorCode::kNotAtStartPose);
        CHECK(bench.core.held_cdeg()[joint - 1] == angle);
        bench.core.disarm();  // limp: from here the joints are in somebody's hands
      }
      CHECK(bench.arm() == ErrorCode::kNone);
    }
  }
}

TEST_CASE(a_run_that_led_back_to_the_start_can_be_flown_again) {
  Bench bench;
  for (int run = 0; run < 3; ++run) fly(bench, 4);
}

TEST_CASE(a_release_right_after_the_check_of_the_switches_is_dated_by_its_edges) {
  Bench bench;
  bench.run_ms(20);
  const tfsat::sequencer::tick_t released_at = bench.now + 30;
  bench.switches.after_levels = [&] {
    bench.switches.set(0, true, released_at - 20);
    bench.switches.set(1, true, released_at);
  };
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.run_ms(20);
  CHECK(bench.core.state() == SequencerState::kRunning);
  const Maneuver& maneuver = bench.core.maneuvers().current();
  CHECK(bench.servos.changes.front().at ==
        released_at + ticks_from_us(maneuver.strokes[0].start_us));
}

TEST_CASE(edges_from_before_the_arming_release_nothing) {
  Bench bench;
  bench.open_both();
  bench.run_ms(20);
  bench.close_both();
  CHECK(bench.arm() == ErrorCode::kNone);
  bench.run_ms(50);
  CHECK(bench.core.state() == SequencerState::kArmed && bench.core.knocks() == 0);
}
