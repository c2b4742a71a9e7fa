// The sequencer's state machine: SAFE, ARMED, RUNNING, DONE, FAULT.
#pragma once

#include "maneuver_store.h"
#include "ports.h"
#include "release_detector.h"

namespace tfsat {
namespace sequencer {

using protocol::SequencerState;

class Sequencer {
 public:
  Sequencer(ReleaseSwitches& switches, ServoOutput& servos, NonVolatile& memory)
      : switches_(switches), servos_(servos), store_(memory) {}

  // Once after power-up. The state is SAFE afterwards: no pulses, whatever happened before.
  void start(tick_t now);
  // Call from the main loop, many times a millisecond.
  void poll(tick_t now);

  // Arms if nothing forbids it; returns why not, else none. A token from before the last change of
  // state is refused, so that a frame repeated late cannot arm.
  ErrorCode arm(uint16_t token, tick_t now);
  void disarm();

  // The maneuver may change only while no joint is held by it.
  bool may_upload() const { return state_ == SequencerState::kSafe; }

  SequencerState state() const { return state_; }
  ErrorCode fault() const { return fault_; }
  ErrorCode last_refusal() const { return last_refusal_; }
  uint16_t arm_token() const { return token_; }
  uint8_t switches_open() { return switches_.levels(); }
  uint8_t strokes_started() const { return strokes_started_; }
  uint16_t knocks() const { return detector_.knocks(); }
  // What the servo of `joint` (1 to 3) is told to hold; 0 while safe, when none is told anything.
  int16_t joint_angle_cdeg(uint8_t joint) const;
  uint32_t uptime_ms() const { return uptime_ms_; }
  ManeuverStore& store() { return store_; }

 private:
  void enter(SequencerState state);
  ErrorCode refusal(uint16_t token);
  void watch_release(tick_t now);
  void begin_run(tick_t released_at);
  void watch_run(tick_t now);
  void count_uptime(tick_t now);

  ReleaseSwitches& switches_;
  ServoOutput& servos_;
  ManeuverStore store_;
  ReleaseDetector detector_;
  tick_t released_at_ = 0;
  tick_t last_ms_ = 0;
  uint32_t uptime_ms_ = 0;
  uint16_t token_ = 1;
  uint16_t accepted_token_ = 0;  // that armed the present state
  SequencerState state_ = SequencerState::kSafe;
  ErrorCode fault_ = ErrorCode::kNone;
  ErrorCode last_refusal_ = ErrorCode::kNone;
  uint8_t strokes_started_ = 0;
};

}  // namespace sequencer
}  // namespace tfsat
