"""The result of one rehearsal: declared once for `--json`, `summary.json` and the terminal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, nan
from pathlib import Path

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.error_columns import error_columns
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.quick_look import QuickLook, disagreements, quick_look, reached_deg
from tfsat_host.evaluation.result.drop_result import JOINTS, STROKES, joints
from tfsat_host.exit_code import ExitCode
from tfsat_host.maneuver import Schedule
from tfsat_host.maneuver.schedule import STROKES as SCHEDULED
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import Notices
from tfsat_host.preflight.preflight_check import CHECK
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.rehearsal.day import DROPPED, NoGo
from tfsat_host.rehearsal.judgement import JUDGED_FAULT, JudgedDay, moved_deg, outcome_missed
from tfsat_host.rehearsal.rehearsed_drop import HOOK_S, Drop
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.rehearsal.truth_comparison import COMPARED, EstimateAndTruth, compare_with_truth, turned_rad
from tfsat_host.robot import RobotModel
from tfsat_host.run.drop_evaluation import EvaluatedRun
from tfsat_host.run.files import MANEUVER, PREFLIGHT, ROBOT
from tfsat_host.sdlog import DropLog
from tfsat_host.units import s_from_us

LOOK_MARGIN_S = 0.05
"""What is looked at ends this long before the landing."""


@dataclass(frozen=True, slots=True)
class SwitchRecord:
    """What the recording holds of one release switch.

    Attributes:
        switch: From 1.
        edges_s: Times at which it changed.
        open_at_the_end: Its state in the last sample.
    """

    switch: int
    edges_s: tuple[float, ...]
    open_at_the_end: bool


@dataclass(frozen=True, slots=True)
class MissingRelease:
    """A fall whose recording holds no release.

    Attributes:
        hook_min: Time on the crane's hook.
        fall_s: Time of the fall.
        joints_moved_true_deg: (3,) by the truth.
        strokes_started: By the sequencer; None: no board knows.
        recording_ended_before_release_s: So long before it the recording breaks off; None: it holds that time.
        switches: Of the recording; empty without one.
    """

    hook_min: float
    fall_s: float
    joints_moved_true_deg: FloatArray
    strokes_started: int | None
    recording_ended_before_release_s: float | None
    switches: tuple[SwitchRecord, ...]


@dataclass(frozen=True, slots=True)
class UncalibratedMotion:
    """The motion of a drop that cannot be evaluated: no calibration, no standard deviations.

    Attributes:
        strokes_deg: Change of the moved joint in each scheduled stroke; NaN where the log lacks it.
        look: Joints and body 1.
    """

    strokes_deg: FloatArray
    look: QuickLook


@dataclass(frozen=True, eq=False)
class RehearsalResult:
    """What came of a rehearsal.

    Attributes:
        sequencer: Its firmware: `native` or `avr`.
        as_filed: The robot was exactly what its file says.
        schedule: What was to be flown.
        filed: The robot as its file has it.
        judged: The day, its recording, what was evaluated, who detected its faults.
        evaluated: The drop as `Run.evaluate` gives it; None: there was nothing to evaluate, or it was refused.
        quick_look: In place of an evaluation; None: there is one, or nothing to look at.
        folder: The run's.
        files: That were written.
    """

    sequencer: str
    as_filed: bool
    schedule: Schedule
    filed: RobotModel
    judged: JudgedDay
    evaluated: EvaluatedRun | None
    quick_look: UncalibratedMotion | None
    folder: Path
    files: tuple[Path, ...]

    @property
    def drop(self) -> Drop:
        """The day."""
        return self.judged.drop

    @property
    def log(self) -> DropLog | None:
        """The recording, decoded."""
        return self.judged.log

    @property
    def truth(self) -> Truth:
        """The robot that flew: as it was drawn, and what faults made of it."""
        return self.drop.robot

    @property
    def preflight_go(self) -> bool | None:
        """Whether the preflight says GO; None: there was none."""
        return None if self.drop.preflight is None else self.drop.preflight.go

    @property
    def refused_by_preflight(self) -> bool:
        """Whether a NO-GO kept the robot from being dropped."""
        return isinstance(self.drop.refused, NoGo)

    @property
    def initial_rate_deg_s(self) -> list[float]:
        """(3,) true rate of body 3 at the release, its axes."""
        rates: list[float] = np.rad2deg(self.truth.rate_rad_s).round(6).tolist()
        return rates

    @property
    def logged_flight(self) -> DropLog | None:
        """The recording of a fall, if it holds the release."""
        fell = self.drop.released_s is not None
        return self.log if fell and self.log is not None and self.log.release_us is not None else None

    @property
    def true_until_s(self) -> float | None:
        """Time after the release until which the truth is taken; None: no logged flight."""
        if self.logged_flight is None:
            return None
        # Stop short of the landing, whose shock would count as rotation.
        return self.drop.fall_s - LOOK_MARGIN_S

    @cached_property
    def true_turn_deg(self) -> float | None:
        """Angle by which body 1 truly turned until `true_until_s`."""
        if self.true_until_s is None:
            return None
        released_s = self.drop.released_s or 0.0
        return float(np.rad2deg(turned_rad(self.drop.truth, released_s, released_s + self.true_until_s)))

    @property
    def strokes_s(self) -> list[float]:
        """Times of the logged strokes after the release."""
        log = self.logged_flight
        return (
            [] if log is None else [log.seconds(event.t_us) for event in log.events if event.name == "stroke"]
        )

    @property
    def simulate_command(self) -> Advice | None:
        """What computes the same drop of the nominal robot, until the moment at which the truth is taken."""
        if self.true_until_s is None:
            return None
        # `simulate` follows the joints to their rest.
        until_s = max(self.true_until_s, s_from_us(self.schedule.end_us))
        maneuver, robot = (str(self.folder / name) for name in (MANEUVER, ROBOT))
        rates = [f"{rate:g}" for rate in self.initial_rate_deg_s]
        start = ("--file", maneuver, "--initial-rate", *rates)
        return Advice(NextStep("simulate", (*start, "--until", f"{until_s:.3f}", "--robot", robot)))

    @cached_property
    def missing_release(self) -> MissingRelease | None:
        """What the robot did in a fall whose recording holds no release; None: nothing fell, or it holds one."""
        if self.drop.released_s is None or self.logged_flight is not None:
            return None
        drop, log = self.drop, self.log
        return MissingRelease(
            HOOK_S / 60.0,
            drop.fall_s,
            moved_deg(drop),
            _strokes_started(drop),
            _ended_before_release_s(drop, log),
            ()
            if log is None or not len(log)
            else tuple(_switch(log, index) for index in range(SWITCH_COUNT)),
        )

    @cached_property
    def compared(self) -> tuple[EstimateAndTruth, ...]:
        """Each number of the evaluation that has a truth."""
        evaluation = self.judged.evaluation
        return () if evaluation is None else compare_with_truth(evaluation, self.drop)

    @cached_property
    def warnings(self) -> list[str]:
        """Strokes that were not as commanded, by the evaluation, or by the quick look if there is none."""
        commanded_deg = [stroke.angle_deg for stroke in self.schedule.strokes]
        evaluation = self.judged.evaluation
        if evaluation is not None:
            # Strokes that are withheld, the verdict says.
            sizes = (
                np.rad2deg([stroke.size_rad for stroke in evaluation.strokes])
                if evaluation.is_given()
                else np.array(commanded_deg)
            )
        elif self.quick_look is not None:
            sizes = self.quick_look.strokes_deg
        else:
            return []
        return disagreements(
            [stroke.t_s for stroke in self.schedule.strokes],
            self.strokes_s,
            commanded_deg,
            [size if isfinite(size) else nan for size in sizes],
        )

    @property
    def exit_code(self) -> int:
        """0 if all went as planned; 4: the preflight kept the robot from being dropped; else 3."""
        if self.drop.refused is not None and self.preflight_go is False:
            return ExitCode.REFUSED
        # What the evaluation finds good may still be wrong by the truth, or by the strokes commanded.
        by_design = not self.warnings and not outcome_missed(self.drop)
        complete = self.log is not None and self.log.verdict == "complete"
        return 0 if self.judged.good and complete and by_design else ExitCode.DATA_LOSS


def schedule_notices(schedule: Schedule) -> tuple[str, ...]:
    """List the notices about a schedule that a person should read before it flies."""
    return (*schedule.notices, *servo_speed_notices(schedule))


def _refusal_text(result: RehearsalResult) -> str | None:
    error = result.drop.refused
    return None if error is None else f"{error.what} {error.meaning} {error.next_step}"


def _preflight_text(result: RehearsalResult) -> str | None:
    return None if result.preflight_go is None else "go" if result.preflight_go else "no-go"


def _choose(columns: Columns, keys: str) -> Columns:
    return tuple(column for column in columns if column.key in keys.split())


_EVALUATION: Columns = (
    *fields("level=verdict.level sentence=verdict.sentence reasons=verdict.reasons"),
    Column("reorientation_deg", of="found.reorientation.angle_rad", std="found.reorientation.std_rad"),
    Column("until_s", of=lambda run: float(run.found.motion.t_s[-1])),
    Column(
        "strokes",
        of="found.strokes",
        columns=_choose(STROKES, "stroke joint scheduled_s logged_s commanded_deg size_deg remark"),
    ),
    Column(
        "joints",
        of=lambda run: joints(run.found),
        columns=_choose(JOINTS, "joint initial_deg final_deg sensed"),
    ),
)
_MISSING_RELEASE: Columns = (
    *fields("hook_min fall_s joints_moved_true_deg strokes_started recording_ended_before_release_s"),
    Column("switches", columns=fields("switch edges_s open_at_the_end")),
)
_QUICK_LOOK = fields(
    "strokes_deg joint_change_deg=look.joint_change_deg reorientation_deg=look.reorientation_deg "
    "until_s=look.until_s"
)
REHEARSAL: Columns = (
    *fields("sequencer as_filed"),
    Column("schedule", of="schedule.strokes", columns=SCHEDULED),
    *fields("end_s=schedule.end_s seed=truth.seed"),
    Column("robot", of="filed", columns=fields("name file=path")),
    Column("imu", of=lambda result: result.truth.imu or None),
    Column("faults", of="judged.faults", columns=JUDGED_FAULT),
    Column("notices", of=lambda result: schedule_notices(result.schedule)),
    # The day until the drop, and the sequencer after it.
    Column("verified", of=lambda result: result.drop.upload is not None),
    Column("preflight", of=_preflight_text),
    Column(
        "preflight_file", of=lambda result: None if result.preflight_go is None else result.folder / PREFLIGHT
    ),
    Column("no_go", of=lambda result: [check.name for check in result.drop.blocking]),
    Column("no_go_checks", of="drop.blocking", columns=CHECK),
    Column("refused", of=_refusal_text),
    Column(
        "refused_by",
        of=lambda result: result.drop.refused and ("preflight" if result.refused_by_preflight else "board"),
    ),
    *fields("setbacks=drop.setbacks"),
    *fields("sequencer_state=drop.sequencer.state knocks=drop.sequencer.knocks"),
    *fields("false_releases=drop.sequencer.false_releases"),
    # The flight: recording and truth.
    *fields("initial_rate_deg_s"),
    Column("initial_rate_body", of=lambda _: 3),
    *fields("simulate_command"),
    *fields("verdict=log.verdict"),
    Column("recording_from", of=lambda result: "ram" if result.drop.from_ram else "card"),
    Column("samples", of=lambda result: 0 if result.log is None else len(result.log)),
    *fields("samples_lost=log.samples_lost rate_hz=log.rate_hz"),
    *fields("strokes_s reorientation_true_deg=true_turn_deg reorientation_true_until_s=true_until_s"),
    Column("no_release", of="missing_release", columns=_MISSING_RELEASE),
    # The evaluation, and the truth next to it.
    Column("evaluation", of="evaluated", columns=_EVALUATION),
    Column("evaluation_refused", of="judged.refusal", columns=error_columns),
    Column("compared", columns=COMPARED),
    Column("quick_look", columns=_QUICK_LOOK),
    *fields("warnings files"),
)
"""The object of `rehearse --json`, which `summary.json` keeps, of a `RehearsalResult`."""


def with_quick_look(result: RehearsalResult, notices: Notices) -> RehearsalResult:
    """Return the result with what the log shows without calibration, if the drop has no evaluation.

    Warns where that fails, too.
    """
    log = result.logged_flight
    if result.evaluated is not None or log is None or result.drop.refused is not None:
        return result
    strokes = result.schedule.strokes
    starts_s, moved_joints = [stroke.t_s for stroke in strokes], [stroke.joint for stroke in strokes]
    length_s = result.drop.fall_s
    try:
        look = quick_look(log, result.filed, until_s=length_s - LOOK_MARGIN_S)
        sizes = reached_deg(log, result.filed, moved_joints, starts_s, length_s)
    except TfsatError as error:
        notices.warn(f"No quick look either. {error.what} {error.meaning}")
        return result
    return replace(result, quick_look=UncalibratedMotion(sizes, look))


def _switch(log: DropLog, index: int) -> SwitchRecord:
    edges = (event for event in log.events if (event.name, event.index) == ("switch_edge", index))
    edges_s = tuple(log.seconds(event.t_us) for event in edges)
    return SwitchRecord(index + 1, edges_s, bool(log.switch_open[-1, index]))


def _strokes_started(drop: Drop) -> int | None:
    """Return the number of strokes started, by the sequencer.

    None: it does not respond, or it restarted since the release and knows of no run.
    """
    if drop.sequencer is None or drop.released_s is None:
        return None
    started = drop.sequencer.strokes_started
    now_s = (drop.collected - DROPPED).total_seconds()
    # Up for a shorter time than since the release: its counter of strokes began again at 0.
    restarted = drop.sequencer.uptime_ms / 1000.0 < now_s - drop.released_s
    return None if restarted and started == 0 else started


def _ended_before_release_s(drop: Drop, log: DropLog | None) -> float | None:
    """Compute how long before the release, in s, a recording without an end breaks off.

    None: the recording holds the time of the release, or it is complete.
    """
    if log is None or log.footer is not None or not len(log) or not len(drop.truth):
        return None
    length_s = float(log.t_us[-1] - log.t_us[0]) / 1e6
    # Truth and recording begin together: the first time of one plus the length of the other is its end.
    before_s = (drop.released_s or 0.0) - (float(drop.truth[0, 0]) + length_s)
    return before_s if before_s > 0.0 else None
