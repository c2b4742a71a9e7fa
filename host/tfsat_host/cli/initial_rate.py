"""`--initial-rate`: how the robot turns when it is released."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from tfsat_host.cli.options import number
from tfsat_host.errors import UsageError

if TYPE_CHECKING:
    from tfsat_host.robot.model import FloatArray

FASTEST_DEG_S = 100_000.0


def add_initial_rate_option(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """`--initial-rate X Y Z`."""
    parser.add_argument(
        "--initial-rate",
        metavar=("X", "Y", "Z"),
        nargs=3,
        type=number,
        help="angular rate of the base body at the release, in its own axes, deg/s (default: no angular momentum)",
    )


def initial_rate_rad_s(args: argparse.Namespace) -> FloatArray | None:
    """The rate (3,) that was given; None: no angular momentum.

    Raises:
        UsageError: this is no rate that a robot can have.
    """
    import numpy as np

    if args.initial_rate is None:
        return None
    size = math.hypot(*args.initial_rate)
    if not size <= FASTEST_DEG_S:
        problem = f"is beyond {FASTEST_DEG_S:g} deg/s" if math.isfinite(size) else "is no rate"
        raise UsageError(
            what=f"The initial rate {args.initial_rate} {problem}.",
            meaning="No robot turns like that. Nothing was computed.",
            next_step="Give three numbers, deg/s: --initial-rate 0 0 1.5",
        )
    return np.asarray(np.radians(args.initial_rate))
