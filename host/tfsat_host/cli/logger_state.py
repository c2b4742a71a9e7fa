"""What the logger says of itself, as JSON and as lines for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.cli.board_state import Rows, switch_words, switches_closed, with_fault

if TYPE_CHECKING:
    from tfsat_host.devices.logger import LoggerClient


def logger_state(board: LoggerClient) -> tuple[dict[str, Any], Rows]:
    """State, sensors, switches and the recording. Raises what its requests raise."""
    status = board.status()
    present = [bool(status.imu_present >> bit & 1) for bit in range(4)]
    state: dict[str, Any] = {
        "state": status.state.name.lower(),
        "error": status.error.name.lower(),
        "imu_present": present,
        "switches_closed": switches_closed(status.switches_open),
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
        ("  state", with_fault(state["state"], state["error"])),
        ("  IMUs", imus),
        ("  switches", switch_words(status.switches_open)),
        ("  recording", f"{status.samples} samples, {status.samples_dropped} dropped, {status.rate_hz} Hz"),
    ]
    return state, lines
