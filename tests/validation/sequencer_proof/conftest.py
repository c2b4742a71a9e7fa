"""The image and the boards that the short forms of the campaigns run on."""

from __future__ import annotations

import fcntl
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.arduino_sequencer.avr.conftest import LOCK
from tests.fixtures.sequencer.building import build_avr_library, build_changed_sequencer
from tests.validation.sequencer_proof.bench import Bench
from tfsat_host.emulated import build

Plant = Callable[..., Bench]


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """Return the test bench with the image that would be flashed: that of `make firmware`."""
    with LOCK.open("w") as lock:
        # Tests run in parallel processes: only one of them may compile the image.
        fcntl.flock(lock, fcntl.LOCK_EX)
        image = build.sequencer_hex()
    return Bench.of(image, build_avr_library(tmp_path_factory.mktemp("proof")))


@pytest.fixture
def plant(bench: Bench, tmp_path: Path) -> Plant:
    """Makes a bench whose image has a defect: `plant(Edit(file, text, replacement), ...)`."""
    return lambda *edits: replace(bench, image=build_changed_sequencer(edits, tmp_path, bench.image))
