#include "sequencer.h"

namespace tfsat {
namespace sequencer {

using namespace protocol;

namespace {

constexpr uint32_t kDebounceTicks = ticks_from_us(kReleaseDebounceUs);
constexpr uint8_t kMostResets = 255;
// A stroke has begun when its first pulse is over: the last one may be of any length.
constexpr uint32_t kLastPulseUs = kServoPulseMaxUs + 1000;

bool near_start_pose(const int16_t (&angle_cdeg)[kJointCount]) {
  constexpr int16_t tolerance = static_cast<int16_t>(kStartPoseToleranceCdeg);
  for (int16_t angle : angle_cdeg) {
    if (angle > tolerance || angle < -tolerance) return false;
  }
  return true;
}

}  // namespace

constexpr uint16_t Sequencer::kManeuverAddress;
constexpr uint16_t Sequencer::kSettingsAddress;

static_assert(Sequencer::kManeuverAddress + SlotPair::kBytes <= Sequencer::kSettingsAddress,
              "the stores must not overlap");

// A board that lost its power does not know where its servos stand: it starts SAFE. One that was
// reset with its RAM intact goes on from what it knows, but never by moving anything. What is kept is
// brought up to date before the servos are driven: another reset may come at any moment.
void Sequencer::start(tick_t now, ResetCause cause) {
  last_ms_ = now;
  maneuvers_.load();
  settings_.load();
  const bool powered = cause != ResetCause::kPowerOn;
  if (powered) retained_.recover();
  if (!powered || !retained_.run.intact()) retained_.run.clear();
  if (!powered || !retained_.intact()) retained_.clear();
  change_token();  // none from before the reset fits
  detector_.reset(now, retained_.knocks);
  resume_after(retained_.condition, now);
  for (uint8_t joint = 1; joint <= kJointCount; ++joint) {
    if (retained_.driven & (1u << (joint - 1))) hold(joint, retained_.held_cdeg[joint - 1]);
  }
}

void Sequencer::resume_after(RetainedState::Condition before, tick_t now) {
  const bool held = before.state == SequencerState::kArmed ||
                    before.state == SequencerState::kRunning ||
                    before.state == SequencerState::kFault;
  if (!held) {
    forget();
    retained_.set(retained_.false_releases, uint16_t{0});
    detector_.reset(now, 0);
  } else if (store_defect() != ErrorCode::kNone || retained_.records != records()) {
    // What the marks are of is not known: no stroke is noted by them.
    drive_none();
    retained_.begun.set(0);
    latch(ErrorCode::kStoreDamaged);
  } else if (before.state == SequencerState::kArmed) {
    if (retained_.resets < kMostResets) {
      retained_.set(retained_.resets, static_cast<uint8_t>(retained_.resets + 1));
    }
    resuming_ = true;
    resume_since_ = now;
  } else {
    note_begun();
    latch(before.state == SequencerState::kRunning ? ErrorCode::kResetWhileRunning : before.fault);
  }
}

// Nothing is held, and nothing is wrong; token and false releases stay.
void Sequencer::forget() {
  retained_.set(retained_.condition,
                RetainedState::Condition{SequencerState::kSafe, ErrorCode::kNone});
  drive_none();
  retained_.set(retained_.knocks, uint16_t{0});
  retained_.set(retained_.records, uint16_t{0});
  retained_.set(retained_.resets, uint8_t{0});
}

void Sequencer::drive_none() {
  retained_.set(retained_.driven, uint8_t{0});
  for (int16_t& angle_cdeg : retained_.held_cdeg) retained_.set(angle_cdeg, int16_t{0});
}

ErrorCode Sequencer::store_defect() const {
  const ErrorCode of_maneuver = maneuvers_.defect();
  return of_maneuver != ErrorCode::kNone ? of_maneuver : settings_.defect();
}

// A supply that dips can damage the EEPROM: what it holds now may be older than what was armed.
uint16_t Sequencer::records() const {
  return static_cast<uint16_t>(maneuvers_.generation() << 8 | (settings_.generation() & 0xFF));
}

// Strokes that began while the main loop hung are known to the interrupts' marks alone. If those make
// no sense, nobody knows where the servos stand: they stay limp.
void Sequencer::note_begun() {
  if (retained_.begun.intact()) {
    note_strokes(retained_.begun.bits, false);
  } else {
    drive_none();
    retained_.begun.set(0);
  }
}

void Sequencer::poll(tick_t now) {
  count_uptime(now);
  maneuvers_.poll();
  settings_.poll();
  if (resuming_) resume(now);
  switch (state_) {
    case SequencerState::kArmed:
    case SequencerState::kRunning:
      watch_switches(now);
      break;
    case SequencerState::kJogging:
      watch_jog();
      break;
    case SequencerState::kFault:
      note_strokes(servos_.changes_begun(), true);
      break;
    default:
      break;
  }
}

// Division takes the AVR 40 us: only where the loop was away for long.
void Sequencer::count_uptime(tick_t now) {
  const tick_t passed = now - last_ms_;
  if (passed < kTicksPerMs) return;
  const uint32_t ms = passed < 2 * kTicksPerMs ? 1 : passed / kTicksPerMs;
  last_ms_ += ms * kTicksPerMs;
  uptime_ms_ += ms;
}

void Sequencer::enter(SequencerState state, ErrorCode fault) {
  state_ = state;
  change_token();
  retained_.set(retained_.condition, RetainedState::Condition{state, fault});
}

void Sequencer::change_token() {
  retained_.set(retained_.token, static_cast<uint16_t>(retained_.token + 1));
}

void Sequencer::latch(ErrorCode fault) {
  resuming_ = false;
  enter(SequencerState::kFault, fault);
}

void Sequencer::hold(uint8_t joint, int16_t angle_cdeg) {
  const Settings& settings = settings_.current();
  servos_.hold(static_cast<uint8_t>(joint - 1), settings.pulse_ticks(joint, angle_cdeg),
               settings.frame_ticks());
  note_held(joint, angle_cdeg);
  retained_.set(retained_.driven,
                static_cast<uint8_t>(retained_.driven | (1u << (joint - 1))));
}

// Also forgets what was scheduled.
void Sequencer::hold_start_pose() {
  for (uint8_t joint = 1; joint <= kJointCount; ++joint) hold(joint, 0);
}

void Sequencer::note_held(uint8_t joint, int16_t angle_cdeg) {
  retained_.set(retained_.held_cdeg[joint - 1], angle_cdeg);
}

ErrorCode Sequencer::arm(uint16_t token, tick_t now) {
  if (state_ == SequencerState::kArmed && token == accepted_token_) return ErrorCode::kNone;
  last_refusal_ = refusal(token);
  if (last_refusal_ != ErrorCode::kNone) return last_refusal_;
  retained_.set(retained_.knocks, uint16_t{0});
  retained_.set(retained_.false_releases, uint16_t{0});
  retained_.set(retained_.resets, uint8_t{0});
  retained_.set(retained_.records, records());
  begin_watch(now);
  hold_start_pose();
  accepted_token_ = token;
  enter(SequencerState::kArmed);
  return ErrorCode::kNone;
}

// The edges from before have been taken, and after that both switches were closed: what has come
// since is the detector's.
void Sequencer::begin_watch(tick_t now) {
  detector_.reset(now, retained_.knocks);
  strokes_started_ = 0;
}

ErrorCode Sequencer::refusal(uint16_t token) {
  if (state_ == SequencerState::kFault) return ErrorCode::kFaultLatched;
  const bool at_rest = state_ == SequencerState::kSafe || state_ == SequencerState::kDone;
  if (!at_rest || resuming_ || storing()) return ErrorCode::kWrongState;
  if (token != retained_.token) return ErrorCode::kStaleToken;
  if (store_defect() != ErrorCode::kNone) return store_defect();
  if (maneuvers_.origin() == Origin::kFactory) return ErrorCode::kNoManeuver;
  const uint8_t moving_at_once = settings_.current().moving_at_once;
  const Defect defect = maneuvers_.current().find_defect(moving_at_once != 0 ? moving_at_once : 1);
  if (defect.code == ErrorCode::kTooManyMoving) return defect.code;
  if (defect.code != ErrorCode::kNone) return ErrorCode::kNoManeuver;
  if (!fits_settings()) return ErrorCode::kSettingsDoNotFit;
  for (SwitchEdge stale; switches_.take_edge(stale);) continue;
  if (switches_.levels() != 0) return ErrorCode::kSwitchOpen;
  if (state_ == SequencerState::kDone && !near_start_pose(retained_.held_cdeg)) {
    return ErrorCode::kNotAtStartPose;
  }
  const bool fresh = reported_ && uptime_ms_ - reported_ms_ < kJointReportAgeMs;
  return fresh && !near_start_pose(reported_cdeg_) ? ErrorCode::kNotAtStartPose : ErrorCode::kNone;
}

bool Sequencer::fits_settings() const {
  const Maneuver& maneuver = maneuvers_.current();
  for (uint8_t i = 0; i < maneuver.stroke_count; ++i) {
    const uint8_t joint = maneuver.strokes[i].joint;
    if (!settings_.current().allows(joint,
                                    maneuver.angle_before(static_cast<uint8_t>(i + 1), joint)))
      return false;
  }
  return true;
}

bool Sequencer::report_joints(const int16_t (&angle_cdeg)[kJointCount]) {
  for (uint8_t i = 0; i < kJointCount; ++i) reported_cdeg_[i] = angle_cdeg[i];
  reported_ = true;
  reported_ms_ = uptime_ms_;
  return near_start_pose(reported_cdeg_);
}

void Sequencer::disarm() {
  servos_.stop();
  resuming_ = false;
  forget();
  enter(SequencerState::kSafe);  // in SAFE too: an ARM that was sent before must not arm
}

// Once the switches have been closed for the debounce, the board is armed as before. One that is
// open may have opened during the reset: when, nobody knows, so nothing moves. Any edge, a closing
// one as well, tells of a switch that was open.
void Sequencer::resume(tick_t now) {
  bool opened = switches_.levels() != 0;
  SwitchEdge edge;
  while (switches_.take_edge(edge)) opened = opened || edge.open || !edge.lost;
  if (opened) {
    latch(ErrorCode::kResetWhileArmed);
  } else if (now - resume_since_ >= kDebounceTicks) {
    resuming_ = false;
    begin_watch(now);
    enter(SequencerState::kArmed);
  }
}

// In a run, too: the robot may turn out to hang.
void Sequencer::watch_switches(tick_t now) {
  take_edges(now);
  // Makes whoever gave up look again, and say from when on: before anything is judged by the time.
  const uint8_t levels = switches_.levels();
  take_edges(now);
  heed(detector_.poll(now, levels), now);
  retained_.set(retained_.knocks, detector_.knocks());
  if (state_ == SequencerState::kRunning) watch_run(now);
}

void Sequencer::take_edges(tick_t now) {
  SwitchEdge edge;
  while (switches_.take_edge(edge)) heed(detector_.on_edge(edge), now);
}

void Sequencer::heed(ReleaseDetector::Verdict verdict, tick_t now) {
  if (verdict == ReleaseDetector::Verdict::kReleased && state_ == SequencerState::kArmed) {
    begin_run(detector_.released_at());
  } else if (verdict == ReleaseDetector::Verdict::kFalseRelease &&
             state_ == SequencerState::kRunning) {
    end_false_run(now);
  }
}

// Before the first stroke nothing has moved: armed as before. After it, only a person knows what the
// robot hangs on, and where its joints may go.
void Sequencer::end_false_run(tick_t now) {
  const bool begins = servos_.cancel();
  note_strokes(servos_.changes_begun(), true);
  if (retained_.false_releases != UINT16_MAX) {
    retained_.set(retained_.false_releases, static_cast<uint16_t>(retained_.false_releases + 1));
  }
  const uint32_t first_us = maneuvers_.current().strokes[0].start_us;
  if (begins || strokes_started_ > 0 || !tick_before(now, released_at_ + ticks_from_us(first_us))) {
    latch(ErrorCode::kClosedWhileRunning);
    return;
  }
  hold_start_pose();
  retained_.run.clear();
  enter(SequencerState::kArmed);
}

// The whole schedule goes to the servo driver at once: from here on, hardware and its interrupts
// place the pulses, and nothing that the main loop does or suffers can move them. Change i is stroke i.
void Sequencer::begin_run(tick_t released_at) {
  released_at_ = released_at;
  const Maneuver& maneuver = maneuvers_.current();
  for (uint8_t i = 0; i < maneuver.stroke_count; ++i) {
    const Stroke& stroke = maneuver.strokes[i];
    const int16_t target = maneuver.angle_before(static_cast<uint8_t>(i + 1), stroke.joint);
    servos_.schedule(static_cast<uint8_t>(stroke.joint - 1),
                     released_at + ticks_from_us(stroke.start_us),
                     settings_.current().pulse_ticks(stroke.joint, target));
  }
  retained_.run.clear();
  RunReportReply& report = retained_.run.report;
  report.released = 1;
  report.stroke_count = maneuver.stroke_count;
  report.bounces = detector_.bounces();
  note_release_time();
  enter(SequencerState::kRunning);
}

// The edge lies before the present millisecond began: a debounce at least, and the chatter at most.
void Sequencer::note_release_time() {
  const uint32_t before_us = us_from_ticks(last_ms_ - released_at_);
  const uint32_t whole_ms = (before_us + 999) / 1000;
  retained_.run.report.release_ms = uptime_ms_ - whole_ms;
  retained_.run.report.release_us = static_cast<uint16_t>(whole_ms * 1000 - before_us);
  retained_.run.seal();
}

// Contacts that go on bouncing after the release was believed may make it less certain.
void Sequencer::note_release_interval() {
  static_assert(offsetof(RunReportReply, later_us) == offsetof(RunReportReply, earlier_us) + 4,
                "written as one");
  const uint32_t interval_us[] = {us_from_ticks(detector_.earlier_ticks()),
                                  us_from_ticks(detector_.later_ticks())};
  retained_.set(retained_.run.report.earlier_us, interval_us);
}

// A stroke that has not begun by the end will not begin any more: its servo stays where it is.
void Sequencer::watch_run(tick_t now) {
  note_strokes(servos_.changes_begun(), true);
  note_release_interval();
  const Maneuver& maneuver = maneuvers_.current();
  if (tick_before(now, released_at_ + ticks_from_us(maneuver.end_us() + kLastPulseUs))) return;
  if (strokes_started_ == maneuver.stroke_count) {
    enter(SequencerState::kDone);
  } else {
    servos_.cancel();
    latch(ErrorCode::kStrokeMissed);
  }
}

// `begun`: bit i is stroke i. The angle first: what is in the report counts as noted. `timed`: the
// driver knows when they began.
void Sequencer::note_strokes(uint16_t begun, bool timed) {
  const Maneuver& maneuver = maneuvers_.current();
  strokes_started_ = 0;
  for (uint8_t i = 0; i < maneuver.stroke_count; ++i, begun >>= 1) {
    const uint32_t& start_us = retained_.run.report.start_us[i];
    if ((begun & 1) != 0 && start_us == kStrokeNotBegunUs) {
      const uint8_t joint = maneuver.strokes[i].joint;
      note_held(joint, maneuver.angle_before(static_cast<uint8_t>(i + 1), joint));
      retained_.set(start_us, timed ? us_from_ticks(servos_.change_began_at(i) - released_at_)
                                    : +kStrokeTimeUnknownUs);
    }
    if (start_us != kStrokeNotBegunUs) ++strokes_started_;
  }
}

ErrorCode Sequencer::jog(const JogRequest& request) {
  if (request.confirm != kJogConfirm) return ErrorCode::kJogNotConfirmed;
  if (request.joint < 1 || request.joint > kJointCount) return ErrorCode::kJointUnknown;
  const bool going_on = state_ == SequencerState::kJogging && request.joint == jog_.joint();
  if (!going_on && (!may_upload() || storing())) return ErrorCode::kWrongState;
  // Other settings than those last committed would drive the joint from where it stands at full speed.
  if (settings_.defect() != ErrorCode::kNone) return settings_.defect();
  const Settings& settings = settings_.current();
  if (!settings.allows(request.joint, request.to_cdeg) ||
      (!going_on && !settings.allows(request.joint, request.from_cdeg))) {
    return ErrorCode::kAngleOutOfRange;
  }
  if (!going_on) {
    jog_.start(request.joint, request.from_cdeg, uptime_ms_);
    hold(request.joint, request.from_cdeg);
    enter(SequencerState::kJogging);
  }
  jog_.go_to(request.to_cdeg, uptime_ms_);
  return ErrorCode::kNone;
}

void Sequencer::watch_jog() {
  if (jog_.idle(uptime_ms_)) {
    disarm();
  } else if (jog_.advance(uptime_ms_)) {
    hold(jog_.joint(), jog_.angle_cdeg());
  }
}

void Sequencer::host_gone() {
  if (state_ == SequencerState::kJogging) disarm();
}

}  // namespace sequencer
}  // namespace tfsat
