"""What can be said of a drop that is to be evaluated, for every command that evaluates one."""

from __future__ import annotations

import argparse

from tfsat_host.cli.options import file_name, session_id
from tfsat_host.errors import UsageError


def add_run_arguments(parser: argparse.ArgumentParser) -> None:
    """RUN, and the files that belong to it."""
    parser.add_argument(
        "runs",
        metavar="RUN",
        nargs="+",
        type=file_name,
        help="a recording off the card, or a folder with SD.bin (or with one other recording) as `rehearse` leaves it; "
        "several: one each drop of the same robot, compared",
    )
    parser.add_argument(
        "--session",
        metavar="ID",
        type=session_id,
        help="which recording of the file, 8 hex digits (default: as decode chooses)",
    )
    beside = parser.add_argument_group("what else is known of the drop")
    beside.add_argument(
        "--maneuver",
        metavar="FILE",
        type=file_name,
        help="what was flown (default: maneuver.toml beside the recording)",
    )
    beside.add_argument(
        "--calibration",
        metavar="FILE",
        type=file_name,
        help="certificate of the sensors (default: calibration.toml beside the recording or here, of an emulated robot "
        "calibration-emulated.toml); that of the drop is found among its recordings",
    )
    beside.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: robot.toml beside the recording, "
        "else drop_tower)",
    )
    beside.add_argument(
        "--video", metavar="FILE", type=file_name, help="events of the drop in a video (CSV: event,t_s)"
    )
    beside.add_argument(
        "--laser",
        metavar="FILE",
        type=file_name,
        help="places of the two laser spots over time (CSV: t_s,spot,along_mm,up_mm)",
    )
    beside.add_argument(
        "--facility",
        metavar="FILE",
        type=file_name,
        help="a facility file, for the release velocity (default: COSMOTORRE's)",
    )
    model = parser.add_argument_group("what of the model may be corrected, besides centers of mass")
    model.add_argument("--masses", action="store_true", help="the bodies' masses too")
    model.add_argument("--inertias", action="store_true", help="the bodies' inertia tensors too")
    model.add_argument(
        "--swarm",
        action="store_true",
        help="find the centers of mass by the paper's particle swarm as well, for comparison",
    )


def options_given(args: argparse.Namespace) -> tuple[str, ...]:
    """What of these was typed, as it is typed, RUN aside; for the provenance of results."""
    named = ("maneuver", "calibration", "robot", "video", "laser", "facility")
    given = [f"--{name} {getattr(args, name)}" for name in named if getattr(args, name) is not None]
    given += [f"--session {args.session:08x}"] if args.session is not None else []
    return (*given, *(f"--{name}" for name in ("masses", "inertias", "swarm") if getattr(args, name)))


def check_run_arguments(args: argparse.Namespace) -> None:
    """What belongs to one drop only is refused for several.

    Raises:
        UsageError: it was given for several, or a drop twice, or a facility for nothing.
    """
    if args.facility is not None and args.laser is None:
        raise _wrong(
            "--facility says what release velocity is permitted, and only --laser tells that velocity."
        )
    if args.swarm and (args.masses or args.inertias):
        raise _wrong("--swarm searches for centers of mass alone, as the paper's does.")
    if len(args.runs) == 1:
        return
    for name in ("session", "video", "laser"):
        if getattr(args, name) is not None:
            raise _wrong(f"--{name} belongs to one drop, and {len(args.runs)} were named.")
    places = [place.resolve() for place in args.runs]
    twice = next((run for i, run in enumerate(args.runs) if places[i] in places[:i]), None)
    if twice is not None:
        raise _wrong(f"{twice} was named twice: one drop says nothing about itself.")


def _wrong(what: str) -> UsageError:
    return UsageError(what=what, meaning="Nothing was evaluated.", next_step="tfsat-host evaluate --help")
