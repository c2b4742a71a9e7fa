#include "sequencer.h"

#include "servo_map.h"

namespace tfsat {
namespace sequencer {

void Sequencer::start(tick_t now) {
  last_ms_ = now;
  store_.load();
}

void Sequencer::poll(tick_t now) {
  count_uptime(now);
  store_.poll();
  if (state_ == SequencerState::kArmed) {
    watch_release(now);
  } else if (state_ == SequencerState::kRunning) {
    watch_run(now);
  }
}

void Sequencer::count_uptime(tick_t now) {
  const uint32_t passed = (now - last_ms_) / kTicksPerMs;
  uptime_ms_ += passed;
  last_ms_ += passed * kTicksPerMs;
}

void Sequencer::enter(SequencerState state) {
  state_ = state;
  ++token_;
}

ErrorCode Sequencer::arm(uint16_t token, tick_t now) {
  if (state_ == SequencerState::kArmed && token == accepted_token_) return ErrorCode::kNone;
  last_refusal_ = refusal(token);
  if (last_refusal_ != ErrorCode::kNone) return last_refusal_;
  SwitchEdge stale;
  while (switches_.take_edge(stale)) {
  }
  detector_.reset(now);
  strokes_started_ = 0;
  for (uint8_t joint = 0; joint < protocol::kJointCount; ++joint) servos_.hold(joint, pulse_ticks(0));
  accepted_token_ = token;
  enter(SequencerState::kArmed);
  return ErrorCode::kNone;
}

ErrorCode Sequencer::refusal(uint16_t token) {
  if (state_ == SequencerState::kFault) return ErrorCode::kFaultLatched;
  const bool at_rest = state_ == SequencerState::kSafe || state_ == SequencerState::kDone;
  if (!at_rest || store_.writing()) return ErrorCode::kWrongState;
  if (token != token_) return ErrorCode::kStaleToken;
  if (store_.current().find_defect().code != ErrorCode::kNone) return ErrorCode::kNoManeuver;
  if (switches_.levels() != 0) return ErrorCode::kSwitchOpen;
  return ErrorCode::kNone;
}

void Sequencer::disarm() {
  servos_.stop();
  fault_ = ErrorCode::kNone;
  if (state_ != SequencerState::kSafe) enter(SequencerState::kSafe);
}

void Sequencer::watch_release(tick_t now) {
  SwitchEdge edge;
  while (switches_.take_edge(edge)) detector_.on_edge(edge);
  if (detector_.poll(now, switches_.levels())) begin_run(detector_.released_at());
}

// The whole schedule goes to the servo driver at once: from here on, hardware and its interrupts
// place the pulses, and nothing that the main loop does or suffers can move them.
void Sequencer::begin_run(tick_t released_at) {
  released_at_ = released_at;
  const Maneuver& maneuver = store_.current();
  for (uint8_t i = 0; i < maneuver.stroke_count; ++i) {
    const Stroke& stroke = maneuver.strokes[i];
    const int16_t target = static_cast<int16_t>(maneuver.angle_before(i, stroke.joint) + stroke.angle_cdeg);
    servos_.schedule(static_cast<uint8_t>(stroke.joint - 1), released_at + ticks_from_us(stroke.start_us),
                     pulse_ticks(target));
  }
  enter(SequencerState::kRunning);
}

void Sequencer::watch_run(tick_t now) {
  strokes_started_ = servos_.changes_begun();
  const Maneuver& maneuver = store_.current();
  if (tick_before(now, released_at_ + ticks_from_us(maneuver.end_us()))) return;
  if (strokes_started_ == maneuver.stroke_count) {
    enter(SequencerState::kDone);
  } else {
    fault_ = ErrorCode::kStrokeMissed;
    enter(SequencerState::kFault);
  }
}

// The strokes of the last run say nothing of a maneuver that was uploaded since.
int16_t Sequencer::joint_angle_cdeg(uint8_t joint) const {
  if (state_ == SequencerState::kSafe) return 0;
  return store_.current().angle_before(strokes_started_, joint);
}

}  // namespace sequencer
}  // namespace tfsat
