"""A designed maneuver against what flies it: the sequencer's rules, the servos, the drop tower's checks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, schedule_maneuver
from tfsat_host.maneuver.schedule import STROKES as SCHEDULED
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.collisions import CONTACT_MM, least_gap
from tfsat_host.plan.facility import load_tower
from tfsat_host.plan.reach_envelope import EnvelopeError, envelope_of
from tfsat_host.plan.tower_checks import CHECK, Check, TowerReport, check_maneuver
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class CheckedManeuver:
    """A maneuver and what is known of flying it.

    Attributes:
        robot: For whom.
        maneuver: To be written.
        path: Where it is written.
        schedule: Its times; None if no sequencer commands the robot, or it would refuse.
        refusal: Why it would.
        tower: Against the drop tower; None without a schedule or without outlines.
        notices: What else a person should know.
        collision: Which bodies strike one another on the way, a sentence; empty: none do.
    """

    robot: RobotModel
    maneuver: Maneuver
    path: Path
    schedule: Schedule | None = None
    refusal: str = ""
    tower: TowerReport | None = None
    notices: tuple[str, ...] = ()
    collision: str = ""

    @property
    def failed(self) -> list[Check]:
        """The checks that did not pass."""
        return [] if self.tower is None else self.tower.failed

    @property
    def may_fly(self) -> bool:
        """Whether nothing that was checked speaks against a flight."""
        return not (self.failed or self.collision)


def check_design(robot: RobotModel, maneuver: Maneuver, path: Path) -> CheckedManeuver:
    """Check a maneuver that is to be written to `path` by the sequencer's rules and in the drop tower."""
    checked = CheckedManeuver(robot, maneuver, path)
    # Without pulses in the robot file no board flies it: neither sequencer nor drop tower matters.
    if not robot.has_sequencer:
        return checked
    try:
        schedule = schedule_maneuver(maneuver)
    except ManeuverError as error:
        # A refused design is still shown and written, with the reason.
        return replace(checked, refusal=error.what)
    checked = replace(checked, schedule=schedule, notices=servo_speed_notices(schedule, robot.path))
    tower = load_tower()
    try:
        envelope = envelope_of(robot, schedule, until_s=tower.fall_s)
    except EnvelopeError as error:
        # Without outlines the reach is unknown: that is a notice, not a failed check.
        return replace(
            checked, notices=(*checked.notices, f"Not checked against the drop tower: {error.what}")
        )
    checks = check_maneuver(schedule, robot, tower, envelope)
    checked = replace(checked, tower=TowerReport(schedule, robot, tower, envelope, checks))
    gap = least_gap(robot, envelope.angles_rad)
    if gap.gap_mm >= -CONTACT_MM:
        return checked
    collision = (
        f"{' and '.join(gap.bodies)} collide {envelope.t_s[gap.instant]:.2f} s after release: their boxes in "
        f"{robot.path.name} overlap by {-gap.gap_mm:.1f} mm."
    )
    return replace(checked, notices=(*checked.notices, collision), collision=collision)


def _format_file(checked: CheckedManeuver) -> str:
    if checked.schedule is None:
        return str(checked.path)
    return f"{checked.path} (ends {checked.schedule.end_s:.2f} s after release)"


CHECKED: Columns = (
    Column("file", "Written", of="path", words=_format_file),
    Column("schedule", of="schedule.strokes", columns=SCHEDULED),
    *fields("end_s=schedule.end_s"),
    Column("sequencer_refuses", of=lambda checked: checked.refusal or None),
    Column("checks", of=lambda checked: () if checked.tower is None else checked.tower.checks, columns=CHECK),
    *fields("notices"),
)


def verdict_and_next_step(checked: CheckedManeuver, robot_option: tuple[str, ...]) -> Iterator[str]:
    """Yield whether the maneuver fits the drop tower, and the next command for the robot that was named."""
    if checked.tower is not None:
        yield checked.tower.verdict
    if checked.schedule is None:
        yield Advice("Next: ", NextStep("simulate", ("--file", str(checked.path), *robot_option)))
    elif not checked.may_fly:
        yield "Do not fly it: design with a shorter --time-limit, smaller --limit or a true --speed."
    else:
        # Before its servo settings allow so many joints at once the board would be sent nothing.
        at_once = checked.schedule.moving_at_once
        settings = NextStep("upload-servos", ("FILE",)), f" with moving_at_once = {at_once}; then "
        before = settings if at_once > 1 else ()
        yield Advice("Next: ", *before, NextStep("upload-sequence", ("--file", str(checked.path))))


def flight_warnings(checked: CheckedManeuver) -> Iterator[str]:
    """Yield warnings against flying the maneuver, one sentence each."""
    yield from checked.notices
    yield from (f"The check {check.name} failed: {check.sentence}" for check in checked.failed)
    if checked.refusal:
        yield f"The drop robot's sequencer would refuse it: {checked.refusal}"
