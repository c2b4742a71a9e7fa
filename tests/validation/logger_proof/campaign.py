"""The fault campaign: runs of many seeds, each read back by the decoder and judged."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from tests.validation.campaign import Broken, Campaign
from tests.validation.logger_proof.judge import Outcome, judge
from tests.validation.logger_proof.truth import Kind, read_truth

SEEDS = 2880
"""Of the full form: 90 of each kind of fault at each rate."""
RATES_HZ = (280, 1000)
BATCH = 24
RUN_LIMIT_S = 120


def runs(program: Path, count: int, batch: int = BATCH) -> Campaign:
    """Declare the fault campaign: `count` seeds from 0 on."""
    judged = "nothing lost that the card had, nothing wrong, every event there, nothing hidden"
    return Campaign(
        "runs", judged, [partial(run_and_judge, program, count=batch)] * (count // batch), 0, batch
    )


def seeds_of(kind: Kind, count: int) -> list[int]:
    """Return the first `count` seeds whose runs are of this kind, alternating between both rates."""
    # Kinds repeat every len(Kind) seeds; the rate alternates with the next such block.
    return [kind + number * len(Kind) for number in range(count)]


def run_and_judge(program: Path, seed: int, count: int = 1) -> list[Outcome]:
    """Run and judge `count` seeds from `seed` on.

    Raises Broken if a promise was not kept or the program failed.
    """
    # In memory where that is possible: a card's image is 1 to 2 MiB.
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(prefix="tfsat-", dir=memory if memory.is_dir() else None) as name:
        folder = Path(name)
        run(program, seed, count, folder)
        return [outcome for number in range(seed, seed + count) for outcome in _judge(folder, number)]


def run_each(program: Path, seeds: Sequence[int]) -> list[Outcome]:
    """Run and judge each of these seeds.

    Raises Broken if a promise was not kept or the program failed.
    """
    return [outcome for seed in seeds for outcome in run_and_judge(program, seed)]


def run(program: Path, first: int, count: int, folder: Path) -> None:
    """Leaves SEED.bin, SEED.ram and SEED.truth in the folder. Raises Broken: the program failed."""
    command = [str(program), str(first), str(count), str(folder)]
    # A run that hangs is broken, too.
    process = subprocess.run(command, capture_output=True, text=True, check=False, timeout=RUN_LIMIT_S)
    if process.returncode != 0:
        raise Broken(
            f"seeds {first} to {first + count - 1}: exit code {process.returncode}\n{process.stderr}"
        )


def _judge(folder: Path, seed: int) -> list[Outcome]:
    outcomes = [judge(folder, truth) for truth in read_truth(folder / f"{seed}.truth")]
    # Images of 1 to 2 MiB a run: removed as soon as they are judged.
    for image in folder.glob(f"{seed}.*"):
        image.unlink()
    return outcomes
