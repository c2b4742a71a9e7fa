"""`tfsat-host monitor`: both boards live in the terminal. It only reads."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from tfsat_host.cli.boards import PLACE, Place, absent, most_telling, places
from tfsat_host.cli.stopping import stop_wish
from tfsat_host.cli.usage import add_options
from tfsat_host.devices.client import Client
from tfsat_host.errors import TfsatError
from tfsat_host.present.monitor_view import MOMENT, UNCALIBRATED, Moment, Picture, one_line
from tfsat_host.present.output import Output
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from tfsat_host.devices.monitoring import WatchedBoards
    from tfsat_host.robot import AngleSensor

LINE_S = 1.0
"""Where there is no terminal, a line a second."""


_USAGE = f"""
--for SECONDS  end automatically after so long (default: Ctrl-C)
--robot FILE   robot file with the angle sensors' zeros and directions (default: the drop tower robot)
{PLACE}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for boards, duration, and the robot file with the zeros."""
    add_options(parser, _USAGE, **{"for": {"dest": "for_s"}})


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows until it is interrupted, which is its normal end, or for as long as was asked."""
    from tfsat_host.devices.monitoring import BoardsLost, watch
    from tfsat_host.robot.absent_parts import describe_absent, load_robot_of_boards

    robot = load_robot_of_boards(args.robot)
    sensors = robot.angle_sensors
    if sentence := describe_absent(robot):
        out.note(sentence)
    with ExitStack() as stack:
        all_places = places(args, out, stack)
        watched = _open(all_places, out, sensors, stack)
        stack.callback(watched.close)
        stopped = stack.enter_context(stop_wish())
        with _open_view(out) as show:
            connect = {place.expected: place.connect for place in all_places}

            def take_back() -> None:
                for board in list(watched.lost):
                    # A place without an expected board is that of `--port`, whichever board it is.
                    watched.take_back(board, connect.get(board) or connect[None], sensors)

            watch(watched, args.for_s, stopped, show, take_back)
        if not watched.any_left:
            lost = list(watched.lost.values())
            raise BoardsLost(watched.lost) if len(lost) > 1 else most_telling(lost)
    return 0


def _open(
    all_places: Sequence[Place], out: Output, sensors: Sequence[AngleSensor], stack: ExitStack
) -> WatchedBoards:
    """Opens what there is. Raises what is most telling if there is nothing, and BuildError."""
    from tfsat_host.devices.monitoring import WatchedBoards

    watched = WatchedBoards(time.monotonic)
    errors: list[TfsatError] = []
    for place in all_places:
        try:
            transport = place.connect()
            stack.callback(transport.close)
            name = watched.add(Client(transport), sensors)
            if place.expected not in (None, name):
                out.warn(f"{place.said_by} is the {name}'s port, not the {place.expected}'s: correct it.")
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


@contextmanager
def _open_view(out: Output) -> Iterator[Callable[[float, WatchedBoards], None]]:
    """Yield the function that shows a reading: as JSON lines, a picture in place, or one line per second."""
    if out.json_mode:
        yield lambda t_s, watched: out.stream(record(MOMENT, Moment(t_s, watched)))
        return
    with out.live() as draw:
        if draw is not None:
            yield lambda _t_s, watched: draw(Picture(watched))
            return
        out.note(UNCALIBRATED)
        due_s, warned = 0.0, set[str]()

        def show(t_s: float, watched: WatchedBoards) -> None:
            nonlocal due_s, warned
            for board in warned - watched.lost.keys():
                out.note(f"The {board} is back.")
            for board in watched.lost.keys() - warned:
                out.warn(f"{watched.lost[board].what} Waiting for it to come back.")
            warned = set(watched.lost)
            if t_s >= due_s and watched.any_left:
                out.line(one_line(t_s, watched), no_wrap=True)
                sys.stdout.flush()  # a reader of the pipe sees it now
                due_s += LINE_S

        yield show
