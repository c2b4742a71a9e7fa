"""What error to expect of each stroke, for `upload-sequence`, from a calibration."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.maneuver import Schedule
from tfsat_host.maneuver.schedule import STROKES, TimedStroke
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.stored_settings import servo_words
from tfsat_host.quantity import Column, Columns, columns_of, fields
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE
from tfsat_host.servo_settings import ServoSettings

if TYPE_CHECKING:
    from tfsat_host.calibration.servos.servo_map import ServoMap, StrokeError


class ServoMaps(NamedTuple):
    """The servos by a calibration.

    Attributes:
        path: Of the calibration.
        maps: At most one for each joint.
    """

    path: Path
    maps: tuple[ServoMap, ...]


class ExpectedStroke(NamedTuple):
    """A stroke and its error; None where its joint has no map."""

    stroke: TimedStroke
    error: StrokeError | None


class Expectation(NamedTuple):
    """What to expect of a maneuver's strokes.

    Attributes:
        errors: Of each stroke whose joint has a map.
        notices: Its shortcomings, one sentence or two each, to be shown to a person.
    """

    errors: tuple[StrokeError, ...] = ()
    notices: tuple[str, ...] = ()


EXPECTED: Columns = (
    *fields("stroke joint"),
    Column("commanded_deg", of=lambda error: error.commanded_cdeg / 100),
    Column("error_deg", of=lambda error: round(degrees(error.error_rad), 4)),
    Column("std_deg", of=lambda error: round(degrees(error.std_rad), 4)),
)
"""Of a stroke's error, for `--json`."""
EXPECTED_STROKES: Columns = (
    *columns_of("stroke", STROKES),
    Column("error_deg", "misses by", of="error.error_rad", form="+.2f"),
    Column("std_deg", "std", of="error.std_rad", form=".2f"),
)
"""Of an `ExpectedStroke`, for people."""


def find_servo_maps(args: argparse.Namespace) -> tuple[ServoMaps | None, list[str]]:
    """Read the servo maps of the named calibration or of the one in the current folder, with notices.

    A calibration that was not named and cannot be read stops no upload: it becomes a notice for a person.

    Raises:
        UsageError: the named file is not there, or --dry-run was given with it.
        TfsatError: the named file cannot be read.
    """
    if args.calibration is not None:
        return _named_servo_maps(args.calibration, dry_run=args.dry_run), []
    path = Path(EMULATED_CERTIFICATE if args.emulated else CERTIFICATE)
    if args.dry_run or not path.is_file():
        return None, []
    try:
        return ServoMaps(path, read_servo_maps(path)), []
    except TfsatError as error:
        return None, [f"How far the strokes will miss is not known. {error.what} {error.next_step}"]


def _named_servo_maps(path: Path, *, dry_run: bool) -> ServoMaps:
    if dry_run:
        raise UsageError(
            what="--dry-run touches no board, and how far strokes miss depends on the board's servo settings.",
            meaning="Nothing was done.",
            next_step="Leave out --dry-run or --calibration.",
        )
    if not path.is_file():
        raise UsageError(
            what=f"There is no calibration {path}.",
            meaning="Nothing was sent to the robot.",
            next_step="Give the path of the file that `calibrate` wrote, or leave out --calibration.",
        )
    return ServoMaps(path, read_servo_maps(path))


def read_servo_maps(path: Path) -> tuple[ServoMap, ...]:
    """Read the servo maps of the calibration at `path`. Raises TfsatError if it cannot be read."""
    from tfsat_host.calibration.certificate.file import read_calibration

    return read_calibration(path).servo_maps


def expect(schedule: Schedule, servo_maps: ServoMaps | None, settings: ServoSettings) -> Expectation:
    """Predict each stroke's error for a schedule on a board with these settings."""
    if servo_maps is None:
        return Expectation()
    from tfsat_host.calibration.servos.servo_map import expected_stroke_errors

    moves = [(stroke.joint, stroke.angle_cdeg) for stroke in schedule.strokes]
    joints = sorted({joint for joint, _ in moves})
    errors = expected_stroke_errors(moves, servo_maps.maps, settings)
    return Expectation(
        tuple(errors), (*_without_map(joints, servo_maps), *_off(joints, servo_maps, settings))
    )


def _without_map(joints: Sequence[int], servo_maps: ServoMaps) -> list[str]:
    mapped = {servo_map.joint for servo_map in servo_maps.maps}
    return [
        Advice(
            f"{servo_maps.path} has no servo map of joint {joint}: how far its strokes will miss is not known. "
            "To measure it: ",
            NextStep("calibrate servo", ("--joint", str(joint))),
        )
        for joint in joints
        if joint not in mapped
    ]


def _off(joints: Sequence[int], servo_maps: ServoMaps, settings: ServoSettings) -> list[str]:
    """Return a notice for each joint whose settings on the board differ from its servo map's."""
    from tfsat_host.calibration.servos.servo_map import matching_setting, setting_error_rad

    notices = []
    for servo_map in servo_maps.maps:
        setting = settings.of(servo_map.joint)
        off_rad = setting_error_rad(servo_map, setting)
        if servo_map.joint in joints and off_rad is not None:
            notices.append(
                f"The servo settings on the board are not those of {servo_maps.path} for joint {servo_map.joint}: they "
                f"are up to {abs(degrees(off_rad)):.1f} deg off, and the errors that are shown are those with them. "
                f"By the calibration: {servo_words(matching_setting(servo_map, setting))}. "
                f"{NextStep('upload-servos', ('FILE',))} stores them; the maneuver stays as it is."
            )
    return notices
