"""One drop from its files to its evaluation, and that as the object of `--json`: docs/evaluation.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from html import escape
from pathlib import Path

from tfsat_host import __version__
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.evaluation.camera import read_tracks, read_video_marks
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import ExternalObservations, evaluate
from tfsat_host.evaluation.laser_velocity import windows_of
from tfsat_host.evaluation.result.evaluation_tables import EVALUATION
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.verdict import VERDICT, Verdict, verdict_of
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices, printable
from tfsat_host.plan.facility import load_tower
from tfsat_host.quantity import Column, Columns, columns_of, fields
from tfsat_host.robot import RobotModel, find_robot
from tfsat_host.robot.absent_parts import describe_absent, load_robot_of_boards
from tfsat_host.run.certificate_check import (
    CERTIFICATE_STATE,
    CheckedCertificate,
    hold_against,
    is_of_robot,
    origin_of_log,
)
from tfsat_host.run.files import (
    AS_FOUND,
    EMULATED,
    REAL,
    ROBOT,
    EvaluationOptions,
    RunFiles,
    find_certificate,
    robot_beside,
    run_files,
)
from tfsat_host.run.held_maneuver import find_commanded
from tfsat_host.run.recorded_landing import time_of_day
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.log_summary import recordings_lines

_NO_MANEUVER = (
    "No maneuver is known: what the strokes were meant to be, and how far the sequencer's clock runs off, is not "
    "looked at. Put maneuver.toml next to the recording, or name it with --maneuver."
)
_NO_CERTIFICATE = Advice("No calibration was found. To measure one: ", NextStep("calibrate show"))


_RECORDING: Columns = (
    Column("file", of=lambda run: str(run.files.recording)),
    Column("session", of=lambda run: f"{run.found.log.session:08x}"),
    Column("released", of=lambda run: run.recorded and run.recorded.isoformat(timespec="milliseconds")),
    Column("samples", of=lambda run: len(run.found.log)),
    *(Column(key, of=f"found.log.{key}") for key in ("verdict", "samples_lost", "blocks_lost", "rate_hz")),
)


@dataclass(frozen=True, eq=False)
class EvaluatedRun:
    """One drop, evaluated.

    Attributes:
        place: The folder or recording, as typed.
        files: Where its parts are.
        found: The evaluation.
        recorded: When the release was; None: the recording has no time of day.
        held: The certificate; None: there is none.
        verdict: What it is worth.
        remarks: What else a reader should know, and no doubt; sentences.
        options: With what it was evaluated.
    """

    place: Path
    files: RunFiles
    found: Evaluation
    recorded: datetime | None
    held: CheckedCertificate | None
    verdict: Verdict
    remarks: tuple[str, ...]
    options: EvaluationOptions = AS_FOUND

    def __repr__(self) -> str:
        """Return the verdict and the key numbers, a line each."""
        numbers = key_numbers_of(self.found)
        lines = [f"  {number.label}: {number.text()} {number.unit}".rstrip() for number in numbers]
        return "\n".join((f"<EvaluatedRun {str(self.place)!r}: {self.verdict.line()}", *lines)) + ">"

    def _repr_html_(self) -> str:
        """Return the same as a table, for notebooks."""
        rows = "".join(
            f"<tr><td>{escape(number.label)}</td><td style='text-align:right'>{escape(number.text())}</td>"
            f"<td>{escape(number.unit)}</td><td>{escape(number.note)}</td></tr>"
            for number in key_numbers_of(self.found)
        )
        return f"<p><b>{escape(self.verdict.line())}</b> ({escape(str(self.place))})</p><table>{rows}</table>"


EVALUATED_RUN: Columns = (
    Column("drop", of=lambda run: str(run.place)),
    Column("verdict", columns=VERDICT),
    *columns_of("found", EVALUATION),
    Column("notes", of=lambda run: [*run.found.notes, *run.remarks]),
    Column("calibration", of="held.state", columns=CERTIFICATE_STATE),
    Column("maneuver", of=lambda run: run.files.maneuver and str(run.files.maneuver)),
    *fields("robot=found.model.name"),
    Column("recording", of=lambda run: run, columns=_RECORDING),
)
"""Of an evaluated drop, for `--json`."""
MADE_BY: Columns = (Column("made_by", of=lambda _: f"tfsat-host evaluate {__version__}"),)
"""Begins the object of `evaluate --json`; see `files.EVALUATION_MARKER`."""


@dataclass(frozen=True, slots=True)
class DroppedRobot:
    """A robot, as far as a recording and its certificate distinguish it from others.

    Attributes:
        kind: Whether it fell, or was emulated: one of `files.ROBOTS`.
        logger_serial: Of the logger that it had first, hexadecimal; empty: it gave none.
    """

    kind: str
    logger_serial: str

    def __str__(self) -> str:
        logger = f"logger {self.logger_serial}" if self.logger_serial else "a logger without a serial number"
        return f"{self.kind} robot with {logger}"


def dropped_robot(log: DropLog, calibration: Calibration | None = None) -> DroppedRobot:
    """Return the robot that recorded the log; by its certificate also after its logger was replaced."""
    origin = origin_of_log(log.header)
    serial = origin.logger_serial
    if calibration is not None and is_of_robot(calibration, origin, time_of_day(log, log.origin_us)):
        serial = calibration.first_logger
    return DroppedRobot(EMULATED if origin.emulated else REAL, serial)


def robot_of(named: Path | str | None, places: Sequence[Path] = ()) -> RobotModel:
    """Load the model of the dropped robot.

    It is the named one (a file, or a shipped robot's name), else that of `robot.toml` next to the recordings,
    else the drop tower's. `places` are recordings or their folders.

    Raises:
        UsageError: several robots were dropped: their loggers differ, or their files and none was named.
        TfsatError: it cannot be read, or none of our loggers could have recorded it.
    """
    if len(places) > 1:
        _require_one_robot(places)
    return load_robot_of_boards(named or _robot_of_all(places))


def _robot_of_run(log: DropLog) -> DroppedRobot:
    """Return the robot of a recording, by the certificate that lies there. Raises CalibrationError."""
    emulated = origin_of_log(log.header).emulated
    file = find_certificate(None, log.path.parent, Path(), emulated=emulated)
    return dropped_robot(log, None if file is None else read_calibration(file))


def _require_one_robot(places: Sequence[Path]) -> None:
    """Refuses drops of different robots before anything is evaluated: they are never combined.

    One that cannot be read is refused for that reason when its turn comes.
    """
    first: dict[DroppedRobot, Path] = {}
    for place in places:
        try:
            robot = _robot_of_run(load(run_files(place, None).recording))
        except (TfsatError, OSError):
            continue
        first.setdefault(robot, place)
    if len(first) > 1:
        named = "; ".join(f"{place}: {robot}" for robot, place in first.items())
        raise UsageError(
            what=f"These drops are not of one robot. {named}.",
            meaning="What one robot's drops say of its model says nothing of another's. Nothing was evaluated.",
            next_step=Advice(
                "Evaluate each robot's drops by themselves; ",
                NextStep("campaign report"),
                " keeps them apart.",
            ),
        )


def _robot_of_all(places: Sequence[Path]) -> Path | None:
    """Find the robot file that all places share; None: they have none.

    Raises UsageError: they are files of different robots.
    """
    there = [place for place in places if place.exists()]
    files = [robot_beside(place) for place in there]
    # By contents, as each run has a copy of its own; a run without one stands for the default robot.
    first = {sha256_of(file or find_robot(None)): place for place, file in zip(there, files, strict=True)}
    if len(first) > 1:
        names = " and ".join(str(place) for place in list(first.values())[:2])
        raise UsageError(
            what=f"{names} were not dropped with the same robot: their {ROBOT} differ.",
            meaning="What one robot's drops say of its model says nothing of another's. Nothing was evaluated.",
            next_step="Evaluate them one by one, or name one robot for all with --robot FILE.",
        )
    return next((file for file in files if file is not None), None)


def evaluate_run(
    place: Path, options: EvaluationOptions, robot: RobotModel, notices: Notices = SILENT
) -> EvaluatedRun:
    """Reads, calibrates, evaluates a recording or its folder; `robot` is that of `robot_of`.

    Raises:
        TfsatError: something cannot be read, or the recording does not hold what an evaluation needs.
    """
    files = run_files(place, options.maneuver)
    _name_robot(files.recording, robot, notices)
    witnesses = _witnesses(options)
    log = _read(files.recording, options.session, notices)
    # Needs the log: its session, under which the note of what the sequencer held is filed, and its header.
    commanded = find_commanded(files, options.maneuver, log)
    files = replace(files, maneuver=commanded.file)
    # Also writes this drop's landing into the certificate: what it may have moved is stale from then on.
    certificate, calibration = _calibration(log, options.calibration, robot, notices)
    with notices.progress(f"Evaluating {printable(place)}"):
        evaluation = evaluate(
            log,
            robot,
            calibration,
            commanded.schedule,
            recorded=time_of_day(log, log.origin_us),
            witnesses=witnesses,
            swarm=options.swarm,
        )
    # Remarks inform and do not enter the verdict; objections to certificate and maneuver do.
    absent = describe_absent(robot)
    remarks = [f"{absent}."] if absent else []
    remarks += [_NO_MANEUVER] if commanded.schedule is None else []
    remarks += [commanded.remark] if commanded.remark else []
    remarks += evaluation.micro_gravity.notes
    remarks += [] if evaluation.release_velocity is None else evaluation.release_velocity.notes
    remarks += [] if certificate else [_NO_CERTIFICATE]
    objections = () if certificate is None else certificate.objections
    verdict = verdict_of(evaluation, objections, [commanded.objection] if commanded.objection else [])
    released = time_of_day(log, log.release_us)
    return EvaluatedRun(place, files, evaluation, released, certificate, verdict, tuple(remarks), options)


def _name_robot(recording: Path, robot: RobotModel, notices: Notices) -> None:
    """Whose model is used, where that is not the drop tower's by default."""
    own = robot_beside(recording)
    if own is None:
        return
    if sha256_of(own) == sha256_of(robot.path):
        notices.note(f"Robot: {printable(own)} (the run's)")
    else:
        notices.note(f"Robot: {printable(robot.path)} (--robot; not the run's {printable(own)})")


def _read(file: Path, session: int | None, notices: Notices) -> DropLog:
    with notices.progress(f"Reading {printable(file)}", total=1.0) as advance:
        log = load(file, session=session, progress=advance)
    for line in recordings_lines(log, printable(file), "evaluate", "Evaluated"):
        notices.note(line)
    return log


def _calibration(
    log: DropLog, named: Path | None, robot: RobotModel, notices: Notices
) -> tuple[CheckedCertificate | None, Calibration | None]:
    """Read and check the certificate; return it and the part of its calibration that can be used."""
    origin = origin_of_log(log.header)
    file = find_certificate(named, log.path.parent, Path(), emulated=origin.emulated)
    if file is None:
        return None, None
    certificate = hold_against(log, file, notices, servos=False)
    # Another robot's numbers say nothing of these sensors: report the certificate, evaluate without it.
    if not is_of_robot(certificate.calibration, origin, time_of_day(log, log.origin_us)):
        return certificate, None
    return certificate, _of_same_imus(certificate.calibration, origin.who_am_i, robot)


def _of_same_imus(calibration: Calibration, who_am_i: str, robot: RobotModel) -> Calibration:
    """Without the numbers of an IMU that has been exchanged since."""
    calibrated_who_am_i = calibration.subject.who_am_i
    if calibrated_who_am_i == who_am_i:
        return calibration
    # WHO_AM_I has two hexadecimal digits for each IMU; an exchanged one goes back to its design values.
    gyros = [
        gyro
        if calibrated_who_am_i[2 * i : 2 * i + 2] == who_am_i[2 * i : 2 * i + 2]
        else by_design(gyro.body, robot.imus[i].sensor_to_body, absent=gyro.absent)
        for i, gyro in enumerate(calibration.gyros)
    ]
    return replace(calibration, gyros=tuple(gyros))


def _witnesses(options: EvaluationOptions) -> ExternalObservations | None:
    if options.video is None and options.laser is None:
        return None
    return ExternalObservations(
        () if options.video is None else read_video_marks(options.video),
        options.video_rate,
        None if options.laser is None else read_tracks(options.laser),
        None if options.laser is None else windows_of(load_tower(options.facility)),
    )
