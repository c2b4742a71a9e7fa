"""Everything of one robot, kept on disk: a campaign that was stopped goes on where it was."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from tests.paths import REPOSITORY
from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.flights import (
    BODIES,
    Flight,
    drops_of,
    flights_of,
    with_dead_gyro,
    without_calibration,
)
from tests.validation.evaluation_proof.mismatches import ROWS, Judged, judge_drop
from tests.validation.evaluation_proof.paper_setting import Replay, replays_of
from tests.validation.evaluation_proof.robots import robot_of
from tests.validation.sources import code_sha256

KEPT = REPOSITORY / "build" / "evaluation-proof"
DEAF_ROBOTS = 20
"""So many robots fly once more with each of their gyros dead."""


@dataclass(frozen=True, eq=False)
class Proof:
    """What came of one robot.

    Attributes:
        flights: By drop.
        bare: By drop, its drops evaluated without any calibration.
        deaf: Its drop at 42 Hz with the gyro of each body (1 to 4) dead; empty for most robots.
        replays: In the paper's way.
    """

    flights: Mapping[str, Flight]
    bare: Mapping[str, Mapping[str, Errors]]
    deaf: Mapping[int, Mapping[str, Errors]]
    replays: Mapping[str, Replay]


def prove(seed: int) -> Proof:
    """Calibrates a robot, drops it, and evaluates; half a minute, or none if that was done before."""
    proof: Proof = keep_result(
        f"proof-{seed}", "tests.validation.evaluation_proof.campaign", lambda: _proven(seed)
    )
    return proof


def judge_mismatch(row: str, seed: int) -> Judged:
    """Evaluate one drop whose robot or sensors differ from the filed ones, or load its stored result."""
    (mismatch,) = (candidate for candidate in ROWS if candidate.name == row)
    module = "tests.validation.evaluation_proof.mismatches"
    outcome: Judged = keep_result(
        f"mismatch-{ROWS.index(mismatch)}-{seed}", module, lambda: judge_drop(mismatch, seed)
    )
    return outcome


def _proven(seed: int) -> Proof:
    # Stored by itself: it depends on less code than its drops do.
    robot = keep_result(f"robot-{seed}", "tests.validation.evaluation_proof.robots", lambda: robot_of(seed))
    drops = drops_of(robot)
    # Dead gyros need four more evaluations: only the first robots fly with them.
    bodies = BODIES if seed <= DEAF_ROBOTS else ()
    return Proof(
        flights_of(robot, drops),
        {flight_name: without_calibration(robot, drop) for flight_name, drop in drops.items()},
        {body: with_dead_gyro(robot, drops["42 Hz"], body) for body in bodies},
        replays_of(robot, drops["5 Hz"]),
    )


def keep_result(name: str, module: str, compute: Callable[[], Any]) -> Any:
    """Load the stored result of the same code, or compute and store it.

    The code is that of `module` and of all that it imports.
    """
    # The hash of the code is a folder: a change of the code never reads old results.
    file = KEPT / _code_of(module) / f"{name}.pickle"
    if file.exists():
        return pickle.loads(file.read_bytes())
    result = compute()
    file.parent.mkdir(parents=True, exist_ok=True)
    # Written aside and renamed: a stopped campaign leaves no half pickle.
    part = file.with_suffix(".part")
    part.write_bytes(pickle.dumps(result))
    part.replace(file)
    return result


@cache
def _code_of(module: str) -> str:
    """Return the short hash of the module's code as this process first found it."""
    return code_sha256(module)[:16]
