"""What the sequencer reports of itself, as JSON and as lines for people."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tfsat_host.devices.arm_refusal import arm_refusal, store_defects
from tfsat_host.devices.last_run import LastRun, Onset, StrokeStatus, last_run
from tfsat_host.json_values import error_as_dict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import refusal_name
from tfsat_host.present.stored_settings import (
    maneuver_as_dict,
    maneuver_words,
    origin_words,
    servo_words,
    settings_as_dict,
)
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import Column, Columns, fields, json_objects, record
from tfsat_host.units import US_PER_S

if TYPE_CHECKING:
    from tfsat_host.devices.client import BoardError
    from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, StoredSettings
    from tfsat_host.protocol.messages import SequencerStatusReply

Rows = list[tuple[str, str]]
"""Name and text of each line; a name that is indented belongs to the line before it."""


RUN: Columns = (
    *fields("released_uptime_s=released_us since_release_s bounces strokes_missed=missed"),
    Column("release_interval_us", of=lambda run: [-run.earlier_us, run.later_us]),
    Column("strokes_planned", of=lambda run: len(run.onsets)),
    Column("strokes", of="onsets", columns=fields("state=booking.value start_us scheduled_us error_us")),
)
"""For JSON: the release, and each stroke with its schedule; null where that is not known."""
MAX_RESETS = 255
"""As many as the board counts."""
# Typical levels of the ATmega32U4's BODLEVEL fuses, from 000 on.
BROWN_OUT_V = (4.3, 3.5, 3.4, 2.6, 2.4, 2.2, 2.0, None)
"""By the brown_out_level of the board's status; None: the detector is off."""
READY_TO_ARM = "ready to arm"
_MAY_BE_ARMED = (SequencerState.SAFE, SequencerState.DONE, SequencerState.FAULT)
_ARMED_ALREADY = (SequencerState.ARMED, SequencerState.RUNNING)


@dataclass(frozen=True, slots=True)
class SelfReport:
    """All that the sequencer says of itself at one time."""

    status: SequencerStatusReply
    maneuver: StoredManeuver
    settings: StoredSettings
    run: LastRun | None
    refusal: BoardError | None

    @classmethod
    def ask(cls, board: SequencerClient) -> SelfReport:
        """Asks for everything. Raises what the requests raise."""
        status, report, maneuver, settings = (
            board.status(),
            board.run_report(),
            board.read_back(),
            board.settings(),
        )
        refusal = None
        # Foretell by the board's own rules what ARM would refuse; an armed board has passed them.
        if status.state not in _ARMED_ALREADY:
            refusal = arm_refusal(status, maneuver, settings.settings)
        return cls(status, maneuver, settings, last_run(report, status, maneuver), refusal)


def _attention(status: SequencerStatusReply) -> Iterator[str]:
    """Yield the urgent warnings, one text each."""
    armed = status.state == SequencerState.ARMED
    # One open switch is half of a release.
    if armed and status.switches_open:
        yield Advice(
            f"It is ARMED with {open_switches(status.switches_open)} open: the maneuver starts when both are. "
            "Stand clear and close it, or: ",
            NextStep("disarm"),
        )
    if armed and status.false_releases:
        yield (
            f"Since it was armed both switches opened and closed again for good {_times(status.false_releases)}: "
            "no release, nothing moved, and the next one flies all strokes. Find out what jolts the robot."
        )
    # A board that is armed again after a reset hides it: its count is all that shows.
    if status.resets_while_armed:
        most = f"{MAX_RESETS} times or more"
        count = most if status.resets_while_armed >= MAX_RESETS else _times(status.resets_while_armed)
        yield (
            f"It restarted {count} while armed{' and is ARMED again' if armed else ''}; the last cause: "
            f"{_cause(status)}. Find out why before the drop: a restart during the fall ends the maneuver."
        )
    # Only the highest level comes near the 4.5 V that 16 MHz needs.
    level_v = BROWN_OUT_V[status.brown_out_level]
    if level_v != BROWN_OUT_V[0]:
        resets = "never resets" if level_v is None else f"resets below {level_v} V only"
        yield (
            f"By its brown-out fuse it {resets} when the supply dips, and it needs 4.5 V at 16 MHz. In between it "
            "may do anything, in the fall too. Set the fuse, or fit a supervisor: docs/wiring.md, Brown-out."
        )


def _times(count: int) -> str:
    return f"{count} time{'s' if count > 1 else ''}"


def sequencer_state(board: SequencerClient) -> tuple[dict[str, Any], Rows]:
    """Read the board's self-report, as a dict and as rows. Raises what its requests raise."""
    report = SelfReport.ask(board)
    natively = board.identity.runs_natively
    return _as_dict(report, natively=natively), _as_rows(report, natively=natively)


def _as_dict(report: SelfReport, *, natively: bool) -> dict[str, Any]:
    status = report.status
    # Natively run, the core has no image, no stack of its own and no fuses: null below.
    stores = store_defects(status.stores_damaged)
    return {
        **record(_STATE, status),
        "attention": list(_attention(status)),
        "arm_refusal": None if report.refusal is None else error_as_dict(report.refusal),
        "image_crc": None if natively else f"{status.image_crc:08x}",
        "ram_never_used_bytes": None if natively else status.ram_never_used_bytes,
        "brown_out_v": None if natively else BROWN_OUT_V[status.brown_out_level],
        "stores_damaged": {store: code == ErrorCode.STORE_DAMAGED for store, code in stores.items()},
        "stores_refused": {store: code.name.lower() for store, code in stores.items()},
        "maneuver": maneuver_as_dict(report.maneuver),
        "run": json_objects(RUN, report.run),
        "settings": {
            **record(fields("origin generation"), report.settings),
            **settings_as_dict(report.settings.settings),
        },
    }


def explain_code(code: ErrorCode) -> dict[str, str | int] | None:
    """Explain a fault or refusal in words, for `--json`; None if there is none."""
    if code == ErrorCode.NONE:
        return None
    what, meaning, next_step = REMEDIES[code]
    return {"number": int(code), "what": what, "meaning": meaning, "next_step": next_step}


def _joint_angles_deg(status: SequencerStatusReply) -> list[float | None]:
    """Return the angle that each servo is commanded to hold, in deg; None if it is limp."""
    return [
        angle_cdeg / 100 if status.servos_driven >> index & 1 else None
        for index, angle_cdeg in enumerate(status.joint_angle_cdeg)
    ]


def _as_rows(report: SelfReport, *, natively: bool) -> Rows:
    status = report.status
    rows = [("  state", with_fault(status.state.name.lower(), status.fault.name.lower()))]
    rows += [("  ATTENTION", text) for text in _attention(status)]
    if status.fault != ErrorCode.NONE:
        what, meaning, cure = REMEDIES[status.fault]
        rows += [("  fault", what), ("    means", meaning), ("    cure", cure)]
    if status.state in _MAY_BE_ARMED:
        rows.append(("  arming", _arming_text(report.refusal)))
    if status.last_refusal != ErrorCode.NONE:
        rows.append(("  last refusal", _refused_then(status.last_refusal)))
    rows.append(("  maneuver", maneuver_words(report.maneuver)))
    rows += _servo_rows(report)
    rows += [
        ("  switches", switch_words(status.switches_open)),
        ("  knocks", f"{status.knocks}; false releases: {status.false_releases}"),
        ("  last start", f"{_cause(status)}, {status.uptime_ms / 1000:.0f} s ago"),
    ]
    rows += run_rows(report.run, status.state)
    if not natively:
        rows.append(("  memory", f"{status.ram_never_used_bytes} bytes of RAM never used"))
    rows.append(("  link", f"{status.frames_rejected} damaged frames since the last start"))
    return rows


def _arming_text(refusal: BoardError | None) -> str:
    if refusal is None:
        return READY_TO_ARM
    if refusal.code == ErrorCode.FAULT_LATCHED:
        return Advice(
            f"would be refused ({refusal_name(refusal.code)}) until the fault is cleared: ",
            NextStep("disarm"),
        )
    return Advice(f"would be refused ({refusal_name(refusal.code)}). {refusal.what} ", refusal.next_step)


def _refused_then(code: ErrorCode) -> str:
    what = REMEDIES[code][0]
    return f"at the last ARM that the board itself refused: {what[:1].lower()}{what[1:-1]} ({refusal_name(code)})"


def _servo_rows(report: SelfReport) -> Rows:
    settings = report.settings.settings
    frame = f"a pulse each {settings.frame_us / 1000:g} ms"
    summary = f"{origin_words(report.settings.origin)}, {frame}; {_commanded_text(report.status)}"
    joints = [(f"    joint {joint}", servo_words(servo)) for joint, servo in enumerate(settings.servos, 1)]
    return [("  servos", summary), *joints]


def _commanded_text(status: SequencerStatusReply) -> str:
    angles_deg = _joint_angles_deg(status)
    if not status.servos_driven:
        return "limp"
    # A jog drives the servos that it moves, and no others.
    if status.state == SequencerState.JOGGING:
        moved = ", ".join(
            f"joint {joint} is moved, commanded to {angle_deg:g}°"
            for joint, angle_deg in enumerate(angles_deg, 1)
            if angle_deg is not None
        )
        return f"{moved}; the others are limp"
    return "commanded to hold " + ", ".join(
        "nothing (limp)" if angle_deg is None else f"{angle_deg:g}°" for angle_deg in angles_deg
    )


def _cause(status: SequencerStatusReply) -> str:
    return status.reset_cause.name.lower().replace("_", " ")


SEQUENCER: Columns = (
    *fields("state fault last_refusal knocks false_releases resets_while_armed"),
    Column("fault_explained", of=lambda status: explain_code(status.fault)),
    Column("last_refusal_explained", of=lambda status: explain_code(status.last_refusal)),
    Column("switches_closed", of=lambda status: switches_closed(status.switches_open)),
    Column("uptime_s", of="uptime_ms"),
)
"""Of a status, for JSON."""
_STATE: Columns = (
    *SEQUENCER,
    *fields("reset_cause strokes_started frames_rejected"),
    Column("joint_angle_deg", of=_joint_angles_deg),
)


def switches_closed(switches_open: int) -> list[bool]:
    """Return whether each release switch is closed, from the status bits."""
    return [not switches_open >> bit & 1 for bit in range(SWITCH_COUNT)]


def switch_words(switches_open: int) -> str:
    """Describe the state of each release switch for people."""
    return ", ".join(
        f"{number} {'closed' if closed else 'OPEN'}"
        for number, closed in enumerate(switches_closed(switches_open), 1)
    )


def open_switches(switches_open: int) -> str:
    """Name the release switches that are open, such as `release switch 2`."""
    numbers = [str(number) for number, closed in enumerate(switches_closed(switches_open), 1) if not closed]
    return f"release switch{'es' if len(numbers) > 1 else ''} {' and '.join(numbers)}"


def with_fault(state: str, fault: str) -> str:
    """Format a state and its fault, if any."""
    return state if fault == "none" else f"{state}: {fault.replace('_', ' ')}"


def run_rows(run: LastRun | None, state: SequencerState) -> Rows:
    """Format the run as one row, and each stroke as one row."""
    if run is None:
        return [("  last run", "none since power was switched on")]
    rows = [
        (
            "  last run",
            "; ".join([_release_text(run), *_extent(run, state), f"{run.bounces} edges of bounce"]),
        )
    ]
    # Bounce may be read as two releases: say how far off the origin of all times may be.
    if run.earlier_us or run.later_us:
        rows.append(
            (
                "    ATTENTION",
                "the switches' edges fit two releases: the robot may have left up to "
                f"{run.earlier_us / 1000:.1f} ms before or {run.later_us / 1000:.1f} ms after it",
            )
        )
    return rows + [
        (f"    stroke {number}", _stroke(onset, state)) for number, onset in enumerate(run.onsets, 1)
    ]


def _stroke(onset: Onset, state: SequencerState) -> str:
    if onset.booking == StrokeStatus.MISSED:
        return "MISSED: no pulse of it came out on its servo's pin; the joint stayed where it was"
    if onset.booking == StrokeStatus.NOT_BEGUN:
        return "not yet" if state == SequencerState.RUNNING else "did not begin: the run ended before"
    if onset.start_us is None:
        return "began; a reset came before its time was stored"
    error = (
        "no stroke of the maneuver on the board is known to be this one"
        if onset.error_us is None
        else f"{onset.error_us:+d} us from the schedule"
    )
    return f"began at {onset.start_us / US_PER_S:.6f} s, {error}"


def _release_text(run: LastRun) -> str:
    edge = f"released {run.released_us / US_PER_S:.6f} s after the start"
    if run.since_release_s is None:
        return f"{edge} before the last reset, or since"
    return f"{edge}, {run.since_release_s:.1f} s ago"


def _extent(run: LastRun, state: SequencerState) -> list[str]:
    """Describe the extent of the run, unless it came to its end."""
    begun, planned = run.begun, len(run.onsets)
    missed = [f"{run.missed} of {planned} strokes MISSED"] if run.missed else []
    if state == SequencerState.RUNNING:
        return [f"{begun} of {planned} strokes so far", *missed]
    # Every stroke is accounted for: the run came to its end.
    if begun + run.missed == planned:
        return missed
    if begun == 0:
        return ["it ended before its first stroke"]
    return [f"it ended after {begun} of {planned} strokes", *missed]
