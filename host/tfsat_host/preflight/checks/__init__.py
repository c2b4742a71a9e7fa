"""All checks, in the order in which a person would look; each is a pure function of the evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from tfsat_host.preflight.check import PreflightCheck, not_made
from tfsat_host.preflight.checks import boards, calibration, card, flight, sensors, timing
from tfsat_host.preflight.evidence import Evidence, Unreached

_CHECKS: dict[str, Callable[[Evidence], PreflightCheck]] = {
    "protocol": boards.check_protocol,
    "sequencer-image": lambda evidence: boards.check_image(evidence.sequencer_board),
    "logger-image": lambda evidence: boards.check_image(evidence.logger_board),
    "sequencer-state": boards.check_state,
    "restarts": boards.check_restarts,
    "battery": boards.check_battery,
    "maneuver": flight.check_maneuver,
    "servo-limits": flight.check_servos,
    "pause": flight.check_pause,
    "duration": flight.check_duration,
    "envelope": flight.check_envelope,
    "switches": boards.check_switches,
    "gyros-present": sensors.check_imus,
    "gyros-still": sensors.check_stillness,
    "gyro-biases": sensors.check_biases,
    "gyros-agree": sensors.check_agreement,
    "joint-sensors": sensors.check_sensors,
    "start-pose": sensors.check_start_pose,
    "calibration": calibration.check_calibration,
    "card": card.check_card,
    "ram": card.check_ram,
    "card-room": card.check_room,
    "card-writing": card.check_writing,
    "sampling": timing.check_sampling,
    "logger-settings": timing.check_ranges,
    "clock": timing.check_clock,
    "clock-pace": timing.check_paces,
}


def judge(evidence: Evidence) -> tuple[PreflightCheck, ...]:
    """Make every check once, and return the results."""
    return tuple(_make_check(name, check, evidence) for name, check in _CHECKS.items())


def _make_check(name: str, check: Callable[[Evidence], PreflightCheck], evidence: Evidence) -> PreflightCheck:
    try:
        return replace(check(evidence), name=name)
    except Unreached as error:
        return replace(not_made(error.missing.reason, error.missing.next_step), name=name)


def may_drop(checks: Iterable[PreflightCheck]) -> bool:
    """GO: none stands against it."""
    return not any(check.blocks for check in checks)
