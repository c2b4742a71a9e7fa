"""Options of a drop that is to be evaluated, for every command that evaluates one."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from tfsat_host.cli.options import file_name, output_file_name, session_id
from tfsat_host.run.files import EvaluationOptions

_KNOWN = {
    "maneuver": "what was flown (default: maneuver.toml next to the recording)",
    "calibration": "certificate of the sensors (default: calibration.toml next to the recording or here, of an "
    "emulated robot calibration-emulated.toml); that of the drop is found among its recordings",
    "robot": "a robot file, or the name of a robot that tfsat brings along (default: robot.toml next to the recording, "
    "else drop_tower)",
    "video": "events of the drop in a video (CSV: event,t_s)",
    "laser": "places of the two laser spots over time (CSV: t_s,spot,along_mm,up_mm)",
    "facility": "a facility file, for the release velocity (default: COSMOTORRE's)",
}


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
    known = parser.add_argument_group("what else is known of the drop")
    for name, text in _KNOWN.items():
        known.add_argument(f"--{name}", metavar="FILE", type=file_name, help=text)
    parser.add_argument(
        "--swarm",
        action="store_true",
        help="find the centers of mass by the paper's particle swarm as well, for comparison",
    )


def add_out(
    parser: argparse.ArgumentParser, what: str, kind: Callable[[str], Path] = output_file_name
) -> None:
    """`--out FILE` and `--force`."""
    parser.add_argument("--out", metavar="FILE", type=kind, help=what)
    parser.add_argument(
        "--force", action="store_true", help="overwrite a file that this command did not make"
    )


def options_of(args: argparse.Namespace) -> EvaluationOptions:
    """What was typed, of a parser with `add_run_arguments`; RUN aside."""
    return EvaluationOptions(**{one.name: getattr(args, one.name) for one in fields(EvaluationOptions)})
