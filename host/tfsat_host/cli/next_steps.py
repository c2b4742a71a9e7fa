"""Commands to type next, completed by what this command was given: recording, ports, certificate, robot, image."""

from __future__ import annotations

from collections.abc import Iterator

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import NextStep

TYPE_CHECKING = False
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence
    from pathlib import Path

    from tfsat_host.present.output import Output

_SEQUENCER = ("arm", "disarm", "jog", "upload-sequence", "upload-servos", "flash sequencer")
_LOGGER = ("record", "log", "logger-settings", "flash logger", "calibrate")
_EITHER = ("status", "preflight", "acceptance")
_MOVES_JOINTS = ("calibrate scale", "calibrate servo")
"""They need the sequencer, too."""


def complete_command(step: NextStep, args: Namespace) -> NextStep:
    """Add to a command the options that the running one was given (`args`) and that it takes, unless it has them."""
    if "--help" in step.arguments:
        return step
    if getattr(args, "emulated", False) and "--port" in step.arguments:
        # A board that was found inside this process has no port that could be typed.
        at = step.arguments.index("--port")
        step = NextStep(step.command, step.arguments[:at] + step.arguments[at + 2 :])
    for recording in _recording(args) if step.command == "decode" else ():
        step = step.with_recording(recording)
    options = (*_files(step, args), *_devices(step, args))
    added = [word for option in options if option[0] not in step.arguments for word in option]
    return step.with_arguments(*added)


def advise_on_drop(place: Path, args: Namespace, out: Output) -> None:
    """Complete commands for one drop of several, at `place` as typed, from now on."""
    of_drop = type(args)(**{**vars(args), "runs": [place]})
    out.complete_command = lambda step: complete_command(step, of_drop)


def _recording(args: Namespace) -> tuple[str, ...]:
    """Return the recording that the running command reads; nothing if it reads none, or several."""
    from tfsat_host.run.files import run_files

    running = getattr(args, "command", "")
    if running == "decode":
        return (str(args.file),)
    # `rehearse` has its recording in --out; its `runs` is a number.
    places: Sequence[Path] = [args.out] if running == "rehearse" else getattr(args, "runs", ())
    if len(places) != 1:
        return ()
    try:
        return (str(run_files(places[0], None).recording),)
    except TfsatError:
        # A folder without a recording, or with several, has an error of its own.
        return ()


def _files(step: NextStep, args: Namespace) -> Iterator[tuple[str, ...]]:
    running = getattr(args, "command", "")
    of_files = {
        "calibrate": ("out", "robot"),
        "acceptance": ("out", "robot"),
        "preflight": ("robot",),
        "flash": ("hex",),
    }
    names = of_files.get(running, ())
    for name in names if f"{step.command} ".startswith(f"{running} ") else ():
        if getattr(args, name, None) is not None:
            yield f"--{name}", str(getattr(args, name))


def _devices(step: NextStep, args: Namespace) -> Iterator[tuple[str, ...]]:
    boards = _boards(step.command)
    if not boards or "emulated" not in args:
        return
    # A recording says itself whose it is.
    if "--log" in step.arguments:
        return
    if args.emulated:
        yield ("--emulated",)
        return
    # The certificate is on the disk: showing it asks no board.
    if step.command == "calibrate show":
        return
    ports = _ports(args)
    if step.command in ("preflight", "acceptance"):
        for board, option in (("sequencer", "--port"), ("logger", "--logger-port")):
            if board in ports:
                yield option, ports[board]
        return
    # Of two ports the right one for `status` depends on why it is recommended; without one it finds both boards.
    named = [ports[board] for board in boards if board in ports]
    if len(set(named)) == 1:
        yield "--port", named[0]
    if step.command in _MOVES_JOINTS and "sequencer_port" in args and "sequencer" in ports:
        yield "--sequencer-port", ports["sequencer"]


def _boards(command: str) -> tuple[str, ...]:
    """Return the boards that a command may talk to under its option --port."""
    for names, boards in (
        (_SEQUENCER, ("sequencer",)),
        (_LOGGER, ("logger",)),
        (_EITHER, ("sequencer", "logger")),
    ):
        if any(command == name or command.startswith(f"{name} ") for name in names):
            return boards
    return ()


def _ports(args: Namespace) -> dict[str, str]:
    """Return the ports that were named, by board."""
    if "port" not in args:
        return {}
    if "logger_port" in args:
        ports = {"sequencer": args.port, "logger": args.logger_port}
    elif "sequencer_port" in args:
        ports = {"sequencer": args.sequencer_port, "logger": args.port}
    else:
        running = f"{args.command} {getattr(args, 'board', '')}".strip()
        ports = dict.fromkeys(_boards(running) or ("sequencer", "logger"), args.port)
    return {board: port for board, port in ports.items() if port is not None}
