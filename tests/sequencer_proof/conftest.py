"""The image and the boards that the short forms of the campaigns run on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.emulator_avr.building import (
    SEQUENCER,
    build_board_library,
    build_changed_sequencer,
    build_sketch,
)
from tests.sequencer_proof.rigs import Bench

Plant = Callable[..., Bench]


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """The image that would be flashed."""
    folder = tmp_path_factory.mktemp("proof")
    return Bench.of(build_sketch(SEQUENCER, folder / "sequencer"), build_board_library(folder))


@pytest.fixture
def plant(bench: Bench, tmp_path: Path) -> Plant:
    """Makes a bench whose image has a defect: `plant(Edit(file, text, replacement), ...)`."""
    return lambda *edits: replace(bench, image=build_changed_sequencer(edits, tmp_path, bench.image))
