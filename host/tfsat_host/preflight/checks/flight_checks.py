"""What would fly: the maneuver on the board against the file, the servos' limits, and the facility's."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.maneuver import Schedule
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.preflight.preflight_check import PreflightCheck, go, judge, no_go, not_made
from tfsat_host.preflight.preflight_evidence import Evidence, Missing, require
from tfsat_host.protocol.enums import Origin
from tfsat_host.servo_settings import find_misfit

PAUSE, DURATION = ("pause", "clearance"), ("stroke-time", "landing")
"""Checks of the facility in `pause` and in `duration`; all others are in `envelope`."""
_NUMBERS = ("value", "limit", "at_most", "beyond", "unit")
"""Of a facility's check: the keys of `tfsat-host envelope --json`, which show which way the limit goes."""
Row = tuple[int, int, int]
"""Of a stroke: joint, angle in 0.01 deg, start in us."""


def check_maneuver(evidence: Evidence) -> PreflightCheck:
    """Check that every stroke read back from the sequencer equals the file's: joint, angle, start, speed."""
    answers, schedule = require(evidence.sequencer), require(evidence.schedule)
    stored = answers.maneuver
    if isinstance(stored, Missing):
        return no_go(stored.reason, stored.next_step)
    # In the board's own integers, 0.01 deg and us: equality is exact.
    file_strokes = tuple((stroke.joint, stroke.angle_cdeg, stroke.t_us) for stroke in schedule.strokes)
    numbers = {
        "crc": f"{stored.crc:04x}",
        "generation": stored.generation,
        "origin": stored.origin.name.lower(),
        "strokes": [_stroke(row) for row in stored.strokes],
    }
    upload = Advice(
        NextStep("upload-sequence", ("--file", "maneuver.toml")), ", then run this preflight again."
    )
    if stored.origin == Origin.FACTORY:
        return no_go("Maneuver: none uploaded; the board would refuse to arm.", upload, **numbers)
    if stored.strokes != file_strokes or stored.speed_cdeg_s != schedule.speed_cdeg_s:
        return no_go(
            f"Maneuver: differs from the file: {_difference(stored.strokes, schedule, file_strokes)}.",
            upload,
            **numbers,
            file_strokes=[_stroke(row) for row in file_strokes],
        )
    return go(
        f"Maneuver: equal to the file, {len(file_strokes)} strokes, CRC {stored.crc:04x}, upload "
        f"{stored.generation}.",
        **numbers,
    )


def _difference(stored: tuple[Row, ...], schedule: Schedule, file_strokes: tuple[Row, ...]) -> str:
    if len(stored) != len(file_strokes):
        return f"{len(stored)} strokes, the file has {len(file_strokes)}"
    for number, (ours, theirs) in enumerate(zip(file_strokes, stored, strict=True), 1):
        if ours != theirs:
            return f"stroke {number} is {_words(theirs)}, in the file {_words(ours)}"
    return f"its speed is not {schedule.speed_deg_s:g} deg/s"


def _words(row: Row) -> str:
    joint, angle_cdeg, t_us = row
    return f"joint {joint} by {angle_cdeg / 100:+g} deg at {t_us / 1e6:.2f} s"


def _stroke(row: Row) -> dict[str, float]:
    joint, angle_cdeg, t_us = row
    return {"t_s": t_us / 1e6, "joint": joint, "angle_deg": angle_cdeg / 100}


def check_servos(evidence: Evidence) -> PreflightCheck:
    """Check that the stored maneuver stays within the joint limits of the servo settings on the board."""
    answers = require(evidence.sequencer)
    if isinstance(answers.maneuver, Missing):
        return not_made("What would fly cannot be read.", answers.maneuver.next_step)
    settings = answers.settings.settings
    origin = answers.settings.origin.name.lower()
    # The board's own strokes against its own settings, as ARM judges them: the file does not enter.
    misfit = find_misfit(answers.maneuver.timed_strokes, settings)
    return judge(
        [] if misfit is None else [misfit.words],
        "Maneuver beyond the servo settings: {}.",
        Advice("Upload a maneuver that fits, or correct the settings with ", NextStep("upload-servos"), "."),
        f"Maneuver: within the servo limits ({origin} settings).",
        origin=origin,
        limits_deg=[[servo.min_cdeg / 100, servo.max_cdeg / 100] for servo in settings.servos],
    )


def check_facility(evidence: Evidence, names: tuple[str, ...] = ()) -> PreflightCheck:
    """Check the facility's limits of these names; without names envelope, release and drift: all the rest."""
    every = require(evidence.facility)
    checks = [check for check in every if check.name in names]
    words = checks[0].sentence if checks else ""
    if not names:
        checks = [check for check in every if check.name not in (*PAUSE, *DURATION)]
        words = _reach(checks)
    failed = [f"{check.name}: {check.sentence}" for check in checks if not check.passed]
    return judge(
        [" ".join(failed)] if failed else [],
        "{}",
        Advice(
            NextStep("envelope", ("--file", "maneuver.toml")),
            " shows all of it; ",
            NextStep("design"),
            " makes one that fits.",
        ),
        words,
        **{check.name: {key: getattr(check, key) for key in _NUMBERS} for check in checks},
    )


def _reach(checks: Sequence[FacilityCheck]) -> str:
    reach = next(check for check in checks if check.name == "envelope")
    return (
        f"Reach: {reach.value:.0f} mm (limit {reach.limit:.0f} mm); release, drift and travel within limits."
    )
