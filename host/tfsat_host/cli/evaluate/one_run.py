"""One drop from its files to its evaluation, for every command that wants one."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibration_notice import find_certificate, is_of_robot, origin_of_log
from tfsat_host.cli.decode_calibration import hold_against
from tfsat_host.cli.decode_landing import time_of_day
from tfsat_host.cli.decode_words import recordings_lines
from tfsat_host.cli.evaluate.dropped_robot import require_one_robot
from tfsat_host.cli.evaluate.phrases import printable
from tfsat_host.cli.evaluate.run_files import ROBOT, RunFiles, robot_beside, run_files, schedule_in
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.file_hash import sha256_of
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.cli.decode_calibration import HeldAgainst
    from tfsat_host.evaluation.evaluation import Evaluation, Witnesses
    from tfsat_host.evaluation.verdict import Verdict
    from tfsat_host.maneuver import Schedule
    from tfsat_host.robot import RobotModel
    from tfsat_host.sdlog import DropLog

_NO_MANEUVER = (
    "No maneuver is known: what the strokes were meant to be, and how far the sequencer's clock runs off, is not "
    "looked at. Put maneuver.toml beside the recording, or name it with --maneuver."
)
_NO_CERTIFICATE = "No calibration was found. To measure one: tfsat-host calibrate show"


@dataclass(frozen=True, eq=False)
class EvaluatedRun:
    """One drop, evaluated.

    Attributes:
        place: As it was typed.
        files: Where its parts are.
        found: The evaluation.
        recorded: When the release was; None: the recording has no time of day.
        held: The certificate; None: there is none.
        verdict: What it is worth.
        remarks: What else a reader should know, and no doubt; sentences.
    """

    place: Path
    files: RunFiles
    found: Evaluation
    recorded: datetime | None
    held: HeldAgainst | None
    verdict: Verdict
    remarks: tuple[str, ...]

    @property
    def calibration_facts(self) -> dict[str, Any] | None:
        """For `--json`, as `decode` has it."""
        return None if self.held is None else self.held.facts


def robot_of(args: argparse.Namespace, runs: Sequence[Path] = ()) -> RobotModel:
    """The robot that was dropped: of `--robot`, else of `robot.toml` beside the recordings, else the drop tower's.

    Args:
        args: Of a parser with `add_run_arguments`.
        runs: Recordings or their folders.

    Raises:
        UsageError: several robots were dropped: their loggers differ, or their files and none was named.
        TfsatError: it cannot be read, or no logger of ours could have recorded it.
    """
    from tfsat_host.robot import load_robot

    if len(runs) > 1:
        require_one_robot(runs)
    robot = load_robot(args.robot or _robot_of_all(runs))
    if (robot.n_bodies, robot.n_joints, len(robot.imus)) != (IMU_COUNT, JOINT_COUNT, IMU_COUNT):
        raise TfsatError(
            what=f"{robot.name} has {robot.n_bodies} bodies, {robot.n_joints} joints and {len(robot.imus)} IMUs; the "
            f"logger records {IMU_COUNT} bodies with an IMU each and {JOINT_COUNT} joints.",
            meaning="Nothing was evaluated.",
            next_step="Give the file of the robot that was dropped with --robot.",
        )
    return robot


def _robot_of_all(runs: Sequence[Path]) -> Path | None:
    """Their file; None: they have none. Raises UsageError: they are files of different robots."""
    from tfsat_host.robot import find_robot

    there = [place for place in runs if place.exists()]
    files = [robot_beside(place) for place in there]
    first = {sha256_of(file or find_robot(None)): place for place, file in zip(there, files, strict=True)}
    if len(first) > 1:
        names = " and ".join(str(place) for place in list(first.values())[:2])
        raise UsageError(
            what=f"{names} were not dropped with the same robot: their {ROBOT} differ.",
            meaning="What one robot's drops say of its model says nothing of another's. Nothing was evaluated.",
            next_step="Evaluate them one by one, or name one robot for all with --robot FILE.",
        )
    return next((file for file in files if file is not None), None)


def _tell_robot(place: Path, robot: RobotModel, out: Output) -> None:
    """Whose model is used, where that is not the drop tower's by default."""
    own = robot_beside(place)
    if own is None:
        return
    if sha256_of(own) == sha256_of(robot.path):
        out.note(f"Robot: {printable(own)}, as the run has it.")
    else:
        out.note(f"Robot: {printable(robot.path)}, as named, and not the run's own {printable(own)}.")


def evaluate_run(place: Path, args: argparse.Namespace, robot: RobotModel, out: Output) -> EvaluatedRun:
    """Reads, calibrates, evaluates.

    Args:
        place: RUN as it was typed.
        args: Of a parser with `add_run_arguments`.
        robot: See `robot_of`.
        out: For progress, and for what was done on the way.

    Raises:
        TfsatError: something cannot be read, or the recording does not hold what an evaluation needs.
    """
    from tfsat_host.evaluation.evaluation import evaluate
    from tfsat_host.evaluation.model_fit.offsets import com_offsets
    from tfsat_host.evaluation.verdict import verdict_of

    files = run_files(place, args.maneuver)
    _tell_robot(files.recording, robot, out)
    schedule = None if files.maneuver is None else schedule_in(files.maneuver)
    witnesses = _witnesses(args)
    log = _read(files.recording, args.session, out)
    held, calibration, against = _calibration(log, args.calibration, robot, out)
    with out.progress(f"Evaluating {printable(place)}"):
        found = evaluate(
            log,
            robot,
            calibration,
            schedule,
            recorded=time_of_day(log, log.origin_us),
            witnesses=witnesses,
            offsets=com_offsets(robot, masses=args.masses, inertias=args.inertias),
            swarm=args.swarm,
        )
    remarks = (*_remarks(found, schedule), *([] if held else [_NO_CERTIFICATE]))
    recorded = time_of_day(log, log.release_us)
    return EvaluatedRun(place, files, found, recorded, held, verdict_of(found, against), remarks)


def _read(file: Path, session: int | None, out: Output) -> DropLog:
    from tfsat_host.sdlog.load import load
    from tfsat_host.sdlog.metadata import metadata

    with out.progress(f"Reading {printable(file)}", total=1.0) as advance:
        log = load(file, session=session, progress=advance)
    for line in recordings_lines(metadata(log), printable(file), "evaluate", "Evaluated"):
        out.note(line)
    return log


def _calibration(
    log: DropLog, named: Path | None, robot: RobotModel, out: Output
) -> tuple[HeldAgainst | None, Calibration | None, list[str]]:
    """The certificate, what of it can be used, and what stands against it."""
    origin = origin_of_log(log.header)
    file = find_certificate(named, log.path.parent, Path(), emulated=origin.emulated)
    if file is None:
        return None, None, []
    held = hold_against(log, file, out, servos=False)
    if not is_of_robot(held.calibration, origin):
        return held, None, held.said
    return held, _of_same_imus(held.calibration, origin.who_am_i, robot), held.said


def _of_same_imus(calibration: Calibration, who_am_i: str, robot: RobotModel) -> Calibration:
    """Without the numbers of an IMU that has been exchanged since."""
    from tfsat_host.calibration.gyros.gyro import by_design

    known = calibration.subject.who_am_i
    if known == who_am_i:
        return calibration
    gyros = [
        gyro
        if known[2 * i : 2 * i + 2] == who_am_i[2 * i : 2 * i + 2]
        else by_design(gyro.body, robot.imus[i].sensor_to_body)
        for i, gyro in enumerate(calibration.gyros)
    ]
    return replace(calibration, gyros=tuple(gyros))


def _witnesses(args: argparse.Namespace) -> Witnesses | None:
    if args.video is None and args.laser is None:
        return None
    from tfsat_host.evaluation.evaluation import Witnesses
    from tfsat_host.evaluation.witnesses.laser import windows_of
    from tfsat_host.evaluation.witnesses.laser_file import read_tracks
    from tfsat_host.evaluation.witnesses.video import read_video_marks
    from tfsat_host.facility import load_tower

    return Witnesses(
        () if args.video is None else read_video_marks(args.video),
        None if args.laser is None else read_tracks(args.laser),
        None if args.laser is None else windows_of(load_tower(args.facility)),
    )


def _remarks(found: Evaluation, schedule: Schedule | None) -> list[str]:
    """What could not be looked at, and is no fault of the data."""
    remarks = [] if schedule is not None else [_NO_MANEUVER]
    remarks += found.micro_gravity.notes
    if found.release_velocity is not None:
        remarks += found.release_velocity.notes
    return remarks
