"""The steps of a command in a terminal: its certificate, what is asked and shown, and its result."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection
from datetime import UTC, datetime
from functools import partial
from typing import TYPE_CHECKING

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.steps.step import Axis, Step, StepKind
from tfsat_host.cli.calibrate import jogged_joint
from tfsat_host.cli.calibrate.arguments import certificate_path, commands_as_typed
from tfsat_host.cli.calibrate.bench import open_bench
from tfsat_host.cli.calibrate.person import Terminal, give_result, record_step
from tfsat_host.cli.next_steps import complete_command
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import check_may_write
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.calibration_campaign import Campaign
    from tfsat_host.calibration.solution import SensorKnowledge
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.robot import RobotModel
    from tfsat_host.sdlog import DropLog

    Reader = Callable[[Step, SensorKnowledge], Evidence]


def measure(args: argparse.Namespace, turned: tuple[Axis, float] | None, out: Output) -> int:
    """Measure one quantity, repeating each step until it is accepted.

    `turned` is a turn by hand: its axis and its angle in deg.
    """
    from tfsat_host.calibration.session import Session, fit_steps, steps_of, with_rest
    from tfsat_host.robot.absent_parts import load_robot_of_boards

    model = load_robot_of_boards(args.robot)
    jogging, anew = getattr(args, "jog", False), getattr(args, "anew", False)
    steps = fit_steps(steps_of(args.quantity, getattr(args, "joint", None), turned), model)
    with open_bench(args, model, out, jog=jogging) as bench:
        campaign = open_campaign(args, bench.origin, model, out)
        before = campaign.calibration
        if args.quantity == "misalignment" and anew:
            campaign.sensors_moved(datetime.now(UTC))
        if args.quantity in ("misalignment", "scale"):
            steps = with_rest(steps, campaign, model)
            _note_without_zero(campaign, out)

        def read(step: Step, calibration: SensorKnowledge) -> Evidence:
            if jogging and step.kind == StepKind.SWEEP:
                return jogged_joint.sweep(step, bench, out)
            return record_step(step, bench, calibration, model, out)

        terminal = Terminal(read, len(steps), model, args, out)
        session = Session(steps, campaign, terminal, resume=args.resume, compare=not anew)
        with commands_as_typed(args, out, session):
            session.run()
    give_result(args, campaign, session.kept, before, model, out)
    return 0


def take_from_log(args: argparse.Namespace, out: Output) -> int:
    """Takes a rest or the strokes out of a recording, judges and keeps them as steps on the bench."""
    from tfsat_host.robot.absent_parts import load_robot_of_boards
    from tfsat_host.run.certificate_check import origin_of_log
    from tfsat_host.sdlog.load import load

    model = load_robot_of_boards(args.robot)
    with out.progress(f"Reading {args.log}", total=1.0) as advance:
        log = load(args.log, progress=advance)
    origin = origin_of_log(log.header)
    # What is to be typed next is for the robot of the recording, not for whatever is plugged in.
    here = argparse.Namespace(**{**vars(args), "emulated": origin.emulated})
    out.complete_command = partial(complete_command, args=here)
    with commands_as_typed(here, out):
        steps = _steps_in(log, args, origin)
        campaign = open_campaign(args, origin, model, out)
        before = campaign.calibration
        newer = [campaign.not_older_than(step) for step in steps]
        for step, other in zip(steps, newer, strict=True):
            if other is not None and other.recorded_at > step.recorded_at:
                raise _older_than(other, step, campaign, args)
        refused = []
        for step in (step for step, other in zip(steps, newer, strict=True) if other is None):
            try:
                campaign.accept(step)
            except CalibrationError as error:  # one joint's strokes say nothing about another's
                refused.append(error)
        if len(refused) == len(steps):
            raise refused[0]
        out.warn_each(f"{error.what} {error.meaning}" for error in refused)
    if all(newer):
        out.note(f"{campaign.certificate} already contains this recording: unchanged.")
    give_result(here, campaign, steps, before, model, out)
    return 0


def _steps_in(log: DropLog, args: argparse.Namespace, origin: Origin) -> list[Evidence]:
    """Cut the rest, or each joint's strokes, out of a recording. Raises CalibrationError, ManeuverError."""
    from tfsat_host.calibration.bias import rest_of
    from tfsat_host.run.files import MANEUVER, run_files
    from tfsat_host.run.held_maneuver import find_commanded
    from tfsat_host.run.recorded_strokes import recorded_strokes

    if args.quantity == "bias":
        return [rest_of(log, args.log, origin)]
    schedule = find_commanded(run_files(args.log, args.maneuver), args.maneuver, log).schedule
    if schedule is None:
        again = NextStep("calibrate servo", ("--log", str(args.log), "--maneuver", MANEUVER))
        raise CalibrationError(
            what=f"The maneuver that was flown in {args.log} is unknown: no {MANEUVER} lies next to it.",
            meaning="Which joint each stroke moved is not known; nothing was kept.",
            next_step=Advice("Name it: ", again),
        )
    return recorded_strokes(log, schedule, args.log)


_IN_LOG = {"bias": ("rest", "biases"), "servo": ("run", "servos' strokes")}
"""By quantity what is taken out of a recording, and what it measures."""


def _older_than(
    newer: Evidence, step: Evidence, campaign: Campaign, args: argparse.Namespace
) -> CalibrationError:
    file, (part, measured) = campaign.certificate, _IN_LOG[args.quantity]
    other = file.with_name(f"{file.stem}-{args.log.stem}.toml")
    anew = NextStep(f"calibrate {args.quantity}", ("--log", str(args.log), "--out", str(other)))
    return CalibrationError(
        what=f"The {part} in {args.log} is of {step.recorded_at:%Y-%m-%d %H:%M} UTC, "
        f"older than the {measured} in {file}, which are of {newer.recorded_at:%Y-%m-%d %H:%M} UTC.",
        meaning=f"The newest {measured} count; the certificate is unchanged.",
        next_step=Advice("For a certificate of its own: ", anew),
    )


def open_campaign(
    args: argparse.Namespace,
    origin: Origin,
    model: RobotModel,
    out: Output,
    *,
    replaced: Collection[str] = (),
) -> Campaign:
    """Open the certificate that the steps go into, and check that it can be written.

    Warns of recordings that are lost. `replaced` are the parts that others stand in for now.

    Raises:
        CalibrationError: it is of other sensors, damaged, or its recordings are.
        TfsatError: nothing can be written there.
    """
    from tfsat_host.calibration.certificate.calibration_campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Subject

    path = certificate_path(args, emulated=origin.emulated)
    check_may_write(path, marker=b"", force=True)  # whether what is there may be replaced, the campaign knows
    subject = Subject(model.name, origin.logger_serial, origin.who_am_i, origin.emulated)
    force = getattr(args, "force", False)
    campaign = Campaign(path, model, subject, force=force, replaced=replaced)
    campaign.check_lock()
    out.warn_each(f"{sentence} Its step no longer counts." for sentence in campaign.left_out)
    return campaign


def _note_without_zero(campaign: Campaign, out: Output) -> None:
    """Says before a motion that the angles of closed joints are only known by design."""
    joints = campaign.solution().joints
    unknown = [str(sensors.joint) for sensors in joints if not sensors.has_zero]
    if not unknown or out.json_mode:
        return
    which = ("--all",) if len(unknown) == len(joints) else ("--joint", unknown[0])
    out.note(
        Advice(
            f"Zero points of joint{'s' if len(unknown) > 1 else ''} {', '.join(unknown)} are not calibrated: "
            "larger uncertainty for bodies beyond a closed joint.\n  To measure them first: ",
            NextStep("calibrate zero", which),
        )
    )
