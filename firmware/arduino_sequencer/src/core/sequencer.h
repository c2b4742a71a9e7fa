// The sequencer's state machine: SAFE, ARMED, RUNNING, DONE, FAULT, JOGGING.
#pragma once

#include "jog.h"
#include "maneuver.h"
#include "ports.h"
#include "release_detector.h"
#include "retained_state.h"
#include "settings.h"
#include "slot_pair.h"

namespace tfsat {
namespace sequencer {

using protocol::ResetCause;
using protocol::SequencerState;

class Sequencer {
 public:
  // Not at address 0: a write at too low a voltage may hit that cell.
  static constexpr uint16_t kManeuverAddress = 512;
  static constexpr uint16_t kSettingsAddress = 768;

  Sequencer(ReleaseSwitches& switches, ServoOutput& servos, NonVolatile& memory,
            RetainedState& retained)
      : switches_(switches),
        servos_(servos),
        retained_(retained),
        maneuvers_(memory, kManeuverAddress),
        settings_(memory, kSettingsAddress) {}

  // Once after start-up. SAFE, unless the board was armed, running or in a fault when it was reset
  // without losing its power: see resume().
  void start(tick_t now, ResetCause cause);
  // Call from the main loop; a millisecond apart is often enough.
  void poll(tick_t now);
  // Nobody has the port open any more: a jog ends. Armed stays armed.
  void host_gone();

  // Arms if nothing forbids it; returns why not, else none. A token from before the last change of
  // state is refused, so that a frame repeated late cannot arm.
  ErrorCode arm(uint16_t token, tick_t now);
  void disarm();
  // See the protocol's jog.
  ErrorCode jog(const protocol::JogRequest& request);
  // Notes the joints' angles for arm(); true if all are at the start pose.
  bool report_joints(const int16_t (&angle_cdeg)[protocol::kJointCount]);

  // The release, or a false one, may come: edges of the switches count.
  bool watching() const {
    return state_ == SequencerState::kArmed || state_ == SequencerState::kRunning;
  }

  // Maneuver and settings may change only while no joint is held by them.
  bool may_upload() const { return state_ == SequencerState::kSafe && !resuming_; }

  // A record is on its way into non-volatile memory, which does one thing at a time.
  bool storing() const { return maneuvers_.writing() || settings_.writing(); }

  SequencerState state() const { return state_; }
  ErrorCode fault() const { return retained_.condition.fault; }
  ErrorCode last_refusal() const { return last_refusal_; }
  uint16_t arm_token() const { return retained_.token; }
  uint8_t switches_open() { return switches_.levels(); }
  uint8_t resets_while_armed() const { return retained_.resets; }
  uint8_t strokes_started() const { return strokes_started_; }
  uint16_t knocks() const { return detector_.knocks(); }
  uint16_t false_releases() const { return retained_.false_releases; }
  // Bit i: servo i gets pulses.
  uint8_t driven() const { return retained_.driven; }
  // What each servo is told to hold, that is what its pin has had; 0 where it gets no pulses.
  const int16_t (&held_cdeg() const)[protocol::kJointCount] { return retained_.held_cdeg; }
  const Jog& jogging() const { return jog_; }
  uint32_t uptime_ms() const { return uptime_ms_; }
  const protocol::RunReportReply& run_report() const { return retained_.run.report; }
  Stored<Maneuver>& maneuvers() { return maneuvers_; }
  Stored<Settings>& settings() { return settings_; }

 private:
  void resume_after(RetainedState::Condition before, tick_t now);
  void forget();
  void enter(SequencerState state, ErrorCode fault = ErrorCode::kNone);
  void change_token();
  void latch(ErrorCode fault);
  void hold(uint8_t joint, int16_t angle_cdeg);
  void hold_start_pose();
  void drive_none();
  void note_held(uint8_t joint, int16_t angle_cdeg);
  ErrorCode refusal(uint16_t token);
  bool fits_settings() const;
  void begin_watch(tick_t now);
  ErrorCode store_defect() const;
  uint16_t records() const;
  void note_begun();
  void resume(tick_t now);
  void watch_switches(tick_t now);
  void take_edges(tick_t now);
  void heed(ReleaseDetector::Verdict verdict, tick_t now);
  void begin_run(tick_t released_at);
  void end_false_run(tick_t now);
  void watch_run(tick_t now);
  void watch_jog();
  void note_release_time();
  void note_release_interval();
  void note_strokes(uint16_t begun, bool timed);
  void count_uptime(tick_t now);

  ReleaseSwitches& switches_;
  ServoOutput& servos_;
  RetainedState& retained_;
  Stored<Maneuver> maneuvers_;
  Stored<Settings> settings_;
  ReleaseDetector detector_{};
  Jog jog_{};
  tick_t released_at_;   // of the last run, by begin_run()
  tick_t last_ms_;       // by start()
  tick_t resume_since_;  // while resuming_
  uint32_t uptime_ms_ = 0;
  uint32_t reported_ms_;  // both: once reported_
  int16_t reported_cdeg_[protocol::kJointCount];
  uint16_t accepted_token_ = 0;  // that armed the present state
  SequencerState state_ = SequencerState::kSafe;
  ErrorCode last_refusal_ = ErrorCode::kNone;
  uint8_t strokes_started_ = 0;
  bool reported_ = false;
  bool resuming_ = false;
};

}  // namespace sequencer
}  // namespace tfsat
