"""Time of day and pace of the clocks: what a recording's date and a stroke's moment rest on."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from tfsat_host.preflight.check import Check, go, no_go, not_made
from tfsat_host.preflight.evidence import Evidence, Missing, Pace, unreached
from tfsat_host.units import US_PER_S

EARLIEST = datetime(2026, 1, 1, tzinfo=UTC)
"""This program is not older."""
BEHIND = timedelta(minutes=1)
"""By so much two computers of one team may differ."""
MOST_APART_S = 2.0
"""Between logger and computer: landings and calibrations are ordered by it, and minutes lie between them."""
_SHOWN_S = 0.1
MOST_PACE = 5e-3
"""Relative. Crystals are within 1e-4; by 5e-3 the last stroke would come 11 ms off, one sample period and the next."""
_SET = "tfsat-host logger-settings set --clock"


def check_clock(evidence: Evidence) -> Check:
    """The computer's time of day can be right, and the logger has it."""
    name = "clock"
    now = evidence.now
    numbers: dict[str, object] = {"computer": now.astimezone(UTC).isoformat()}
    behind = _behind(evidence)
    if behind:
        return no_go(name, behind, "Set this computer's clock, then the logger's: " + _SET, **numbers)
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    status = evidence.logger.status
    if not status.unix_us:
        return no_go(
            name,
            "Nobody has told the logger the time of day since its power came on.",
            _SET,
            **numbers,
            logger=None,
        )
    apart_s = status.unix_us / US_PER_S - evidence.logger.computer_unix_s
    numbers["logger_apart_s"] = apart_s
    if abs(apart_s) > MOST_APART_S:
        return no_go(name, f"The logger's clock is {apart_s:+.1f} s off this computer's.", _SET, **numbers)
    beside = f"within {_SHOWN_S} s of" if abs(apart_s) < _SHOWN_S else f"{apart_s:+.1f} s off"
    return go(name, f"{now.astimezone(UTC):%Y-%m-%d %H:%M} UTC; the logger's is {beside} it.", **numbers)


def _behind(evidence: Evidence) -> str:
    """Why the computer's clock cannot be right; empty: nothing is known against it."""
    known = [(EARLIEST, "this program")]
    if not isinstance(evidence.calibration, Missing):
        known.append((evidence.calibration.written, f"the certificate {evidence.calibration_file}"))
    if evidence.newest_file is not None:
        known.append(evidence.newest_file)
    newest, whose = max(known)
    if evidence.now >= newest - BEHIND:
        return ""
    return (
        f"This computer's clock says {evidence.now.astimezone(UTC):%Y-%m-%d %H:%M} UTC; "
        f"{whose} is of {newest.astimezone(UTC):%Y-%m-%d %H:%M} UTC."
    )


def check_paces(evidence: Evidence) -> Check:
    """Neither board's clock runs fast or slow by more than half a percent, over this preflight."""
    name = "clock-pace"
    if isinstance(evidence.sequencer, Missing):
        return unreached(name, evidence.sequencer)
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    paces = {"sequencer": evidence.sequencer.pace, "logger": evidence.logger.pace}
    said, numbers = [], {}
    for board, pace in paces.items():
        if pace is None:
            return not_made(name, f"The {board} restarted meanwhile.", "See restarts.")
        off, doubt = _off(pace)
        numbers[f"{board}_off_ppm"] = 1e6 * off
        numbers[f"{board}_doubt_ppm"] = 1e6 * doubt
        if doubt >= MOST_PACE:
            return not_made(
                name,
                f"The {board} answered too slowly to compare its clock: it is known to {100 * doubt:.1f} % only.",
                "Plug it in without a hub, and run this preflight again.",
                **numbers,
            )
        if abs(off) - doubt > MOST_PACE:
            said.append(f"the {board}'s runs {100 * abs(off):.1f} % {'fast' if off > 0 else 'slow'}")
    if said:
        return no_go(
            name,
            f"Of the boards' clocks {'; '.join(said)} ({100 * MOST_PACE:g} % is allowed).",
            "Replace that board: strokes and samples would come at other times than they say.",
            **numbers,
        )
    return go(name, f"Both boards' clocks run within {100 * MOST_PACE:g} % of this computer's.", **numbers)


def _off(pace: Pace) -> tuple[float, float]:
    """How much faster the board's clock runs, and how far that is unsure; relative."""
    if pace.computer_s <= 0.0:
        return 0.0, 1.0
    return pace.board_s / pace.computer_s - 1.0, pace.doubt_s / pace.computer_s
