"""Whether the certificate holds for a drop now: of these sensors, complete, and younger than the last landing."""

from __future__ import annotations

from datetime import UTC, datetime

from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    commands_of,
    exchanged_imus,
    of_another_robot,
    quantities,
    summarize_shortcomings,
)
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import PreflightCheck, go, join_steps, no_go, not_made
from tfsat_host.preflight.preflight_evidence import Evidence, Missing, require
from tfsat_host.protocol.enums import DropPhase
from tfsat_host.protocol.messages import LoggerStatusReply

_NAMED = 3


def check_calibration(evidence: Evidence) -> PreflightCheck:
    """Complete, newer than the last landing, and of the sensors that hang on this logger."""
    calibration = evidence.calibration
    if isinstance(calibration, Missing):
        return no_go(calibration.reason, calibration.next_step)
    logger = require(evidence.logger)
    if evidence.origin is None:
        return not_made("Whose sensors these are the logger did not answer.", Advice(NextStep("status")))
    subject, last = calibration.subject, calibration.last_landing
    shortcomings = calibration.shortcomings(servos=evidence.servos_too)
    numbers = {
        "file": evidence.calibration_file,
        "robot": subject.robot,
        "logger_serial": subject.logger_serial,
        "written": calibration.written.isoformat(),
        "last_landing": None if last is None else last.isoformat(),
        "shortcomings": [{"quantity": defect.name, "reason": defect.state} for defect in shortcomings],
    }
    # The most fundamental first: another robot's, then incomplete or stale, then a landing that it lacks.
    if other := _of_others(evidence, calibration, evidence.origin):
        return no_go(
            other,
            Advice(
                "Name the certificate of this robot with --calibration, or calibrate: ",
                NextStep("calibrate show"),
            ),
            **numbers,
        )
    if shortcomings:
        commands = commands_of(shortcomings)
        return no_go(
            f"Calibration: incomplete for the next drop: {summarize_shortcomings(shortcomings)}.",
            join_steps(", ", commands)
            if len(commands) <= _NAMED
            else Advice(
                NextStep("calibrate show"),
                f" names all {len(commands)} commands; the first is: ",
                commands[0],
            ),
            **numbers,
        )
    if landed_unnoted(logger.status, logger.recording_since, logger.computer_unix_s, calibration):
        return no_go(
            "Calibration: older than a landing that the logger recorded.",
            Advice(
                NextStep("log fetch", ("all",)),
                ", then next to the certificate ",
                NextStep("decode", ("FILE",)),
                " with the fetched recording; then calibrate.",
            ),
            **numbers,
        )
    newest = max(
        (quantity.measured_at for quantity in quantities(calibration) if quantity.measured_at),
        default=calibration.written,
    )
    return go(
        "Calibration: complete, of these sensors, newer than any known landing; last measured "
        f"{newest.astimezone(UTC):%Y-%m-%d %H:%M} UTC.",
        **numbers,
    )


def _of_others(evidence: Evidence, calibration: Calibration, origin: Origin) -> str:
    """Empty if it is of these sensors."""
    subject = calibration.subject
    if other := of_another_robot(subject, origin):
        return other
    if subject.robot != evidence.robot.name:
        return f"It is of the robot {subject.robot}; the robot file is of {evidence.robot.name}."
    # One that does not answer at all (00) is found by the check of the gyros.
    current_ids = bytes.fromhex(origin.who_am_i)
    changed = [str(body) for body in exchanged_imus(subject, origin.who_am_i) if current_ids[body - 1]]
    if changed:
        return f"The IMU of body {' and '.join(changed)} is of another kind than the one that was calibrated."
    return ""


def landed_unnoted(
    status: LoggerStatusReply,
    recording_since: datetime | None,
    computer_unix_s: float,
    calibration: Calibration | Missing,
) -> bool:
    """Return whether a recording ended in a landing that the certificate does not have.

    The recording is the last one since power-up, begun at `recording_since` (None: the logger's clock was not
    set); the certificate has no landing since. `computer_unix_s` is the computer's time of day when the
    status came.
    """
    if status.phase != DropPhase.LANDED:
        return False
    last = None if isinstance(calibration, Missing) else calibration.last_landing
    # Without a time of day the landing was at some time since the power came on.
    since = recording_since or datetime.fromtimestamp(computer_unix_s - status.uptime_ms / 1000, UTC)
    return last is None or last < since
