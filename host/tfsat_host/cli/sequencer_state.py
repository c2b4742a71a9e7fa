"""What the sequencer says of itself, as JSON and as lines for people."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.board_state import Rows, switch_words, switches_closed, with_fault
from tfsat_host.cli.output import error_as_dict
from tfsat_host.cli.servo_words import origin_words, servo_words, settings_as_dict
from tfsat_host.devices.arm_refusal import arm_refusal
from tfsat_host.devices.last_run import LastRun, last_run
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.units import US_PER_S

if TYPE_CHECKING:
    from tfsat_host.devices.board_errors import BoardError
    from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, StoredSettings
    from tfsat_host.protocol.messages import SequencerStatusReply

MOST_RESETS = 255
"""As many as the board counts."""
_MAY_BE_ARMED = (SequencerState.SAFE, SequencerState.DONE, SequencerState.FAULT)


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
        refusal = arm_refusal(status, maneuver, settings.settings)
        return cls(status, maneuver, settings, last_run(report, status, maneuver), refusal)

    @property
    def attention(self) -> list[str]:
        """What must not be overlooked, one sentence each."""
        status = self.status
        if not status.resets_while_armed:
            return []
        count = f"{status.resets_while_armed} time{'s' if status.resets_while_armed > 1 else ''}"
        if status.resets_while_armed >= MOST_RESETS:
            count = f"{MOST_RESETS} times or more"
        after = " and is ARMED again" if status.state == SequencerState.ARMED else ""
        return [
            f"It restarted {count} while armed{after}; the last cause: {_cause(status)}. "
            "Find out why before the drop: a restart during the fall ends the maneuver."
        ]


def sequencer_state(board: SequencerClient) -> tuple[dict[str, Any], Rows]:
    """The board's self-report. Raises what its requests raise."""
    report = SelfReport.ask(board)
    natively = board.identity.runs_natively
    return _as_dict(report, natively=natively), _as_rows(report, natively=natively)


def _as_dict(report: SelfReport, *, natively: bool) -> dict[str, Any]:
    status = report.status
    told = status.state != SequencerState.SAFE
    return {
        "state": status.state.name.lower(),
        "attention": report.attention,
        "fault": status.fault.name.lower(),
        "fault_explained": _explained(status.fault),
        "last_refusal": status.last_refusal.name.lower(),
        "last_refusal_explained": _explained(status.last_refusal),
        "arm_refusal": None if report.refusal is None else error_as_dict(report.refusal),
        "switches_closed": switches_closed(status.switches_open),
        "reset_cause": status.reset_cause.name.lower(),
        "resets_while_armed": status.resets_while_armed,
        "strokes_started": status.strokes_started,
        "knocks": status.knocks,
        "joint_angle_deg": [angle_cdeg / 100 for angle_cdeg in status.joint_angle_cdeg] if told else None,
        "uptime_s": status.uptime_ms / 1000,
        "image_crc": f"{status.image_crc:08x}",
        "ram_never_used_bytes": None if natively else status.ram_never_used_bytes,
        "frames_rejected": status.frames_rejected,
        "maneuver": _maneuver_as_dict(report.maneuver),
        "run": None if report.run is None else _run_as_dict(report.run),
        "settings": {
            "origin": report.settings.origin.name.lower(),
            "generation": report.settings.generation,
            **settings_as_dict(report.settings.settings),
        },
    }


def _explained(code: ErrorCode) -> dict[str, str] | None:
    if code == ErrorCode.NONE:
        return None
    return dict(zip(("what", "meaning", "next_step"), REMEDIES[code], strict=True))


def _maneuver_as_dict(stored: StoredManeuver) -> dict[str, Any]:
    return {
        "origin": stored.origin.name.lower(),
        "strokes": [
            {"t_s": start_us / US_PER_S, "joint": joint, "angle_deg": angle_cdeg / 100}
            for joint, angle_cdeg, start_us in stored.strokes
        ],
        "end_s": round(Fraction(stored.end_us, US_PER_S) * 100) / 100,
        "end_us": stored.end_us,
        "crc": f"{stored.crc:04x}",
    }


def _run_as_dict(run: LastRun) -> dict[str, Any]:
    return {
        "released_uptime_s": run.released_us / US_PER_S,
        "since_release_s": run.since_release_s,
        "bounces": run.bounces,
        "strokes": [
            {"start_us": onset.start_us, "scheduled_us": onset.scheduled_us, "error_us": onset.error_us}
            for onset in run.onsets
        ],
    }


def _as_rows(report: SelfReport, *, natively: bool) -> Rows:
    status = report.status
    rows = [("  state", with_fault(status.state.name.lower(), status.fault.name.lower()))]
    rows += [("  ATTENTION", text) for text in report.attention]
    if status.fault != ErrorCode.NONE:
        what, meaning, cure = REMEDIES[status.fault]
        rows += [("  fault", what), ("    means", meaning), ("    cure", cure)]
    if status.state in _MAY_BE_ARMED:
        rows.append(("  arming", _arming(report.refusal)))
    if status.last_refusal != ErrorCode.NONE:
        rows.append(("  last refusal", " ".join(REMEDIES[status.last_refusal])))
    rows.append(("  maneuver", _maneuver_words(report.maneuver)))
    rows += _servo_rows(report)
    rows += [
        ("  switches", switch_words(status.switches_open)),
        ("  knocks", str(status.knocks)),
        ("  last start", f"{_cause(status)}, {status.uptime_ms / 1000:.0f} s ago"),
    ]
    rows += _run_rows(report.run)
    if not natively:
        rows.append(("  memory", f"{status.ram_never_used_bytes} bytes of RAM never used"))
    rows.append(("  link", f"{status.frames_rejected} damaged frames since the last start"))
    return rows


def _arming(refusal: BoardError | None) -> str:
    if refusal is None:
        return "nothing stands against it"
    return f"would be refused. {refusal.what} {refusal.next_step}"


def _maneuver_words(stored: StoredManeuver) -> str:
    strokes = ", ".join(
        f"{start_us / US_PER_S:.2f} s joint {joint} {angle_cdeg / 100:+g}°"
        for joint, angle_cdeg, start_us in stored.strokes
    )
    return f"{strokes} ({stored.origin.name.lower()})"


def _servo_rows(report: SelfReport) -> Rows:
    settings = report.settings.settings
    angles = ", ".join(f"{angle_cdeg / 100:g}°" for angle_cdeg in report.status.joint_angle_cdeg)
    doing = {
        SequencerState.SAFE: "limp",
        SequencerState.JOGGING: f"one joint is moved, told {angles}; the others are limp",
    }.get(report.status.state, f"told to hold {angles}")
    summary = f"{origin_words(report.settings.origin)}, a pulse each {settings.frame_us / 1000:g} ms; {doing}"
    joints = [(f"    joint {joint}", servo_words(servo)) for joint, servo in enumerate(settings.servos, 1)]
    return [("  servos", summary), *joints]


def _run_rows(run: LastRun | None) -> Rows:
    if run is None:
        return [("  last run", "none since the last start")]
    edge = f"released {run.released_us / US_PER_S:.6f} s after the start, {run.since_release_s:.1f} s ago"
    rows = [("  last run", f"{edge}; {run.bounces} edges of bounce")]
    for number, onset in enumerate(run.onsets, 1):
        error = (
            "its schedule is not on the board any more"
            if onset.error_us is None
            else f"{onset.error_us:+d} us from the schedule"
        )
        rows.append((f"    stroke {number}", f"began at {onset.start_us / US_PER_S:.6f} s, {error}"))
    return rows


def _cause(status: SequencerStatusReply) -> str:
    return status.reset_cause.name.lower().replace("_", " ")
