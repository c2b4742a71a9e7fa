"""What `monitor` shows of the boards: as JSON, as one line, and as a picture for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.cli.board_state import switch_words, switches_closed, with_fault

if TYPE_CHECKING:
    from rich.console import RenderableType

    from tfsat_host.cli.monitor_boards import LoggerWatch, SequencerWatch
    from tfsat_host.monitoring.reading import BodyRate, JointReading

UNCALIBRATED = (
    "Rates as the gyros read them, bias and mounting included. "
    "Joint angles by the robot file's zeros: uncalibrated."
)


def sequencer_as_dict(watch: SequencerWatch) -> dict[str, Any]:
    """For `--json`."""
    status = watch.status
    return {
        "state": status.state.name.lower(),
        "fault": status.fault.name.lower(),
        "last_refusal": status.last_refusal.name.lower(),
        "switches_closed": switches_closed(status.switches_open),
        "knocks": status.knocks,
        "strokes_started": status.strokes_started,
        "resets_while_armed": status.resets_while_armed,
        "commanded_deg": [angle_cdeg / 100 for angle_cdeg in status.joint_angle_cdeg],
        "uptime_s": status.uptime_ms / 1000,
    }


def logger_as_dict(watch: LoggerWatch) -> dict[str, Any]:
    """For `--json`."""
    status, reading = watch.status, watch.reading
    return {
        "state": status.state.name.lower(),
        "error": status.error.name.lower(),
        "switches_closed": switches_closed(status.switches_open),
        "session": f"{status.session:08x}",
        "samples": status.samples,
        "samples_dropped": status.samples_dropped,
        "rate_hz": status.rate_hz,
        "measured_rate_hz": watch.meter.rate_hz,
        "live_missed": watch.meter.missed,
        "live_gaps": watch.meter.gaps,
        "bodies": [
            {"rate_deg_s": body.rate_deg_s, "valid": body.valid, "clipped": body.clipped}
            for body in (reading.bodies if reading else ())
        ],
        "angle_sensors": [
            {
                "joint": sensor.joint,
                "sensor_deg": sensor.sensor_deg,
                "joint_deg_uncalibrated": sensor.joint_deg,
                "valid": sensor.valid,
            }
            for sensor in (reading.angles if reading else ())
        ],
    }


def sequencer_rows(watch: SequencerWatch) -> list[tuple[str, str]]:
    """Name and text of each line."""
    status = watch.status
    resets = f", {status.resets_while_armed} restarts while armed" if status.resets_while_armed else ""
    commanded = ", ".join(
        f"{joint} {angle_cdeg / 100:.2f}°" for joint, angle_cdeg in enumerate(status.joint_angle_cdeg, 1)
    )
    return [
        ("state", with_fault(status.state.name.lower(), status.fault.name.lower()) + resets),
        ("switches", switch_words(status.switches_open)),
        ("last refusal", status.last_refusal.name.lower().replace("_", " ")),
        ("knocks", str(status.knocks)),
        ("strokes", f"{status.strokes_started} of the last run"),
        ("commanded", commanded),
    ]


def logger_rows(watch: LoggerWatch) -> list[tuple[str, str]]:
    """Likewise."""
    status, meter = watch.status, watch.meter
    recording = "none since the start"
    if status.session:
        recording = (
            f"session {status.session:08x}, {status.samples} samples, {status.samples_dropped} dropped"
        )
    measured = "–" if meter.rate_hz is None else f"{meter.rate_hz:.1f}"
    return [
        ("state", with_fault(status.state.name.lower(), status.error.name.lower())),
        ("switches", switch_words(status.switches_open)),
        ("recording", recording),
        (
            "sampling",
            f"{measured} Hz measured, {status.rate_hz} Hz set; on their way here {meter.missed} lost in "
            f"{meter.gaps} gaps",
        ),
    ]


def one_line(t_s: float, sequencer: SequencerWatch | None, logger: LoggerWatch | None) -> str:
    """All of it, short, for what is no terminal."""
    parts = [f"{t_s:.1f} s"]
    if sequencer is not None:
        status = sequencer.status
        parts.append(
            f"sequencer {with_fault(status.state.name.lower(), status.fault.name.lower())}, "
            f"switches {switch_words(status.switches_open)}, knocks {status.knocks}, "
            f"strokes {status.strokes_started}, last refusal {status.last_refusal.name.lower()}"
        )
    if logger is not None:
        meter, reading = logger.meter, logger.reading
        rate = "–" if meter.rate_hz is None else f"{meter.rate_hz:.1f}"
        parts.append(f"logger {logger.status.state.name.lower()}, {rate} Hz, {meter.missed} lost")
        if reading is not None:
            rates = "; ".join(f"{body} {_rates(rate)}" for body, rate in enumerate(reading.bodies, 1))
            parts.append(f"rates/(deg/s) {rates}")
            parts.append(f"joints/deg (uncalibrated) {_joints(reading.angles)}")
    return " | ".join(parts)


def _rates(body: BodyRate) -> str:
    if not body.valid:
        return "MISSING"
    return " ".join(f"{rate:+.1f}" for rate in body.rate_deg_s) + (" CLIPPED" if body.clipped else "")


def _joints(angles: tuple[JointReading, ...]) -> str:
    joints = sorted({sensor.joint for sensor in angles})
    return "; ".join(
        f"{joint} "
        + " / ".join(
            f"{sensor.joint_deg:+.1f}" if sensor.valid else "MISSING"
            for sensor in angles
            if sensor.joint == joint
        )
        for joint in joints
    )


def picture(sequencer: SequencerWatch | None, logger: LoggerWatch | None, lost: list[str]) -> RenderableType:
    """For a terminal, drawn anew in place."""
    from rich.console import Group
    from rich.text import Text

    parts: list[RenderableType] = []
    for watch, rows in (
        (sequencer, sequencer_rows(sequencer) if sequencer else []),
        (logger, logger_rows(logger) if logger else []),
    ):
        if watch is not None:
            parts.append(Text(f"{watch.name}  {watch.port}, {watch.identity.describe()}", style="bold"))
            parts += [Text(f"  {name:<13} {text}") for name, text in rows]
    if logger is not None and logger.reading is not None:
        parts += [
            _bodies_table(logger.reading.bodies),
            _angles_table(logger.reading.angles),
            Text(UNCALIBRATED),
        ]
    parts += [Text(text, style="bold red") for text in lost]
    parts.append(Text("Ctrl-C ends it."))
    return Group(*parts)


def _bodies_table(bodies: tuple[BodyRate, ...]) -> RenderableType:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("body", "x / deg/s", "y / deg/s", "z / deg/s"):
        table.add_column(title, justify="right", min_width=9)
    table.add_column("gyro")
    for number, body in enumerate(bodies, 1):
        said = "MISSING" if not body.valid else "CLIPPED" if body.clipped else "ok"
        rates = [f"{rate:+.1f}" if body.valid else "–" for rate in body.rate_deg_s]
        table.add_row(str(number), *rates, said)
    return table


def _angles_table(angles: tuple[JointReading, ...]) -> RenderableType:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("joint", "angle / deg", "as read / deg"):
        table.add_column(title, justify="right", min_width=9)
    table.add_column("angle sensor")
    for sensor in angles:
        shown = [f"{sensor.joint_deg:+.1f}", f"{sensor.sensor_deg:.1f}"] if sensor.valid else ["–", "–"]
        table.add_row(str(sensor.joint), *shown, "ok" if sensor.valid else "MISSING")
    return table
