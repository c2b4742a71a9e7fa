"""Everything of one robot, kept on disk: a campaign that was stopped goes on where it was."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tests.calibration_proof.robots import Errors
from tests.evaluation_proof.flights import (
    BODIES,
    Flight,
    drops_of,
    flights_of,
    with_dead_gyro,
    without_calibration,
)
from tests.evaluation_proof.paper_setting import Replay, replays_of
from tests.evaluation_proof.robots import robot_of

REPOSITORY = Path(__file__).parents[2]
KEPT = REPOSITORY / "build" / "evaluation-proof"
DEAF_ROBOTS = 20
"""So many robots fly once more with each of their gyros dead."""
_CODE = ("*.py", "*.cpp", "*.h", "*.ino", "*.toml")
_ROBOT_SOURCES = (
    *(
        f"host/tfsat_host/{name}"
        for name in ("calibration", "devices", "dynamics", "emulated", "protocol", "robot")
    ),
    "firmware",
    "robots",
    "tools/emulator/src",
    "tests/calibration_proof/robots.py",
    "tests/evaluation_proof/robots.py",
)
_ALL_SOURCES = (
    *_ROBOT_SOURCES,
    *(f"host/tfsat_host/{name}" for name in ("design", "evaluation", "maneuver", "sdlog")),
    "tests/evaluation/drops.py",
    *(f"tests/evaluation_proof/{name}.py" for name in ("errors", "flights", "objective", "paper_setting")),
)


@dataclass(frozen=True, eq=False)
class Proof:
    """What came of one robot.

    Attributes:
        flights: By low-pass.
        bare: By low-pass, its drops evaluated without any calibration.
        deaf: Its drop at 42 Hz with the gyro of each body (1 to 4) dead; empty for most robots.
        replays: In the paper's way.
    """

    flights: Mapping[str, Flight]
    bare: Mapping[str, Mapping[str, Errors]]
    deaf: Mapping[int, Mapping[str, Errors]]
    replays: Mapping[str, Replay]


def prove(seed: int) -> Proof:
    """Calibrates a robot, drops it, and evaluates; half a minute, or none if that was done before."""
    found: Proof = _kept(f"proof-{seed}", _ALL_SOURCES, lambda: _proven(seed))
    return found


def _proven(seed: int) -> Proof:
    robot = _kept(f"robot-{seed}", _ROBOT_SOURCES, lambda: robot_of(seed))
    drops = drops_of(robot)
    bodies = BODIES if seed <= DEAF_ROBOTS else ()
    return Proof(
        flights_of(robot, drops),
        {low_pass: without_calibration(robot, one) for low_pass, one in drops.items()},
        {body: with_dead_gyro(robot, drops["42 Hz"], body) for body in bodies},
        replays_of(robot, drops["5 Hz"]),
    )


def _kept(name: str, sources: tuple[str, ...], made: Callable[[], Any]) -> Any:
    """What was made of the same sources before, or else is made now."""
    file = KEPT / _hash_of(sources) / f"{name}.pickle"
    if file.exists():
        return pickle.loads(file.read_bytes())
    found = made()
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_bytes(pickle.dumps(found))
    part.replace(file)
    return found


@cache
def _hash_of(sources: tuple[str, ...]) -> str:
    """Of the sources as this process found them first."""
    found = hashlib.sha256()
    for source in sources:
        place = REPOSITORY / source
        files = [place] if place.is_file() else sorted(f for kind in _CODE for f in place.rglob(kind))
        for file in files:
            found.update(str(file.relative_to(REPOSITORY)).encode() + file.read_bytes())
    return found.hexdigest()[:16]
