"""What `monitor` shows of the boards: as JSON, as one line, and as a picture for a terminal.

The picture is drawn in place, and never higher than the terminal.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from itertools import groupby, zip_longest
from typing import TYPE_CHECKING

from tfsat_host.devices.logger import card_is_bad, file_was_full, state_words
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.error_columns import or_error
from tfsat_host.next_step import Advice
from tfsat_host.present.logger_state import LOGGER, RAM_HOLDS_DROP, attention, card_words, idle_part
from tfsat_host.present.sequencer_state import SEQUENCER, explain_code, switch_words, with_fault
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.messages import LoggerStatusReply, SequencerStatusReply
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import UNKNOWN, Column, Columns, fields

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.devices.monitoring import (
        BodyRate,
        JointReading,
        LoggerWatch,
        Reading,
        SequencerWatch,
        WatchedBoards,
    )

UNCALIBRATED = (
    "Rates as the gyros read them, bias and misalignment included. "
    "Joint angles by the robot file's zeros: uncalibrated."
)

_SEQUENCER: Columns = (*SEQUENCER, Column("commanded_deg", of=lambda watch: _commanded_deg(watch.status)))
_BODY_RATE = fields("rate_deg_s valid clipped")
_ANGLE_SENSOR = fields("joint sensor_deg joint_deg_uncalibrated=joint_deg valid")
_LOGGER: Columns = (
    *LOGGER,
    Column(
        "error_explained",
        of=lambda watch: None if file_was_full(watch.status) else explain_code(watch.status.error),
    ),
    *fields("measured_rate_hz=meter.rate_hz live_missed=meter.missed live_gaps=meter.gaps"),
    Column("bodies", of=lambda watch: watch.reading.bodies if watch.reading else (), columns=_BODY_RATE),
    Column(
        "angle_sensors", of=lambda watch: watch.reading.angles if watch.reading else (), columns=_ANGLE_SENSOR
    ),
)
ALWAYS = 0
"""The rank of what is shown in the lowest terminal; the higher a rank, the sooner it is left out."""
_ALARM, _NAME = "bold red", "bold"
_READING, _ACTIVITY, _REFUSAL, _DOUBT, _IDENTITY, _GAP = 1, 2, 3, 4, 5, 6
_BODY = "{:>4} {:>9} {:>9} {:>9} {:<8}"
_NO_BODY = _BODY.format("", "", "", "", "")
Row = tuple[int, str, str]
"""Rank, name and text."""
_JOINT = "   {:>5} {:>9} {:>8} {}"


@dataclass(frozen=True, slots=True)
class Moment:
    """Both boards so many seconds after the start."""

    t_s: float
    boards: WatchedBoards


def _board(name: BoardName, columns: Columns) -> Column:
    return Column(
        name,
        of=lambda moment: getattr(moment.boards, name) or moment.boards.lost.get(name),
        columns=or_error(columns),
    )


MOMENT: Columns = (
    Column("t_s", of=lambda moment: round(moment.t_s, 3)),
    _board("sequencer", _SEQUENCER),
    _board("logger", _LOGGER),
)
"""Of one line of `--json`."""


def one_line(t_s: float, watched: WatchedBoards) -> str:
    """Format everything in one short line, for output that is no terminal."""
    parts = [f"{t_s:.1f} s"]
    if watched.sequencer is not None:
        parts.append(_join_rows(_sequencer(watched.sequencer)))
    if (logger := watched.logger) is not None:
        parts += [_join_rows(_logger(logger)), *attention(logger.status)]
        if logger.status.ram_holds_drop:
            parts.append(Advice("RAM ", RAM_HOLDS_DROP))
        if (reading := logger.reading) is not None:
            bodies = enumerate(reading.bodies)
            rates = "; ".join(f"{i + 1} {_rates(body, idle_part(logger.status, i))}" for i, body in bodies)
            parts.append(f"rates/(deg/s) {rates}")
            parts.append(f"joints/deg (uncalibrated) {_joints(reading.angles)}")
    first, *others = parts
    return Advice(first, *(piece for part in others for piece in (" | ", part)))


def _join_rows(rows: list[Row]) -> str:
    return "; ".join(f"{name} {text}" for rank, name, text in rows if rank != _IDENTITY)


def _rates(body: BodyRate, idle: str | None) -> str:
    if not body.valid:
        return f"NOT MEASURING ({idle})" if idle else "MISSING"
    return " ".join(f"{rate:+.1f}" for rate in body.rate_deg_s) + (" CLIPPED" if body.clipped else "")


def _joints(angles: tuple[JointReading, ...]) -> str:
    words = []
    # Groupby joins neighbours: the sensors come joint by joint.
    for joint, sensors in groupby(angles, key=lambda sensor: sensor.joint):
        angle_texts = (f"{sensor.joint_deg:+.1f}" if sensor.valid else "MISSING" for sensor in sensors)
        words.append(f"{joint} {' / '.join(angle_texts)}")
    return "; ".join(words)


def _commanded_deg(status: SequencerStatusReply) -> list[float] | None:
    """Return the commanded angle of each servo in deg; None if the servos are limp."""
    if not status.servos_driven:
        return None
    return [angle_cdeg / 100 for angle_cdeg in status.joint_angle_cdeg]


def _error_words(code: ErrorCode) -> str:
    """Format a fault or refusal for people: its name and its sentence."""
    if code == ErrorCode.NONE:
        return "none"
    return f"{code.name.lower().replace('_', ' ')}: {REMEDIES[code][0]}"


@dataclass(frozen=True, slots=True)
class Block:
    """Lines that are shown together or not at all, none wider than the terminal."""

    rank: int
    lines: tuple[str, ...]
    style: str = ""


@dataclass(frozen=True, slots=True)
class Picture:
    """What is known of both boards."""

    watched: WatchedBoards

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Rich asks how it looks in a terminal of this size."""
        from rich.text import Text

        # The terminal's last line is kept free: the prompt that comes at the end must not scroll the alarms away.
        for block in fit_blocks(self.blocks(options.max_width), console.height - 1):
            for line in block.lines:
                yield Text(line, style=block.style, no_wrap=True, overflow="ellipsis")

    def blocks(self, width: int) -> list[Block]:
        """Build all blocks of the picture from top to bottom, alarms first."""
        blocks = [Block(ALWAYS, _wrap_text(text, width), _ALARM) for text in _alarms(self.watched)]
        if self.watched.sequencer is not None:
            blocks += _blocks(_sequencer(self.watched.sequencer), width)
        if (logger := self.watched.logger) is not None:
            blocks += _blocks(_logger(logger), width)
            if logger.reading is not None:
                blocks += [
                    Block(_GAP, ("",)),
                    Block(_READING, _table(logger.reading, logger.status)),
                    Block(_DOUBT, _wrap_text(UNCALIBRATED, width)),
                ]
        return [*blocks, Block(ALWAYS, ("Ctrl-C ends it.",))]


def _alarms(watched: WatchedBoards) -> list[str]:
    texts = [f"LOST: {board}. {error.what} Waiting for it." for board, error in watched.lost.items()]
    if watched.sequencer is not None:
        sequencer = watched.sequencer.status
        texts += _error("SEQUENCER FAULT", sequencer.fault)
        if sequencer.resets_while_armed:
            texts.append(f"RESTARTS: the sequencer restarted {sequencer.resets_while_armed} x while armed.")
    if watched.logger is not None:
        status = watched.logger.status
        texts += attention(status)
        if not file_was_full(status):
            texts += _error("LOGGER ERROR", status.error)
        if status.ram_holds_drop:
            texts.append(Advice("RAM ", RAM_HOLDS_DROP))
        if card_is_bad(status):
            texts.append(f"CARD {card_words(status)}")
        if status.samples_dropped:
            texts.append(f"DROPPED: {status.samples_dropped} samples of the recording.")
        if watched.logger.reading is not None:
            texts += _sensor_alarms(watched.logger.reading, status)
    return texts


def fit_blocks(blocks: list[Block], height: int) -> list[Block]:
    """Return the most important blocks that `height` lines hold, in their order.

    If even the blocks that are always shown are too long, their last line is kept, and what fits from the top.
    """
    lines_left = height
    chosen_indices: set[int] = set()
    # By rank; the sort is stable, so that among equals the upper ones win.
    for index in sorted(range(len(blocks)), key=lambda index: blocks[index].rank):
        if blocks[index].rank == ALWAYS or len(blocks[index].lines) <= lines_left:
            chosen_indices.add(index)
            lines_left -= len(blocks[index].lines)
    chosen_blocks = [blocks[index] for index in sorted(chosen_indices)]
    # What is always shown may have overdrawn the height: then cut it from below, but for its last line.
    if lines_left >= 0:
        return chosen_blocks
    lines = [Block(ALWAYS, (line,), block.style) for block in chosen_blocks for line in block.lines]
    return [*lines[: max(height - 1, 0)], lines[-1]]


def _sequencer(watch: SequencerWatch) -> list[Row]:
    status = watch.status
    commanded = _commanded_deg(status)
    joints = enumerate(commanded or (), 1)
    servos = (
        "limp" if commanded is None else ", ".join(f"{joint} {angle_deg:.2f}°" for joint, angle_deg in joints)
    )
    return [
        *_head(watch, with_fault(status.state.name.lower(), status.fault.name.lower())),
        (_REFUSAL, "last refusal", _error_words(status.last_refusal)),
        (
            _ACTIVITY,
            "counters",
            f"false triggers: {status.knocks}; false releases: {status.false_releases}; "
            f"strokes of the last run: {status.strokes_started}",
        ),
        (_ACTIVITY, "commanded", servos),
    ]


def _logger(watch: LoggerWatch) -> list[Row]:
    status, meter = watch.status, watch.meter
    recording = "none since the start"
    if status.session:
        recording = (
            f"session {status.session:08x}, {status.samples} samples, {status.samples_dropped} dropped"
        )
    measured = UNKNOWN if meter.rate_hz is None else f"{meter.rate_hz:.1f}"
    sampling = (
        f"{measured} Hz measured, {status.rate_hz} Hz set; {meter.missed} not shown in {meter.gaps} gaps"
    )
    return [
        *_head(watch, state_words(status)),
        (_ACTIVITY, "recording", recording),
        (_ACTIVITY, "card", card_words(status)),
        (_ACTIVITY, "sampling", sampling),
    ]


def _head(watch: SequencerWatch | LoggerWatch, state: str) -> list[Row]:
    """State and switches, which are always shown, and who the board is."""
    return [
        (ALWAYS, watch.name, f"{state}; switches {switch_words(watch.status.switches_open)}"),
        (_IDENTITY, "port", f"{watch.client.transport.name}, {watch.identity.describe()}"),
    ]


def _blocks(rows: list[Row], width: int) -> list[Block]:
    """Build a block for each of a board's rows; the first row is its head."""
    (rank, name, text), *others = rows
    return [
        Block(rank, _wrap_text(f"{name:<9}  {text}", width), _NAME),
        *(Block(rank, _wrap_text(f"  {name:<13} {text}", width, indent=16)) for rank, name, text in others),
    ]


def _wrap_text(text: str, width: int, indent: int = 2) -> tuple[str, ...]:
    lines = textwrap.wrap(text, max(width, indent + 1), subsequent_indent=" " * indent, drop_whitespace=True)
    return tuple(lines)


def _error(name: str, code: ErrorCode) -> list[str]:
    return [] if code == ErrorCode.NONE else [f"{name}: {' '.join(REMEDIES[code])}"]


def _sensor_alarms(reading: Reading, status: LoggerStatusReply) -> list[str]:
    # A body is silent in two ways: nothing answers, or a part answers and does not measure.
    silent = {i: idle_part(status, i) for i, body in enumerate(reading.bodies) if not body.valid}
    missing = [f"gyro {i + 1}" for i, part in silent.items() if part is None]
    idle = [f"gyro {i + 1} ({part})" for i, part in silent.items() if part is not None]
    missing += [f"an angle sensor of joint {sensor.joint}" for sensor in reading.angles if not sensor.valid]
    clipped = [
        f"gyro {number}" for number, body in enumerate(reading.bodies, 1) if body.valid and body.clipped
    ]
    alarms = (("MISSING", missing), ("NOT MEASURING", idle), ("CLIPPED", clipped))
    return [f"{name}: {', '.join(which)}." for name, which in alarms if which]


def _table(reading: Reading, status: LoggerStatusReply) -> tuple[str, ...]:
    """Bodies on the left, angle sensors on the right: 77 columns."""
    body_lines = [_body(i + 1, body, idle_part(status, i)) for i, body in enumerate(reading.bodies)]
    right = [_sensor(sensor) for sensor in reading.angles]
    head = _BODY.format("body", "x / deg/s", "y / deg/s", "z / deg/s", "gyro")
    head += _JOINT.format("joint", "angle/deg", "read/deg", "sensor")
    # Fewer bodies than sensors: fill up the shorter side.
    rows = zip_longest(body_lines, right, fillvalue="")
    return (head, *(body.ljust(len(_NO_BODY)) + sensor for body, sensor in rows))


def _body(number: int, body: BodyRate, idle: str | None) -> str:
    silent = "NO DATA" if idle else "MISSING"
    state = silent if not body.valid else "CLIPPED" if body.clipped else "ok"
    rates = [f"{rate:+.1f}" if body.valid else "–" for rate in body.rate_deg_s]
    return _BODY.format(number, *rates, state)


def _sensor(sensor: JointReading) -> str:
    if not sensor.valid:
        return _JOINT.format(sensor.joint, "–", "–", "MISSING")
    return _JOINT.format(sensor.joint, f"{sensor.joint_deg:+.1f}", f"{sensor.sensor_deg:.1f}", "ok")
