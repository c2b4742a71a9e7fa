"""`tfsat-host monitor`: both boards live in the terminal. It only reads."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import duration_s, file_name
from tfsat_host.cli.places import BOARDS, Place, absent, add_place_options, most_telling, places
from tfsat_host.cli.stopping import stop_wish
from tfsat_host.errors import TfsatError
from tfsat_host.json_values import error_as_dict
from tfsat_host.present.output import Output
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import RenderableType

    from tfsat_host.cli.monitor_boards import LoggerWatch, SequencerWatch
    from tfsat_host.devices.ports import BoardName
    from tfsat_host.devices.transport import Transport
    from tfsat_host.robot import AngleSensor

LINE_S = 1.0
"""Where there is no terminal, a line a second."""


@dataclass
class Watched:
    """The boards that are watched, and those that were lost.

    Attributes:
        clock: Seconds on the transports' common clock.
    """

    clock: Callable[[], float]
    sequencer: SequencerWatch | None = None
    logger: LoggerWatch | None = None
    lost: dict[BoardName, TfsatError] = field(default_factory=dict)

    @property
    def any_left(self) -> bool:
        """There is something to show."""
        return self.sequencer is not None or self.logger is not None

    def update(self, until_s: float) -> None:
        """Brings both up to date; a board that does not answer any more is given up."""
        both = self.logger is not None
        if self.sequencer is not None:
            try:
                self.sequencer.update(self.clock() if both else until_s)
            except TfsatError as error:
                self._give_up(self.sequencer, error)
                self.sequencer = None
        if self.logger is not None:
            try:
                self.logger.update(until_s)
            except TfsatError as error:
                self._give_up(self.logger, error)
                self.logger = None

    def close(self) -> None:
        """Leaves the boards as they were; one that cannot be asked any more notices that its port is closed."""
        for watch in (self.sequencer, self.logger):
            if watch is not None:
                with suppress(TfsatError):
                    watch.close()

    def _give_up(self, watch: SequencerWatch | LoggerWatch, error: TfsatError) -> None:
        self.lost[watch.name] = error
        watch.give_up()


def configure(parser: argparse.ArgumentParser) -> None:
    """Which boards, how long, whose zeros."""
    parser.add_argument(
        "--for",
        metavar="SECONDS",
        type=duration_s,
        dest="for_s",
        help="end by itself after so long (default: Ctrl-C)",
    )
    parser.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="robot file with the angle sensors' zeros and directions (default: the drop tower robot)",
    )
    add_place_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows until it is interrupted, which is its normal end, or for as long as was asked."""
    from tfsat_host.robot import load_robot

    robot = load_robot(args.robot)
    sensors = robot.angle_sensors
    if len(sensors) != ANGLE_SENSOR_COUNT:
        raise TfsatError(
            what=f"{robot.path}: {robot.name} has {len(sensors)} angle sensors.",
            meaning=f"The logger reads {ANGLE_SENSOR_COUNT}, so its angles cannot be shown; nothing was changed.",
            next_step="Name the file of the robot that carries the logger, or leave --robot out.",
        )
    with ExitStack() as stack:
        watched = _open(args, out, sensors, stack)
        stack.callback(watched.close)
        stopped = stack.enter_context(stop_wish())
        with _shown(out) as show:
            _watch(watched, args.for_s, stopped, show)
        if not watched.any_left:
            raise _all_lost(watched.lost)
    return 0


class BoardsLost(TfsatError):
    """Both boards were lost.

    Attributes:
        code: The first one's.
        details: For `--json`: each board's own error.
    """

    def __init__(self, lost: dict[BoardName, TfsatError]) -> None:
        first = next(iter(lost.values()))
        super().__init__(
            what=" ".join(f"{board.capitalize()}: {error.what}" for board, error in lost.items()),
            meaning="Both boards were lost; what they do now is not known.",
            next_step=first.next_step,
        )
        self.code = getattr(first, "code", None)
        self.details = {"lost": {board: error_as_dict(error) for board, error in lost.items()}}


def _all_lost(lost: dict[BoardName, TfsatError]) -> TfsatError:
    """The only loss, or both in one."""
    return BoardsLost(lost) if len(lost) > 1 else most_telling(list(lost.values()))


def _open(args: argparse.Namespace, out: Output, sensors: Sequence[AngleSensor], stack: ExitStack) -> Watched:
    """Opens what there is. Raises what is most telling if there is nothing, and BuildError."""
    watched = Watched(time.monotonic)
    errors: list[TfsatError] = []
    for place in places(args, out, stack):
        try:
            _open_one(place, watched, sensors, out, stack)
        except TfsatError as error:
            errors.append(error)
            if place.expected is not None:
                watched.lost[place.expected] = error
    if not watched.any_left:
        raise most_telling(errors)
    for missed in errors:
        out.note(missed.what)
    watched.lost = {board: error for board, error in watched.lost.items() if not absent(error)}
    return watched


def _open_one(
    place: Place, watched: Watched, sensors: Sequence[AngleSensor], out: Output, stack: ExitStack
) -> None:
    from tfsat_host.cli.monitor_boards import LoggerWatch, SequencerWatch
    from tfsat_host.devices.client import Client
    from tfsat_host.protocol.enums import Board

    transport: Transport = place.connect()
    stack.callback(transport.close)
    client = Client(transport)
    identity = client.hello()
    watched.clock = transport.now_s
    if identity.board == Board.SEQUENCER:
        watched.sequencer = SequencerWatch(client, identity)
    else:
        watched.logger = LoggerWatch(client, identity, sensors)
    name = identity.board.name.lower()
    if place.expected not in (None, name):
        out.warn(f"{place.said_by} is the {name}'s port, not the {place.expected}'s: correct it.")


def _watch(
    watched: Watched,
    for_s: float | None,
    stopped: Callable[[], bool],
    show: Callable[[float, Watched], None],
) -> None:
    """Until it is stopped, the time is over, or no board is left."""
    from tfsat_host.monitoring.pace import REFRESH_S

    started_s, real_s = watched.clock(), time.monotonic()
    end_s = None if for_s is None else started_s + for_s
    while watched.any_left and not stopped():
        now_s = watched.clock()
        if end_s is not None and now_s >= end_s:
            return
        watched.update(now_s + REFRESH_S if end_s is None else min(now_s + REFRESH_S, end_s))
        passed_s = watched.clock() - started_s
        show(passed_s, watched)
        ahead_s = passed_s - (time.monotonic() - real_s)
        if ahead_s > 0:  # an emulated robot's time runs faster than a person reads
            time.sleep(ahead_s)


@contextmanager
def _shown(out: Output) -> Iterator[Callable[[float, Watched], None]]:
    """How it is shown: JSON lines, a picture in place, or a line a second."""
    from tfsat_host.cli.monitor_words import UNCALIBRATED, one_line

    if out.json_mode:
        yield lambda t_s, watched: out.stream(_as_json(t_s, watched))
        return
    with out.live() as draw:
        if draw is not None:
            yield lambda _t_s, watched: draw(_picture(watched))
            return
        out.note(UNCALIBRATED)
        due_s, told = 0.0, set[str]()

        def say(t_s: float, watched: Watched) -> None:
            nonlocal due_s
            for board, error in watched.lost.items():
                if board not in told:
                    told.add(board)
                    out.warn(error.what)
            if t_s >= due_s and watched.any_left:
                out.line(one_line(t_s, watched.sequencer, watched.logger))
                sys.stdout.flush()  # a reader of the pipe sees it now
                due_s += LINE_S

        yield say


def _picture(watched: Watched) -> RenderableType:
    from tfsat_host.cli.monitor_picture import Picture

    return Picture(watched.sequencer, watched.logger, watched.lost)


def _as_json(t_s: float, watched: Watched) -> dict[str, Any]:
    from tfsat_host.cli.monitor_words import logger_as_dict, sequencer_as_dict

    shown: dict[str, Any] = {"t_s": round(t_s, 3), **dict.fromkeys(BOARDS)}
    shown |= {board: {"error": error_as_dict(error)} for board, error in watched.lost.items()}
    if watched.sequencer is not None:
        shown["sequencer"] = sequencer_as_dict(watched.sequencer)
    if watched.logger is not None:
        shown["logger"] = logger_as_dict(watched.logger)
    return shown
