"""All checks, in the order in which a person would look; each is a pure function of the evidence."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

from tfsat_host.preflight.checks import board_checks, calibration, card, flight_checks, sensor_checks, timing
from tfsat_host.preflight.preflight_check import PreflightCheck, not_made
from tfsat_host.preflight.preflight_evidence import Evidence, Unreached

_LOG = logging.getLogger(__name__)

_CHECKS: dict[str, Callable[[Evidence], PreflightCheck]] = {
    "protocol": board_checks.check_protocol,
    "sequencer-image": lambda evidence: board_checks.check_image(evidence.sequencer_board),
    "logger-image": lambda evidence: board_checks.check_image(evidence.logger_board),
    "acceptance": board_checks.check_acceptance,
    "sequencer-state": board_checks.check_state,
    "restarts": board_checks.check_restarts,
    "battery": board_checks.check_battery,
    "maneuver": flight_checks.check_maneuver,
    "servo-limits": flight_checks.check_servos,
    "pause": partial(flight_checks.check_facility, names=flight_checks.PAUSE),
    "duration": partial(flight_checks.check_facility, names=flight_checks.DURATION),
    "envelope": flight_checks.check_facility,
    "switches": board_checks.check_switches,
    "gyros-present": sensor_checks.check_imus,
    "gyros-still": sensor_checks.check_stillness,
    "gyro-biases": sensor_checks.check_biases,
    "gyros-agree": sensor_checks.check_agreement,
    "joint-sensors": sensor_checks.check_sensors,
    "start-pose": sensor_checks.check_start_pose,
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
        result = check(evidence)
    except Unreached as error:
        result = not_made(error.missing.reason, error.missing.next_step)
    _LOG.debug("%s: %s, %s", name, result.verdict.name, result.sentence)
    return replace(result, name=name)


def may_drop(checks: Iterable[PreflightCheck]) -> bool:
    """Return whether no check blocks the drop (GO)."""
    return not any(check.blocks for check in checks)
