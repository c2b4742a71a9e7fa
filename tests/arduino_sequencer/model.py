"""What the sequencer must answer and become, request by request, in time; written from the protocol's words."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.arduino_sequencer.maneuvers import RawManeuver, defect
from tests.arduino_sequencer.servo_model import FACTORY_SETTINGS, settings_defect, width_ns
from tests.arduino_sequencer.store_model import Store
from tfsat_host.protocol.enums import ErrorCode, Origin, SequencerState
from tfsat_host.protocol.framing import crc16
from tfsat_host.protocol.limits import (
    JOG_CONFIRM,
    JOG_IDLE_MS,
    JOG_SPEED_CDEG_S,
    JOINT_REPORT_AGE_MS,
    RELEASE_SEATED_US,
    SERVO_PULSE_MAX_US,
    START_POSE_TOLERANCE_CDEG,
)
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    DisarmReply,
    DisarmRequest,
    ErrorReply,
    JogReply,
    JogRequest,
    JointReportReply,
    JointReportRequest,
    ManeuverBeginReply,
    ManeuverBeginRequest,
    ManeuverCommitReply,
    ManeuverCommitRequest,
    ManeuverStrokeReply,
    ManeuverStrokeRequest,
    SettingsWriteReply,
    SettingsWriteRequest,
)
from tfsat_host.protocol.record import Payload

SAFE, ARMED, RUNNING, DONE, FAULT, JOGGING = SequencerState
JOINTS = (1, 2, 3)
NEVER_US = 1 << 62
LAST_PULSE_US = SERVO_PULSE_MAX_US + 1000


@dataclass
class Jog:
    """A joint on its way; time is the board's, microseconds."""

    joint: int
    from_cdeg: int
    since_us: int
    to_cdeg: int
    ordered_us: int

    def angle_cdeg(self, now_us: int) -> int:
        way_cdeg = self.to_cdeg - self.from_cdeg
        # Whole hundredths of a degree, as the board counts them.
        gone_cdeg = min(abs(way_cdeg), (now_us - self.since_us) * JOG_SPEED_CDEG_S // 1_000_000)
        return self.from_cdeg + (gone_cdeg if way_cdeg > 0 else -gone_cdeg)

    @property
    def ends_us(self) -> int:
        return self.ordered_us + 1000 * JOG_IDLE_MS


@dataclass
class Model:
    """What the board must hold and be in."""

    maneuver: Store[RawManeuver]
    settings: Store[SettingsWriteRequest] = field(default_factory=lambda: Store(FACTORY_SETTINGS))
    state: SequencerState = SAFE
    fault: ErrorCode = ErrorCode.NONE
    resets: int = 0
    held_cdeg: tuple[int, ...] = ()
    token: int = 0
    accepted_token: int = 0
    refusal: ErrorCode = ErrorCode.NONE
    knocks: int = 0
    touched: bool = False
    false_releases: int = 0
    run_from_us: int = 0
    closed_from_us: int | None = None
    jogged: Jog | None = None
    reported: tuple[tuple[int, ...], int] | None = None
    staged: tuple[int, int] | None = None
    strokes: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    maneuver_written: bool = False
    staged_settings: SettingsWriteRequest | None = None
    settings_written: bool = False

    # ------------------------------------------------------------------ what happens to the board

    def restart(self, *, power_lost: bool, opened: int, now_us: int) -> None:
        """Restart the model: the EEPROM stays, and RAM keeps the state unless the power was lost."""
        fresh = Model(self.maneuver, self.settings)
        # After a restart the EEPROM alone tells what is stored.
        self.maneuver.load()
        self.settings.load()
        if not power_lost and self.state in (ARMED, RUNNING, FAULT):
            fresh.resets, fresh.held_cdeg, fresh.knocks = self.resets, self.held_cdeg, self.knocks
            fresh.false_releases = self.false_releases
            fresh.state, fresh.fault = FAULT, self.fault
            if self.state == RUNNING:
                fresh.fault = ErrorCode.RESET_WHILE_RUNNING
                # Strokes that had begun: their joints are held where these took them.
                fresh.held_cdeg = self.angles_cdeg(self.strokes_begun(now_us))
            elif self.state == ARMED:
                fresh.resets += 1
                fresh.held_cdeg = (0, 0, 0)
                # A switch that opened during the reset may have been the release: nobody can tell.
                fresh.fault = ErrorCode.RESET_WHILE_ARMED if opened else ErrorCode.NONE
                fresh.state = FAULT if opened else ARMED
        self.__dict__.update(fresh.__dict__)

    def switches_stand(self, opened: int, moved_us: int) -> bool:
        """Update the state once the switches have been still for the debounce; return whether it is a release."""
        if self.state != ARMED:
            return False
        # Touched: a switch opened, which becomes a knock if both close again.
        self.touched |= opened != 0
        if opened == 3:
            self.state, self.run_from_us, self.touched = RUNNING, moved_us, False
            return True
        if opened == 0 and self.touched:
            self.touched = False
            self.knocks += 1
        return False

    def hangs_us(self) -> int:
        """Return the time at which both switches will have been closed long enough to revoke a release."""
        return NEVER_US if self.closed_from_us is None else self.closed_from_us + RELEASE_SEATED_US

    def end_false_run(self) -> None:
        """End a run as a false release, after both switches have been closed for long."""
        # A stroke may have begun before both switches were closed for long enough.
        begun = self.strokes_begun(self.hangs_us())
        self.state, self.fault = (FAULT, ErrorCode.CLOSED_WHILE_RUNNING) if begun else (ARMED, self.fault)
        self.held_cdeg = self.angles_cdeg(begun)
        self.false_releases += 1

    def end_jog(self) -> None:
        if self.state == JOGGING:
            self.state, self.jogged = SAFE, None

    @property
    def storing(self) -> bool:
        """The EEPROM does one thing at a time."""
        return self.maneuver.busy or self.settings.busy

    # ------------------------------------------------------------------ what follows from the maneuver

    def run_ends_us(self) -> int:
        """Return the time at which the last stroke and its first pulse are over, however short the stroke."""
        return self.run_from_us + max(self.arrivals_us()) + LAST_PULSE_US

    def arrivals_us(self) -> list[int]:
        """Return when each stroke ends after the release, rounded up as the board does."""
        record = self.maneuver.record
        return [
            start_us - (-abs(angle_cdeg) * 1_000_000 // record.speed_cdeg_s)
            for _, angle_cdeg, start_us in record.strokes
        ]

    def most_moving(self) -> int:
        """Return how many joints move at the same time at the most."""
        arrivals_us = self.arrivals_us()
        starts_us = [start_us for _, _, start_us in self.maneuver.record.strokes]
        return max(
            1 + sum(arrival_us > start_us for arrival_us in arrivals_us[:index])
            for index, start_us in enumerate(starts_us)
        )

    def strokes_begun(self, now_us: int) -> int:
        starts_us = [self.run_from_us + start_us for _, _, start_us in self.maneuver.record.strokes]
        return sum(start_us <= now_us for start_us in starts_us)

    def angles_cdeg(self, strokes: int) -> tuple[int, ...]:
        """Return the angle of each joint after the first `strokes` strokes."""
        first_strokes = self.maneuver.record.strokes[:strokes]
        return tuple(
            sum(angle for joint, angle, _ in first_strokes if joint == joint_number)
            for joint_number in JOINTS
        )

    def held_ns(self) -> tuple[int, ...]:
        """Pulse widths that hold the joints where a reset found them; none for a board that is limp."""
        servos = zip(self.settings.record.servo, self.held_cdeg, strict=False)
        return tuple(width_ns(servo, angle) for servo, angle in servos)

    def allows_angle(self, joint: int, angle_cdeg: int) -> bool:
        servo = self.settings.record.servo[joint - 1]
        return servo.min_cdeg <= angle_cdeg <= servo.max_cdeg

    def fits_settings(self) -> bool:
        counts = range(len(self.maneuver.record.strokes) + 1)
        return all(
            self.allows_angle(joint, angle)
            for count in counts
            for joint, angle in zip(JOINTS, self.angles_cdeg(count), strict=True)
        )

    # ------------------------------------------------------------------ requests

    def answer(self, request: Payload, opened: int, now_us: int) -> Payload:
        """Return the reply that `request` must get, and apply its effects to the model."""
        match request:
            case ArmRequest():
                return self.arm(request, opened, now_us)
            case DisarmRequest():
                self.state, self.fault, self.resets, self.jogged = SAFE, ErrorCode.NONE, 0, None
                return DisarmReply(SAFE)
            case JointReportRequest():
                self.reported = (request.angle_cdeg, now_us)
                return JointReportReply(int(self.at_start_pose()))
            case JogRequest():
                return self.jog(request, now_us)
            case SettingsWriteRequest():
                return self.write_settings(request)
        return self.upload(request)

    def error(self, request: Payload, code: ErrorCode, detail: int = -1) -> ErrorReply:
        return ErrorReply(request.TYPE, code, detail)

    def at_start_pose(self) -> bool:
        return self.reported is None or max(map(abs, self.reported[0])) <= START_POSE_TOLERANCE_CDEG

    def report_ends_us(self) -> int:
        return 0 if self.reported is None else self.reported[1] + 1000 * JOINT_REPORT_AGE_MS

    def arm(self, request: ArmRequest, opened: int, now_us: int) -> Payload:
        # A repeated ARM with the accepted token is the answer that got lost.
        if self.state == ARMED and request.arm_token == self.accepted_token:
            return ArmReply(ARMED)
        self.refusal = self.reason_not_to_arm(request, opened, now_us)
        if self.refusal != ErrorCode.NONE:
            return self.error(request, self.refusal, opened)
        self.state, self.accepted_token = ARMED, request.arm_token
        self.knocks, self.touched, self.resets, self.false_releases = 0, False, 0, 0
        return ArmReply(ARMED)

    def reason_not_to_arm(self, request: ArmRequest, opened: int, now_us: int) -> ErrorCode:
        # The order of these checks is the protocol's: the first reason is the one that is told.
        if self.state == FAULT:
            return ErrorCode.FAULT_LATCHED
        if self.state not in (SAFE, DONE) or self.storing:
            return ErrorCode.WRONG_STATE
        if request.arm_token != self.token:
            return ErrorCode.STALE_TOKEN
        if self.maneuver.defect or self.settings.defect:
            return self.maneuver.defect or self.settings.defect
        if self.maneuver.origin == Origin.FACTORY:
            return ErrorCode.NO_MANEUVER
        if self.most_moving() > max(1, self.settings.record.moving_at_once):
            return ErrorCode.TOO_MANY_MOVING
        if not self.fits_settings():
            return ErrorCode.SETTINGS_DO_NOT_FIT
        if opened:
            return ErrorCode.SWITCH_OPEN
        # A run that ended away from the start pose would snap back when armed.
        held_cdeg = self.angles_cdeg(len(self.maneuver.record.strokes)) if self.state == DONE else (0,)
        if max(held_cdeg) > START_POSE_TOLERANCE_CDEG:
            return ErrorCode.NOT_AT_START_POSE
        fresh = now_us < self.report_ends_us()
        return ErrorCode.NOT_AT_START_POSE if fresh and not self.at_start_pose() else ErrorCode.NONE

    def jog(self, request: JogRequest, now_us: int) -> Payload:
        joint = request.joint
        if request.confirm != JOG_CONFIRM:
            return self.error(request, ErrorCode.JOG_NOT_CONFIRMED, joint)
        if joint not in JOINTS:
            return self.error(request, ErrorCode.JOINT_UNKNOWN, joint)
        jogged = self.jogged
        if (self.state != SAFE or self.storing) if jogged is None else jogged.joint != joint:
            return self.error(request, ErrorCode.WRONG_STATE, joint)
        if self.settings.defect:
            return self.error(request, self.settings.defect, joint)
        # A jog under way knows where it is: only its new end is checked.
        ends = [request.to_cdeg] if jogged else [request.to_cdeg, request.from_cdeg]
        if not all(self.allows_angle(joint, angle) for angle in ends):
            return self.error(request, ErrorCode.ANGLE_OUT_OF_RANGE, joint)
        from_cdeg = jogged.angle_cdeg(now_us) if jogged else request.from_cdeg
        self.state, self.jogged = JOGGING, Jog(joint, from_cdeg, now_us, request.to_cdeg, now_us)
        return JogReply(from_cdeg, int(from_cdeg == request.to_cdeg))

    def write_settings(self, request: SettingsWriteRequest) -> Payload:
        if self.state != SAFE:
            return self.error(request, ErrorCode.WRONG_STATE)
        wrong = settings_defect(request)
        if wrong is not None:
            return self.error(request, ErrorCode.SETTING_OUT_OF_RANGE, wrong)
        # The same settings again: a repetition of a lost answer, not a new write.
        if request != self.staged_settings:
            if self.settings.busy:
                return self.error(request, ErrorCode.WRONG_STATE)
            self.staged_settings, self.settings_written = request, False
        if not self.storing:
            self.settings_written |= self.settings.store_record(request)
        return SettingsWriteReply(int(not self.storing), int(self.settings_written))

    def upload(self, request: Payload) -> Payload:
        # A commit is repeated until the store is written, so that it alone is allowed while storing.
        busy = self.maneuver.busy and not isinstance(request, ManeuverCommitRequest)
        if self.state != SAFE or busy:
            return self.error(request, ErrorCode.WRONG_STATE)
        if isinstance(request, ManeuverBeginRequest):
            return self.begin(request)
        if self.staged is None:
            return self.error(request, ErrorCode.NO_STAGED_MANEUVER)
        if isinstance(request, ManeuverStrokeRequest):
            if request.index >= self.staged[0]:
                return self.error(request, ErrorCode.INDEX_OUT_OF_RANGE, request.index)
            self.strokes[request.index] = (request.joint, request.angle_cdeg, request.start_us)
            return ManeuverStrokeReply(request.index)
        assert isinstance(request, ManeuverCommitRequest)
        return self.commit(request, self.staged)

    def begin(self, request: ManeuverBeginRequest) -> Payload:
        if not 1 <= request.stroke_count <= 16:
            return self.error(request, ErrorCode.TOO_MANY_STROKES, request.stroke_count)
        self.staged, self.strokes = (request.stroke_count, request.speed_cdeg_s), {}
        self.maneuver_written = False
        self.maneuver.begin()
        return ManeuverBeginReply(request.stroke_count)

    def commit(self, request: ManeuverCommitRequest, staged: tuple[int, int]) -> Payload:
        # Strokes may come in any order: only missing ones are refused.
        missing = [index for index in range(staged[0]) if index not in self.strokes]
        if missing:
            return self.error(request, ErrorCode.STEP_MISSING, missing[0])
        raw = RawManeuver(staged[1], tuple(self.strokes[index] for index in range(staged[0])))
        if request.crc != crc16(raw.canonical()):
            return self.error(request, ErrorCode.CRC_MISMATCH)
        code, detail = defect(raw)
        if code != ErrorCode.NONE:
            return self.error(request, code, detail)
        if not self.storing:
            self.maneuver_written |= self.maneuver.store_record(raw)
        return ManeuverCommitReply(int(not self.storing), int(self.maneuver_written))
