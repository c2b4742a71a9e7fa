"""What `monitor` says of the boards: as JSON, and as one line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.cli.board_state import switch_words, with_fault
from tfsat_host.cli.logger_state import LOGGER, RAM_HOLDS_DROP, attention, idle_part
from tfsat_host.cli.sequencer_state import SEQUENCER, explained
from tfsat_host.devices.card_trouble import file_was_full, state_words
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import Columns, fields, record, records

if TYPE_CHECKING:
    from tfsat_host.cli.monitor_boards import LoggerWatch, SequencerWatch
    from tfsat_host.monitoring.reading import BodyRate, JointReading
    from tfsat_host.protocol.messages import SequencerStatusReply

UNCALIBRATED = (
    "Rates as the gyros read them, bias and mounting included. "
    "Joint angles by the robot file's zeros: uncalibrated."
)

_SEQUENCER: Columns = (*SEQUENCER, *fields("strokes_started"))
_ANGLE_SENSOR = fields("joint sensor_deg joint_deg_uncalibrated=joint_deg valid")


def sequencer_as_dict(watch: SequencerWatch) -> dict[str, Any]:
    """For `--json`."""
    return {**record(_SEQUENCER, watch.status), "commanded_deg": commanded_deg(watch.status)}


def commanded_deg(status: SequencerStatusReply) -> list[float] | None:
    """What each servo is told; None: the servos are limp."""
    if not status.servos_driven:
        return None
    return [angle_cdeg / 100 for angle_cdeg in status.joint_angle_cdeg]


def logger_as_dict(watch: LoggerWatch) -> dict[str, Any]:
    """For `--json`."""
    status, reading = watch.status, watch.reading
    return {
        **record(LOGGER, status),
        "error_explained": None if file_was_full(status) else explained(status.error),
        "measured_rate_hz": watch.meter.rate_hz,
        "live_missed": watch.meter.missed,
        "live_gaps": watch.meter.gaps,
        "bodies": records(fields("rate_deg_s valid clipped"), reading.bodies if reading else ()),
        "angle_sensors": records(_ANGLE_SENSOR, reading.angles if reading else ()),
    }


def error_words(code: ErrorCode) -> str:
    """A fault or refusal for people: its name and its sentence."""
    if code == ErrorCode.NONE:
        return "none"
    return f"{code.name.lower().replace('_', ' ')}: {REMEDIES[code][0]}"


def one_line(t_s: float, sequencer: SequencerWatch | None, logger: LoggerWatch | None) -> str:
    """All of it, short, for what is no terminal."""
    parts = [f"{t_s:.1f} s"]
    if sequencer is not None:
        status = sequencer.status
        told = commanded_deg(status)
        servos = "limp" if told is None else " ".join(f"{angle_deg:.2f}" for angle_deg in told)
        parts.append(
            f"sequencer {with_fault(status.state.name.lower(), status.fault.name.lower())}, "
            f"switches {switch_words(status.switches_open)}, knocks {status.knocks}, "
            f"false releases {status.false_releases}, "
            f"strokes {status.strokes_started}, commanded {servos}, last refusal {error_words(status.last_refusal)}"
        )
    if logger is not None:
        meter, reading = logger.meter, logger.reading
        rate = "–" if meter.rate_hz is None else f"{meter.rate_hz:.1f}"
        state = state_words(logger.status)
        card = logger.status.card.name.lower().replace("_", " ")
        parts.append(f"logger {state}, card {card}, {rate} Hz, {meter.missed} lost")
        parts += attention(logger.status)
        if logger.status.ram_holds_drop:
            parts.append(f"RAM {RAM_HOLDS_DROP}")
        if reading is not None:
            rates = "; ".join(
                f"{index + 1} {_rates(body, idle_part(logger.status, index))}"
                for index, body in enumerate(reading.bodies)
            )
            parts.append(f"rates/(deg/s) {rates}")
            parts.append(f"joints/deg (uncalibrated) {_joints(reading.angles)}")
    return " | ".join(parts)


def _rates(body: BodyRate, idle: str | None) -> str:
    if not body.valid:
        return f"NOT MEASURING ({idle})" if idle else "MISSING"
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
