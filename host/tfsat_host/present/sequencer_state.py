"""What the sequencer reports of itself: its columns for JSON and for people."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from tfsat_host.devices.arm_refusal import arm_refusal, store_defects
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.last_run import LastRun, Onset, StrokeStatus, last_run
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, StoredSettings
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import refusal_name
from tfsat_host.present.stored_settings import (
    MANEUVER,
    STORED_SETTINGS,
    maneuver_words,
    origin_words,
    servo_words,
)
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import JOINT_COUNT, MAX_STROKES, SWITCH_COUNT
from tfsat_host.protocol.messages import SequencerStatusReply
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.units import US_PER_S

MAX_RESETS = 255
"""As many as the board counts."""
# Typical levels of the ATmega32U4's BODLEVEL fuses, from 000 on.
BROWN_OUT_V = (4.3, 3.5, 3.4, 2.6, 2.4, 2.2, 2.0, None)
"""By the brown_out_level of the board's status; None: the detector is off."""
_MAY_BE_ARMED = (SequencerState.SAFE, SequencerState.DONE, SequencerState.FAULT)
_ARMED_ALREADY = (SequencerState.ARMED, SequencerState.RUNNING)


@dataclass(frozen=True, slots=True)
class SequencerReport:
    """All that the sequencer says of itself at one time.

    Attributes:
        device: Port and identity.
        status: Its state.
        maneuver: What would fly.
        settings: Of the servos.
        run: The last one since power was switched on; None: there was none.
        refusal: What the board would answer to ARM; None: it would accept, or is armed already.
    """

    device: Device
    status: SequencerStatusReply
    maneuver: StoredManeuver
    settings: StoredSettings
    run: LastRun | None
    refusal: BoardError | None

    @classmethod
    def ask(cls, board: SequencerClient) -> SequencerReport:
        """Ask for everything. Raises what the requests raise."""
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
        return cls(
            board.device(),
            status,
            maneuver,
            settings,
            last_run(report, status, maneuver),
            refusal,
        )

    @property
    def natively(self) -> bool:
        """Whether it is no board but the core on a computer: without image, stack of its own and fuses."""
        return self.device.identity.runs_natively

    @property
    def may_be_armed(self) -> bool:
        """Whether ARM would be taken in this state, as far as the sequencer alone decides."""
        return self.status.state in _MAY_BE_ARMED and self.refusal is None

    @property
    def attention(self) -> list[str]:
        """Urgent warnings, one text each."""
        return list(_attention(self.status))


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


def _state_words(report: SequencerReport) -> str:
    status = report.status
    state = with_fault(status.state.name.lower(), status.fault.name.lower())
    return f"{state}, release switches: {switch_words(status.switches_open)}"


def _fault_words(report: SequencerReport) -> str:
    return "" if report.status.fault == ErrorCode.NONE else " ".join(REMEDIES[report.status.fault][:2])


def _last_refusal_words(report: SequencerReport) -> str:
    code = report.status.last_refusal
    if code == ErrorCode.NONE:
        return ""
    what = REMEDIES[code][0]
    return f"at the last ARM that the board itself refused: {what[:1].lower()}{what[1:-1]} ({refusal_name(code)})"


def _servos_words(report: SequencerReport) -> str:
    frame = f"a pulse each {report.settings.settings.frame_us / 1000:g} ms"
    return f"{_commanded_text(report.status)}; {origin_words(report.settings.origin)}, {frame}"


def _last_start_words(report: SequencerReport) -> str:
    return f"{_cause(report.status)}, {report.status.uptime_ms / 1000:.0f} s ago"


def _last_run_words(report: SequencerReport) -> str:
    """Describe release and extent of the last run, and how far off the origin of all its times may be."""
    run = report.run
    if run is None:
        return "none since power was switched on"
    text = "; ".join(
        [_release_text(run), *_extent(run, report.status.state), f"{run.bounces} edges of bounce"]
    )
    # Bounce may be read as two releases.
    if run.earlier_us or run.later_us:
        text += (
            ". ATTENTION: the switches' edges fit more than one release: the robot may have left up to "
            f"{run.earlier_us / 1000:.1f} ms before or {run.later_us / 1000:.1f} ms after it"
        )
    return text


def _servo_words(report: SequencerReport, index: int) -> str:
    return servo_words(report.settings.settings.servos[index])


def _stroke_words(report: SequencerReport, index: int) -> str:
    onsets = () if report.run is None else report.run.onsets
    return _stroke(onsets[index], report.status.state) if index < len(onsets) else ""


def _commanded_text(status: SequencerStatusReply) -> str:
    angles_deg = _joint_angles_deg(status)
    if not status.servos_driven:
        return "limp"
    # A jog drives the servos that it moves, and no others.
    if status.state == SequencerState.JOGGING:
        moved = ", ".join(
            f"joint {joint} moving, commanded to {angle_deg:g} deg"
            for joint, angle_deg in enumerate(angles_deg, 1)
            if angle_deg is not None
        )
        return f"{moved}; others limp"
    angles = ("limp" if angle_deg is None else f"{angle_deg:g} deg" for angle_deg in angles_deg)
    return f"holding {', '.join(angles)} (commanded)"


def _cause(status: SequencerStatusReply) -> str:
    return status.reset_cause.name.lower().replace("_", " ")


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


def _of_image(value: Callable[[SequencerReport], Any]) -> Callable[[SequencerReport], Any]:
    """Return the value, and None of a core that runs natively."""
    return lambda report: None if report.natively else value(report)


_RUN: Columns = (
    *fields("released_uptime_s=released_us since_release_s bounces strokes_missed=missed"),
    Column("release_interval_us", of=lambda run: [-run.earlier_us, run.later_us]),
    Column("strokes_planned", of=lambda run: len(run.onsets)),
    Column("strokes", of="onsets", columns=fields("state=booking.value start_us scheduled_us error_us")),
)
"""The release, and each stroke with its schedule; null where that is not known."""
SEQUENCER: Columns = (
    *fields(
        "state=status.state fault=status.fault last_refusal=status.last_refusal knocks=status.knocks "
        "false_releases=status.false_releases resets_while_armed=status.resets_while_armed "
        "strokes_started=status.strokes_started uptime_s=status.uptime_ms"
    ),
    Column("fault_explained", of=lambda board: explain_code(board.status.fault)),
    Column("last_refusal_explained", of=lambda board: explain_code(board.status.last_refusal)),
    Column("switches_closed", of=lambda board: switches_closed(board.status.switches_open)),
)
"""For JSON, of whatever has a sequencer's `status`."""
SEQUENCER_JSON: Columns = (
    *SEQUENCER,
    Column("device", columns=DEVICE),
    *fields("attention reset_cause=status.reset_cause frames_rejected=status.frames_rejected"),
    Column("joint_angle_deg", of=lambda report: _joint_angles_deg(report.status)),
    Column("image_crc", of=_of_image(lambda report: f"{report.status.image_crc:08x}")),
    Column("ram_never_used_bytes", of=_of_image(lambda report: report.status.ram_never_used_bytes)),
    Column("brown_out_v", of=_of_image(lambda report: BROWN_OUT_V[report.status.brown_out_level])),
    Column(
        "stores_damaged",
        of=lambda report: {
            store: code == ErrorCode.STORE_DAMAGED
            for store, code in store_defects(report.status.stores_damaged).items()
        },
    ),
    Column(
        "stores_refused",
        of=lambda report: {
            store: code.name.lower() for store, code in store_defects(report.status.stores_damaged).items()
        },
    ),
    Column("maneuver", columns=MANEUVER),
    Column("run", columns=_RUN),
    Column("settings", columns=STORED_SETTINGS),
)
"""A whole report for JSON."""
SEQUENCER_FACTS: Columns = (
    Column("", "Sequencer", words=_state_words),
    Column("", "Fault", words=_fault_words),
    Column("", "Maneuver", words=lambda report: maneuver_words(report.maneuver)),
    Column("", "Servos", words=_servos_words),
    Column("", "Last run", words=_last_run_words),
    Column("", "Last start", words=_last_start_words),
)
"""What a person reads first."""
SEQUENCER_DETAILS: Columns = (
    Column("", "Sequencer port", words=lambda report: report.device.describe()),
    *(
        Column("", f"Servo of joint {index + 1}", words=partial(_servo_words, index=index))
        for index in range(JOINT_COUNT)
    ),
    *(
        Column("", f"Stroke {index + 1}", words=partial(_stroke_words, index=index))
        for index in range(MAX_STROKES)
    ),
    Column("", "Last refusal", words=_last_refusal_words),
    Column(
        "",
        "False triggers",
        words=lambda report: f"{report.status.knocks}; false releases: {report.status.false_releases}",
    ),
    Column(
        "",
        "Memory",
        words=lambda report: (
            "" if report.natively else f"{report.status.ram_never_used_bytes} bytes of RAM never used"
        ),
    ),
    Column(
        "",
        "Link",
        words=lambda report: f"{report.status.frames_rejected} damaged frames since the last start",
    ),
)
"""The rest."""
