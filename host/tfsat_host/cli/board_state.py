"""What a board says of itself, as JSON and as lines for people."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient

Rows = list[tuple[str, str]]
US_PER_S = 1_000_000


def sequencer_state(board: SequencerClient) -> tuple[dict[str, Any], Rows]:
    """State, switches and the maneuver that would fly. Raises what its requests raise."""
    status = board.status()
    stored = board.read_back()
    state: dict[str, Any] = {
        "state": status.state.name.lower(),
        "fault": status.fault.name.lower(),
        "last_refusal": status.last_refusal.name.lower(),
        "switches_closed": _closed(status.switches_open),
        "reset_cause": status.reset_cause.name.lower(),
        "strokes_started": status.strokes_started,
        "knocks": status.knocks,
        "uptime_s": status.uptime_ms / 1000,
        "maneuver": {
            "origin": stored.origin.name.lower(),
            "strokes": [
                {"t_s": start_us / 1e6, "joint": joint, "angle_deg": angle_cdeg / 100}
                for joint, angle_cdeg, start_us in stored.strokes
            ],
            "end_s": round(Fraction(stored.end_us, US_PER_S) * 100) / 100,
            "end_us": stored.end_us,
            "crc": f"{stored.crc:04x}",
        },
    }
    strokes = ", ".join(
        f"{start_us / 1e6:.2f} s joint {joint} {angle_cdeg / 100:+g}°"
        for joint, angle_cdeg, start_us in stored.strokes
    )
    lines = [
        ("  state", _with_fault(state["state"], state["fault"])),
        ("  maneuver", f"{strokes} ({state['maneuver']['origin']})"),
        ("  switches", _switches(status.switches_open)),
        (
            "  last start",
            f"{status.reset_cause.name.lower().replace('_', ' ')}, {state['uptime_s']:.0f} s ago",
        ),
        ("  knocks", str(status.knocks)),
    ]
    return state, lines


def logger_state(board: LoggerClient) -> tuple[dict[str, Any], Rows]:
    """State, sensors, switches and the recording. Raises what its requests raise."""
    status = board.status()
    present = [bool(status.imu_present >> bit & 1) for bit in range(4)]
    state: dict[str, Any] = {
        "state": status.state.name.lower(),
        "error": status.error.name.lower(),
        "imu_present": present,
        "switches_closed": _closed(status.switches_open),
        "session": f"{status.session:08x}",
        "samples": status.samples,
        "samples_dropped": status.samples_dropped,
        "blocks_written": status.blocks_written,
        "ring_peak_blocks": status.ring_peak_blocks,
        "rate_hz": status.rate_hz,
        "uptime_s": status.uptime_ms / 1000,
    }
    imus = ", ".join(f"{body} {'ok' if here else 'MISSING'}" for body, here in enumerate(present, 1))
    lines = [
        ("  state", _with_fault(state["state"], state["error"])),
        ("  IMUs", imus),
        ("  switches", _switches(status.switches_open)),
        ("  recording", f"{status.samples} samples, {status.samples_dropped} dropped, {status.rate_hz} Hz"),
    ]
    return state, lines


def _closed(switches_open: int) -> list[bool]:
    return [not switches_open >> bit & 1 for bit in range(2)]


def _switches(switches_open: int) -> str:
    return ", ".join(
        f"{number} {'closed' if closed else 'OPEN'}"
        for number, closed in enumerate(_closed(switches_open), 1)
    )


def _with_fault(state: str, fault: str) -> str:
    return state if fault == "none" else f"{state}: {fault.replace('_', ' ')}"
