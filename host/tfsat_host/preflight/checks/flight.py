"""What would fly: the maneuver on the board against the file, the servos' limits, and the facility's."""

from __future__ import annotations

from collections.abc import Iterable

from tfsat_host.maneuver import Schedule
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.preflight.check import Check, go, no_go, not_made
from tfsat_host.preflight.evidence import Evidence, Missing, unreached
from tfsat_host.protocol.enums import Origin
from tfsat_host.servo_settings import find_misfit

_GROUPS = {
    "pause": ("pause", "clearance"),
    "duration": ("stroke-time", "landing"),
}
"""Checks of the facility by ours; all others are the envelope's."""
_ENVELOPE = "envelope"
_NUMBERS = ("value", "limit", "at_most", "beyond", "unit")
"""Of a facility's check: the keys of `tfsat-host envelope --json`, which say which way the limit goes."""


def check_maneuver(evidence: Evidence) -> Check:
    """Every stroke read back from the sequencer is the file's: joint, angle, start, speed."""
    name = "maneuver"
    answers, schedule = evidence.sequencer, evidence.schedule
    if isinstance(answers, Missing):
        return unreached(name, answers)
    if isinstance(schedule, Missing):
        return unreached(name, schedule)
    stored = answers.maneuver
    if isinstance(stored, Missing):
        return no_go(name, stored.reason, stored.next_step)
    wanted = tuple((stroke.joint, stroke.angle_cdeg, stroke.t_us) for stroke in schedule.strokes)
    numbers = {
        "crc": f"{stored.crc:04x}",
        "generation": stored.generation,
        "origin": stored.origin.name.lower(),
        "strokes": [_stroke(row) for row in stored.strokes],
    }
    upload = "tfsat-host upload-sequence --file maneuver.toml, then run this preflight again."
    if stored.origin == Origin.FACTORY:
        return no_go(name, "No maneuver was uploaded: the board would refuse to arm.", upload, **numbers)
    if stored.strokes != wanted or stored.speed_cdeg_s != schedule.speed_cdeg_s:
        numbers["file_strokes"] = [_stroke(row) for row in wanted]
        return no_go(
            name,
            f"The sequencer holds another maneuver than the file: {_difference(stored.strokes, schedule, wanted)}.",
            upload,
            **numbers,
        )
    return go(
        name,
        f"Read back and equal to the file: {len(wanted)} strokes, CRC {stored.crc:04x}, upload {stored.generation}.",
        **numbers,
    )


def _difference(
    stored: tuple[tuple[int, int, int], ...], schedule: Schedule, wanted: tuple[tuple[int, int, int], ...]
) -> str:
    if len(stored) != len(wanted):
        return f"{len(stored)} strokes, the file has {len(wanted)}"
    for number, (ours, theirs) in enumerate(zip(wanted, stored, strict=True), 1):
        if ours != theirs:
            return f"stroke {number} is {_words(theirs)}, in the file {_words(ours)}"
    return f"its speed is not {schedule.speed_deg_s:g} deg/s"


def _words(row: tuple[int, int, int]) -> str:
    joint, angle_cdeg, t_us = row
    return f"joint {joint} by {angle_cdeg / 100:+g} deg at {t_us / 1e6:.2f} s"


def _stroke(row: tuple[int, int, int]) -> dict[str, float]:
    joint, angle_cdeg, t_us = row
    return {"t_s": t_us / 1e6, "joint": joint, "angle_deg": angle_cdeg / 100}


def check_servos(evidence: Evidence) -> Check:
    """The stored maneuver stays within the joints' limits of the servo settings on the board."""
    name = "servo-limits"
    answers = evidence.sequencer
    if isinstance(answers, Missing):
        return unreached(name, answers)
    if isinstance(answers.maneuver, Missing):
        return not_made(name, "What would fly cannot be read.", answers.maneuver.next_step)
    settings = answers.settings.settings
    numbers = {
        "origin": answers.settings.origin.name.lower(),
        "limits_deg": [[servo.min_cdeg / 100, servo.max_cdeg / 100] for servo in settings.servos],
    }
    misfit = find_misfit(answers.maneuver.moves, settings)
    if misfit is not None:
        return no_go(
            name,
            f"The stored maneuver does not fit the servo settings: {misfit}.",
            "Upload a smaller maneuver, or correct the joint's limits with tfsat-host upload-servos.",
            **numbers,
        )
    return go(
        name,
        f"The stored maneuver fits the servo settings ({numbers['origin']}).",
        **numbers,
    )


def facility_checks(evidence: Evidence) -> tuple[Check, ...]:
    """`pause`, `duration`, and `envelope` with release and drift, of the facility."""
    found = evidence.facility
    names = (*_GROUPS, _ENVELOPE)
    if isinstance(found, Missing):
        return tuple(unreached(name, found) for name in names)
    grouped = {one for group in _GROUPS.values() for one in group}
    return (
        *(_of_facility(name, (one for one in found if one.name in group)) for name, group in _GROUPS.items()),
        _of_facility(_ENVELOPE, (one for one in found if one.name not in grouped)),
    )


def _of_facility(name: str, checks: Iterable[FacilityCheck]) -> Check:
    mine = tuple(checks)
    numbers = {one.name: {key: getattr(one, key) for key in _NUMBERS} for one in mine}
    failed = [one for one in mine if not one.passed]
    if failed:
        said = " ".join(f"{one.name}: {one.sentence}" for one in failed)
        return no_go(
            name,
            said,
            "tfsat-host envelope --file maneuver.toml shows all of it; tfsat-host design makes one that fits.",
            **numbers,
        )
    return go(
        name, " ".join(one.sentence for one in mine[:1] if name != _ENVELOPE) or _reach(mine), **numbers
    )


def _reach(checks: tuple[FacilityCheck, ...]) -> str:
    reach = next(one for one in checks if one.name == "envelope")
    return (
        f"The robot reaches {reach.value:.0f} mm of {reach.limit:.0f} mm; release, drift and travel fit too."
    )
