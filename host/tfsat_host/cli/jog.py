"""`tfsat-host jog`: one joint moves slowly, for calibration, and is let go."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from tfsat_host.cli.boards import open_jog_client
from tfsat_host.cli.stopping import stop_wish, suspend_now
from tfsat_host.cli.usage import JOINT, add_options, device, joint_angle_cdeg, number
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.jog_path import Jog, JogInterrupted, from_here
from tfsat_host.devices.jogging import JogClient
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.quantity import Column, Columns, fields, record

MAX_HOLD_S = 3600.0
"""Beyond it `--hold` is a slip of the fingers."""
LINE_CDEG = 1000
"""Where there is no terminal, progress is a line each 10 deg."""


@dataclass(frozen=True, slots=True)
class JoggedJoint:
    """A joint that was moved, held so long, and let go; the board that did it."""

    jog: Jog
    held_s: float
    device: Device


_JOGGED: Columns = (
    *fields("joint=jog.joint"),
    Column("from_deg", of=lambda jogged: jogged.jog.from_cdeg / 100),
    Column("to_deg", of=lambda jogged: jogged.jog.to_cdeg / 100),
    *fields("held_s"),
    Column("state", of=lambda _: "safe"),
    Column("device", columns=DEVICE),
)
_USAGE = f"""
* --joint         joint to move
* --from DEG      where the joint is now: its servo's first pulse takes it there at full speed
* --to DEG        where it shall go
--hold SECONDS    hold it there so long before it is let go (default: 0)
{device("sequencer")}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the joint, its start and end angle, and the hold time."""
    hold = {"type": _hold_s, "default": 0.0, "dest": "hold_s"}
    ends = {end: {"type": joint_angle_cdeg, "dest": f"{end}_cdeg"} for end in ("from", "to")}
    add_options(parser, _USAGE, joint=JOINT, hold=hold, **ends)


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks, asks, moves, holds, lets go."""
    jog = Jog(args.joint, args.from_cdeg, args.to_cdeg)
    with open_jog_client(args, out) as sequencer:
        sequencer.check(jog)
        out.note(jog.explanation(args.hold_s))
        if args.emulated:
            out.note("The emulated robot starts with each command: all its joints are at 0 deg now.")
        if not out.yes:
            out.ask("Type JOG to move it: ", meaning="Nothing was moved.", accept=("jog",))
        with stop_wish(before_suspension=True) as stopped, _progress(jog, out) as show_angle:
            end = sequencer.run(jog, args.hold_s, stopped, show_angle)
        if end.held:
            _show(sequencer, jog, args, out)
            return 0
    what = "Interrupted."
    if stopped.suspend:
        out.note(f"Ctrl-Z: jog ended, joint {jog.joint} limp, last commanded {end.angle_cdeg / 100:g} deg.")
        suspend_now()
        what = "The jog has ended: Ctrl-Z let the joint go before the program stopped."
    raise JogInterrupted(jog.joint, end, what, from_here)


def _show(sequencer: JogClient, jog: Jog, args: argparse.Namespace, out: Output) -> None:
    angles = ("--from", f"{jog.to_cdeg / 100:g}", "--to", "DEG")
    on: Advice | str = Advice(NextStep("jog", ("--joint", str(jog.joint), *angles)))
    if args.emulated:
        on = f"{NextStep('emulate')} (keeps an emulated robot; that of this command has ended)"
    out.result(
        record(_JOGGED, JoggedJoint(jog, args.hold_s, sequencer.device())),
        Advice(
            f"Joint {jog.joint}: moved to {jog.to_cdeg / 100:g} deg and let go (sequencer safe)\nNext: ", on
        ),
    )


@contextmanager
def _progress(jog: Jog, out: Output) -> Iterator[Callable[[int], None]]:
    """Gives what shows the commanded angle, 0.01 deg: in place on a terminal, else in lines."""
    shown_cdeg: int | None = None
    with out.live(diagnostic=True) as draw:

        def show(angle_cdeg: int) -> None:
            nonlocal shown_cdeg
            text = f"joint {jog.joint}: {angle_cdeg / 100:6.2f} deg, to {jog.to_cdeg / 100:g} deg"
            moved_cdeg = LINE_CDEG if shown_cdeg is None else abs(angle_cdeg - shown_cdeg)
            if draw is not None:
                draw(text)
            elif not out.json_mode and moved_cdeg >= (1 if angle_cdeg == jog.to_cdeg else LINE_CDEG):
                out.note(text)
                shown_cdeg = angle_cdeg

        yield show


def _hold_s(text: str) -> float:
    seconds = number(text)
    if not 0 <= seconds <= MAX_HOLD_S:
        raise argparse.ArgumentTypeError(f"{text!r} is no duration: write seconds, 0 to {MAX_HOLD_S:g}")
    return seconds
