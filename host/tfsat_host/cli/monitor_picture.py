"""The picture of `monitor` for a terminal: drawn anew in place, and never higher than the terminal."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING

from tfsat_host.cli.board_state import switch_words, with_fault
from tfsat_host.cli.logger_state import RAM_HOLDS_DROP, attention, card_words, idle_part
from tfsat_host.cli.monitor_words import UNCALIBRATED, commanded_deg, error_words
from tfsat_host.devices.card_trouble import card_is_bad, file_was_full, state_words
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.cli.monitor_boards import LoggerWatch, SequencerWatch
    from tfsat_host.devices.ports import BoardName
    from tfsat_host.errors import TfsatError
    from tfsat_host.monitoring.reading import BodyRate, JointReading, Reading
    from tfsat_host.protocol.messages import LoggerStatusReply

ALWAYS = 0
"""The rank of what is shown in the lowest terminal; the higher a rank, the sooner it is left out."""
_ALARM, _NAME = "bold red", "bold"
_READING, _ACTIVITY, _REFUSAL, _DOUBT, _IDENTITY, _GAP = 1, 2, 3, 4, 5, 6
_BODY = "{:>4} {:>9} {:>9} {:>9} {:<8}"
_NO_BODY = _BODY.format("", "", "", "", "")
_JOINT = "   {:>5} {:>9} {:>8} {}"


@dataclass(frozen=True, slots=True)
class Block:
    """Lines that are shown together or not at all, none wider than the terminal."""

    rank: int
    lines: tuple[str, ...]
    style: str = ""


@dataclass(frozen=True, slots=True)
class Picture:
    """What is known of both boards.

    Attributes:
        sequencer: None: it is not watched.
        logger: Likewise.
        lost: Why a board is not watched any more, by its name.
    """

    sequencer: SequencerWatch | None
    logger: LoggerWatch | None
    lost: Mapping[BoardName, TfsatError]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Rich asks how it looks in a terminal of this size."""
        from rich.text import Text

        # The terminal's last line is kept free: the prompt that comes at the end must not scroll the alarms away.
        for block in fitted(self.blocks(options.max_width), console.height - 1):
            for line in block.lines:
                yield Text(line, style=block.style, no_wrap=True, overflow="ellipsis")

    def blocks(self, width: int) -> list[Block]:
        """All of it from top to bottom, alarms first."""
        blocks = [Block(ALWAYS, _wrapped(text, width), _ALARM) for text in self._alarms()]
        if self.sequencer is not None:
            blocks += _sequencer(self.sequencer, width)
        if self.logger is not None:
            blocks += _logger(self.logger, width)
            if self.logger.reading is not None:
                blocks += [
                    Block(_GAP, ("",)),
                    Block(_READING, _table(self.logger.reading, self.logger.status)),
                    Block(_DOUBT, _wrapped(UNCALIBRATED, width)),
                ]
        return [*blocks, Block(ALWAYS, ("Ctrl-C ends it.",))]

    def _alarms(self) -> list[str]:
        texts = [f"LOST: {board}. {error.what}" for board, error in self.lost.items()]
        if self.sequencer is not None:
            status = self.sequencer.status
            texts += _error("SEQUENCER FAULT", status.fault)
            if status.resets_while_armed:
                texts.append(f"RESTARTS: the sequencer restarted {status.resets_while_armed} x while armed.")
        if self.logger is not None:
            texts += attention(self.logger.status)
            if not file_was_full(self.logger.status):
                texts += _error("LOGGER ERROR", self.logger.status.error)
            if self.logger.status.ram_holds_drop:
                texts.append(f"RAM {RAM_HOLDS_DROP}")
            if card_is_bad(self.logger.status):
                texts.append(f"CARD {card_words(self.logger.status)}")
            if self.logger.status.samples_dropped:
                texts.append(f"DROPPED: {self.logger.status.samples_dropped} samples of the recording.")
            if self.logger.reading is not None:
                texts += _sensor_alarms(self.logger.reading, self.logger.status)
        return texts


def fitted(blocks: list[Block], height: int) -> list[Block]:
    """As many blocks as `height` lines hold, the most important ones, in their order.

    Where even what is always shown is too much, its end is kept, and as much as fits from the top.
    """
    left = height
    kept: set[int] = set()
    for index in sorted(range(len(blocks)), key=lambda index: blocks[index].rank):
        if blocks[index].rank == ALWAYS or len(blocks[index].lines) <= left:
            kept.add(index)
            left -= len(blocks[index].lines)
    shown = [blocks[index] for index in sorted(kept)]
    if left >= 0:
        return shown
    lines = [Block(ALWAYS, (line,), block.style) for block in shown for line in block.lines]
    return [*lines[: max(height - 1, 0)], lines[-1]]


def _sequencer(watch: SequencerWatch, width: int) -> list[Block]:
    status = watch.status
    told = commanded_deg(status)
    joints = enumerate(told or (), 1)
    servos = "limp" if told is None else ", ".join(f"{joint} {angle_deg:.2f}°" for joint, angle_deg in joints)
    return [
        *_head(
            watch,
            with_fault(status.state.name.lower(), status.fault.name.lower()),
            status.switches_open,
            width,
        ),
        _row(_REFUSAL, "last refusal", error_words(status.last_refusal), width),
        _row(
            _ACTIVITY,
            "knocks",
            f"{status.knocks}; false releases: {status.false_releases}; "
            f"strokes of the last run: {status.strokes_started}",
            width,
        ),
        _row(_ACTIVITY, "commanded", servos, width),
    ]


def _logger(watch: LoggerWatch, width: int) -> list[Block]:
    status, meter = watch.status, watch.meter
    recording = "none since the start"
    if status.session:
        recording = (
            f"session {status.session:08x}, {status.samples} samples, {status.samples_dropped} dropped"
        )
    measured = "–" if meter.rate_hz is None else f"{meter.rate_hz:.1f}"
    sampling = (
        f"{measured} Hz measured, {status.rate_hz} Hz set; {meter.missed} not shown in {meter.gaps} gaps"
    )
    return [
        *_head(watch, state_words(status), status.switches_open, width),
        _row(_ACTIVITY, "recording", recording, width),
        _row(_ACTIVITY, "card", card_words(status), width),
        _row(_ACTIVITY, "sampling", sampling, width),
    ]


def _head(watch: SequencerWatch | LoggerWatch, state: str, switches_open: int, width: int) -> list[Block]:
    """State and switches, which are always shown, and who the board is."""
    return [
        Block(
            ALWAYS,
            _wrapped(f"{watch.name:<9}  {state}; switches {switch_words(switches_open)}", width),
            _NAME,
        ),
        _row(_IDENTITY, "port", f"{watch.port}, {watch.identity.describe()}", width),
    ]


def _row(rank: int, name: str, text: str, width: int) -> Block:
    return Block(rank, _wrapped(f"  {name:<13} {text}", width, indent=16))


def _wrapped(text: str, width: int, indent: int = 2) -> tuple[str, ...]:
    lines = textwrap.wrap(text, max(width, indent + 1), subsequent_indent=" " * indent, drop_whitespace=True)
    return tuple(lines)


def _error(name: str, code: ErrorCode) -> list[str]:
    return [] if code == ErrorCode.NONE else [f"{name}: {' '.join(REMEDIES[code])}"]


def _sensor_alarms(reading: Reading, status: LoggerStatusReply) -> list[str]:
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
    left = [_body(i + 1, body, idle_part(status, i)) for i, body in enumerate(reading.bodies)]
    right = [_sensor(sensor) for sensor in reading.angles]
    head = _BODY.format("body", "x / deg/s", "y / deg/s", "z / deg/s", "gyro")
    head += _JOINT.format("joint", "angle/deg", "read/deg", "sensor")
    rows = zip_longest(left, right, fillvalue="")
    return (head, *(body.ljust(len(_NO_BODY)) + sensor for body, sensor in rows))


def _body(number: int, body: BodyRate, idle: str | None) -> str:
    silent = "NO DATA" if idle else "MISSING"
    said = silent if not body.valid else "CLIPPED" if body.clipped else "ok"
    rates = [f"{rate:+.1f}" if body.valid else "–" for rate in body.rate_deg_s]
    return _BODY.format(number, *rates, said)


def _sensor(sensor: JointReading) -> str:
    if not sensor.valid:
        return _JOINT.format(sensor.joint, "–", "–", "MISSING")
    return _JOINT.format(sensor.joint, f"{sensor.joint_deg:+.1f}", f"{sensor.sensor_deg:.1f}", "ok")
