"""Both boards live: asked no more than a view needs, and one sample in degrees and degrees per second."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.devices.client import Client
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.devices.transport import Transport
from tfsat_host.error_columns import error_columns
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.enums import Board, SequencerState
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.log_layout import ANGLE_VALID_BIT, CLIPPED_BIT
from tfsat_host.protocol.messages import LiveReply, LiveSampleStream
from tfsat_host.quantity import Column, by_name
from tfsat_host.robot import AngleSensor
from tfsat_host.units import US_PER_S

REFRESH_S = 0.2
"""The picture is drawn, and a board at rest is asked, five times a second."""
BUSY_S = 0.5
"""An armed or running sequencer is asked twice a second: a view must never disturb it."""
WINDOW_US = US_PER_S
"""The rate is that of the last second, on the logger's clock."""
_BUSY = (SequencerState.ARMED, SequencerState.RUNNING)
_TURN_DEG = 360.0
RETRY_S = 1.0
"""A board that was lost is looked for once a second."""


@dataclass(frozen=True, slots=True)
class BodyRate:
    """A body's gyro.

    Attributes:
        rate_deg_s: About x, y, z of the sensor, as read: bias and mounting are not corrected.
        valid: The IMU answered.
        clipped: Its range was exceeded.
    """

    rate_deg_s: tuple[float, ...]
    valid: bool
    clipped: bool


@dataclass(frozen=True, slots=True)
class JointReading:
    """An absolute angle sensor.

    Attributes:
        joint: From 1.
        sensor_deg: As read, 0 to 360.
        joint_deg: The joint's angle by the robot file's zero, -180 to 180.
        valid: The sensor answered.
    """

    joint: int
    sensor_deg: float
    joint_deg: float
    valid: bool


@dataclass(frozen=True, slots=True)
class Reading:
    """One sample: bodies in order, angle sensors in the order of the log."""

    bodies: tuple[BodyRate, ...]
    angles: tuple[JointReading, ...]


def convert(sample: LiveSampleStream, scales: LiveReply, sensors: Sequence[AngleSensor]) -> Reading:
    """Convert a live sample to units for people.

    `scales` are as the logger named them when live sampling was switched on, `sensors` as in the robot file.
    """

    def flag(bit: int) -> bool:
        return bool(sample.sample.flags >> bit & 1)

    bodies = [
        BodyRate(
            tuple(count / scales.gyro_lsb_per_deg_s for count in imu.gyro),
            valid=flag(body),
            clipped=flag(CLIPPED_BIT + body),
        )
        for body, imu in enumerate(sample.sample.imu)
    ]
    angles = []
    for index, (count, sensor) in enumerate(zip(sample.sample.angle, sensors, strict=True)):
        # The middle of the count: the converter truncates.
        sensor_deg = (count + 0.5) * _TURN_DEG / scales.angle_counts_per_turn
        turned_deg = sensor.direction * (sensor_deg - math.degrees(sensor.zero_offset_rad))
        # To within half a turn of the joint's zero, wherever in the sensor's turn that lies.
        joint_deg = math.remainder(turned_deg, _TURN_DEG)
        angles.append(JointReading(sensor.joint + 1, sensor_deg, joint_deg, flag(ANGLE_VALID_BIT + index)))
    return Reading(tuple(bodies), tuple(angles))


class StreamMeter:
    """How fast live samples really come, and which never came.

    Attributes:
        missed: Samples that the logger took and that never arrived, since the first.
        gaps: Places at which some are missing.
    """

    def __init__(self) -> None:
        self.missed = 0
        self.gaps = 0
        self._recent: deque[tuple[int, int]] = deque()

    def add(self, samples: Iterable[LiveSample]) -> None:
        """Takes samples in the order in which they came."""
        for sample in samples:
            if self._recent:
                lost = sample.index - self._recent[-1][0] - 1
                if lost < 0:  # the logger has restarted, and so have its indices
                    self._recent.clear()
                elif lost > 0:
                    self.missed += lost
                    self.gaps += 1
            self._recent.append((sample.index, sample.time_us))
            # A window on the logger's clock: the host's own delays do not change the rate.
            while self._recent[-1][1] - self._recent[0][1] > WINDOW_US:
                self._recent.popleft()

    @property
    def rate_hz(self) -> float | None:
        """Samples that the logger took a second, those that never arrived included; None: not known yet."""
        if len(self._recent) < 2:
            return None
        (first, first_us), (last, last_us) = self._recent[0], self._recent[-1]
        return (last - first) * US_PER_S / (last_us - first_us) if last_us > first_us else None


class SequencerWatch:
    """Asks for the status, rarely while the sequencer is armed or runs. Sends nothing else."""

    name: BoardName = "sequencer"

    def __init__(self, client: Client, identity: BoardIdentity) -> None:
        self.client, self.identity = client, identity
        self._board = SequencerClient(client, identity)
        self.status = self._board.status()
        self._asked_s = client.transport.now_s()

    def update(self, until_s: float) -> None:
        """Asks if it is time to, and lets time pass to `until_s` on the transport's clock. Raises TfsatError."""
        transport = self.client.transport
        interval_s = BUSY_S if self.status.state in _BUSY else REFRESH_S
        if transport.now_s() - self._asked_s >= interval_s:
            self.status = self._board.status()
            self._asked_s = transport.now_s()
        self.client.wait(until_s - transport.now_s())

    def close(self) -> None:
        """Nothing was switched on."""


class LoggerWatch:
    """Takes live samples, and asks for the status between them."""

    name: BoardName = "logger"

    def __init__(self, client: Client, identity: BoardIdentity, sensors: Sequence[AngleSensor]) -> None:
        self.client, self.identity = client, identity
        self._sensors = sensors
        self._board = LoggerClient(client, identity)
        self.status = self._board.status()
        self._asked_s = client.transport.now_s()
        self.meter = StreamMeter()
        self.reading: Reading | None = None
        self._scales = self._board.start_live()

    def update(self, until_s: float) -> None:
        """Takes samples until then. Raises TfsatError, also where none come any more."""
        transport = self.client.transport
        if transport.now_s() - self._asked_s >= REFRESH_S:
            self.status = self._board.status()
            self._asked_s = transport.now_s()
        while True:
            samples = self._board.live_samples()
            self.meter.add(samples)
            self.reading = convert(samples[-1].decode(), self._scales, self._sensors)
            if transport.now_s() >= until_s:
                return

    def close(self) -> None:
        """Switches live sampling off. Raises TfsatError when the board is lost."""
        self._board.stop_live()


class BoardsLost(TfsatError):
    """Both boards were lost.

    Attributes:
        code: The first one's.
        columns: For `--json`: each board's own error.
    """

    def __init__(self, lost: dict[BoardName, TfsatError]) -> None:
        first = next(iter(lost.values()))
        super().__init__(
            what=" ".join(f"{board.capitalize()}: {error.what}" for board, error in lost.items()),
            meaning="Both boards were lost; what they do now is not known.",
            next_step=first.next_step,
        )
        self.code = first.code
        self.columns = (Column("lost", of=lambda _: lost, columns=by_name(error_columns)),)


@dataclass
class WatchedBoards:
    """The boards that are watched, and those that were lost.

    Attributes:
        clock: Seconds on the transports' common clock.
        sequencer: None: it is not watched.
        logger: Likewise.
        lost: Why a board is not watched any more, by its name.
        serials: Of the boards that are or were watched.
    """

    clock: Callable[[], float]
    sequencer: SequencerWatch | None = None
    logger: LoggerWatch | None = None
    lost: dict[BoardName, TfsatError] = field(default_factory=dict)
    serials: dict[BoardName, str] = field(default_factory=dict)

    @property
    def any_left(self) -> bool:
        """There is something to show."""
        return self.sequencer is not None or self.logger is not None

    def add(self, client: Client, sensors: Sequence[AngleSensor]) -> BoardName:
        """Watches the board that answers; its name. `sensors` as in `convert`. Raises TfsatError."""
        identity = client.hello()
        self.clock = client.transport.now_s
        watch: SequencerWatch | LoggerWatch
        if identity.board == Board.SEQUENCER:
            watch = self.sequencer = SequencerWatch(client, identity)
        else:
            watch = self.logger = LoggerWatch(client, identity, sensors)
        self.serials[watch.name] = identity.serial
        return watch.name

    def take_back(
        self, name: BoardName, connect: Callable[[], Transport], sensors: Sequence[AngleSensor]
    ) -> None:
        """Watch a lost board again if its cable is back; nothing happens until then, or for another board."""
        with suppress(TfsatError):
            client = Client(connect())
            # Another board, or an emulated one, at the place of the one that went is not the one that is watched.
            serial = client.hello().serial
            if self.serials.get(name, serial) == serial:
                self.add(client, sensors)
                del self.lost[name]
            else:
                client.close()

    def update(self, until_s: float) -> None:
        """Brings both up to date; a board that does not answer any more is given up, its port closed."""
        # With a logger, its samples take up the time until then; the sequencer is only asked.
        if self.sequencer is not None and not self._update_board(
            self.sequencer, self.clock() if self.logger is not None else until_s
        ):
            self.sequencer = None
        if self.logger is not None and not self._update_board(self.logger, until_s):
            self.logger = None

    def _update_board(self, board: SequencerWatch | LoggerWatch, until_s: float) -> bool:
        try:
            board.update(until_s)
        except TfsatError as error:
            self.lost[board.name] = error
            board.client.close()
            return False
        return True

    def close(self) -> None:
        """Leaves the boards as they were; one that cannot be asked any more notices that its port is closed."""
        for watch in (self.sequencer, self.logger):
            if watch is not None:
                with suppress(TfsatError):
                    watch.close()


def watch(
    watched: WatchedBoards,
    for_s: float | None,
    stopped: Callable[[], bool],
    show: Callable[[float, WatchedBoards], None],
    take_back: Callable[[], None],
) -> None:
    """Watches until it is stopped or the time is over; boards that are lost are waited for.

    `for_s` is on the boards' clock; None: for ever. `show` is given the time since the beginning, s, and the
    boards, each time that they are up to date. `take_back` looks for the boards that are lost.
    """

    started_s, real_s = watched.clock(), time.monotonic()
    end_s = None if for_s is None else started_s + for_s
    sought_s = started_s
    while not stopped():
        now_s = watched.clock()
        if end_s is not None and now_s >= end_s:
            return
        if watched.lost and now_s - sought_s >= RETRY_S:
            take_back()
            sought_s = now_s
        if watched.any_left:
            watched.update(now_s + REFRESH_S if end_s is None else min(now_s + REFRESH_S, end_s))
        else:
            time.sleep(REFRESH_S)
        passed_s = watched.clock() - started_s
        show(passed_s, watched)
        ahead_s = passed_s - (time.monotonic() - real_s)
        if ahead_s > 0:  # an emulated robot's time runs faster than a person reads
            time.sleep(ahead_s)
