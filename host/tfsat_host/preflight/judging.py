"""All checks, in the order in which a person would look."""

from __future__ import annotations

from collections.abc import Iterable

from tfsat_host.preflight.check import Check
from tfsat_host.preflight.checks.boards import check_image, check_protocol
from tfsat_host.preflight.checks.calibration import check_calibration
from tfsat_host.preflight.checks.card import check_card, check_ram, check_room, check_writing
from tfsat_host.preflight.checks.clocks import check_clock, check_paces
from tfsat_host.preflight.checks.flight import check_maneuver, check_servos, facility_checks
from tfsat_host.preflight.checks.gyros import check_agreement, check_biases, check_imus, check_stillness
from tfsat_host.preflight.checks.joints import check_sensors, check_start_pose
from tfsat_host.preflight.checks.sampling import check_ranges, check_sampling
from tfsat_host.preflight.checks.sequencer import check_battery, check_restarts, check_state, check_switches
from tfsat_host.preflight.evidence import Evidence


def judge(evidence: Evidence) -> tuple[Check, ...]:
    """Every check, each once."""
    return (
        check_protocol(evidence),
        check_image(evidence.sequencer_board),
        check_image(evidence.logger_board),
        check_state(evidence),
        check_restarts(evidence),
        check_battery(evidence),
        check_maneuver(evidence),
        check_servos(evidence),
        *facility_checks(evidence),
        check_switches(evidence),
        check_imus(evidence),
        check_stillness(evidence),
        check_biases(evidence),
        check_agreement(evidence),
        check_sensors(evidence),
        check_start_pose(evidence),
        check_calibration(evidence),
        check_card(evidence),
        check_ram(evidence),
        check_room(evidence),
        check_writing(evidence),
        check_sampling(evidence),
        check_ranges(evidence),
        check_clock(evidence),
        check_paces(evidence),
    )


def may_drop(checks: Iterable[Check]) -> bool:
    """GO: none stands against it."""
    return not any(check.blocks for check in checks)
