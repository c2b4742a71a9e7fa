"""A short fuzzing run of the link's frame receiver and of the whole board; and that it would find a defect.

`make fuzz` runs the same targets for longer.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.fixtures.planting import Edit, plant
from tests.paths import REPOSITORY
from tests.validation.fuzz.fuzzing import BOARD, FRAME, TARGETS, Target, build, fuzz

RUNS = {FRAME.name: 100_000, BOARD.name: 10_000}
SHARED = (
    "tests/validation/fuzz",
    "tests/fixtures",
    "firmware/arduino_sequencer/src",
    "tools/emulator/src/boards",
)
FRAME_HEADER = "firmware/arduino_sequencer/src/protocol/frame.h"
SEQUENCER = "firmware/arduino_sequencer/src/core/sequencer.cpp"

# Defects as a person might make them.
FRAME_DEFECTS = {
    "crc not checked": Edit(FRAME_HEADER, "crc16(buffer_, size_ - 2) ==", "0 * crc16(buffer_, size_ - 2) <="),
    "frame too long": Edit(FRAME_HEADER, "!overflow_ && ", ""),
    "frame too short": Edit(FRAME_HEADER, "size_ >= kFrameOverheadBytes", "size_ >= 3"),
    "run cut short": Edit(FRAME_HEADER, "run_left_ == 0 && size_", "size_"),
    "buffer overrun": Edit(FRAME_HEADER, "size_ < sizeof buffer_", "size_ <= sizeof buffer_"),
    "run of 254": Edit(FRAME_HEADER, "zero_pending_ = byte != 0xFF", "zero_pending_ = true"),
}
BOARD_DEFECTS = {
    "any token arms": Edit(SEQUENCER, "if (token != retained_.token)", "if (token == 0)"),
    "a servo snaps back": Edit(
        SEQUENCER, "if (state_ == SequencerState::kDone && !near", "if (false && !near"
    ),
    "an open switch arms": Edit(
        SEQUENCER, "if (switches_.levels() != 0) return", "if (switches_.levels() == 3) return"
    ),
}


def copy_with_defect(tree: Path, defect: Edit) -> Path:
    """Copy what the targets are built from, with one defect in it."""
    for folder in SHARED:
        shutil.copytree(REPOSITORY / folder, tree / folder)
    plant(tree, [defect])
    return tree


def assert_found(target: Target, folder: Path, tree: Path, broken: str) -> None:
    """Assert that the short run finds the defect and keeps the input that shows it.

    The defect's description must contain `broken`.
    """
    outcome = fuzz(build(target, folder, tree), target, RUNS[target.name])
    assert len(outcome.findings) == 1, outcome.log
    assert broken in outcome.defect, outcome.log
    # Found before the run's end, or the seeds and the corpus would not suffice for `make test`.
    assert outcome.executions < RUNS[target.name]


@pytest.mark.parametrize("share", [0.2, pytest.param(1.0, marks=pytest.mark.prove)])
@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_nothing_is_found(target: Target, share: float, tmp_path: Path) -> None:
    """Replays the committed corpus and the seeds, then goes on from them."""
    input_count = len(list(target.corpus.iterdir())) + len(target.seeds)
    runs = round(share * RUNS[target.name])
    # Seeds and corpus are replayed first and count as runs.
    outcome = fuzz(build(target, tmp_path / "build"), target, runs)
    assert not outcome.findings, outcome.log
    # More runs than inputs at hand: fuzzing itself took place, too.
    assert outcome.executions >= runs > input_count
    assert outcome.corpus_size > len(target.seeds) / 2  # it was given what it should know


@pytest.mark.prove
@pytest.mark.parametrize("defect", FRAME_DEFECTS.values(), ids=FRAME_DEFECTS)
def test_a_defect_of_the_receiver_is_found(defect: Edit, tmp_path: Path) -> None:
    assert_found(FRAME, tmp_path / "build", copy_with_defect(tmp_path / "tree", defect), "")


@pytest.mark.prove
@pytest.mark.parametrize(
    ("defect", "broken"),
    [
        ("any token arms", "== token"),
        ("a servo snaps back", "kStartPoseToleranceCdeg"),
        ("an open switch arms", "switches_open() == 0"),
    ],
    ids=BOARD_DEFECTS,
)
def test_a_defect_of_the_sequencer_is_found(defect: str, broken: str, tmp_path: Path) -> None:
    tree = copy_with_defect(tmp_path / "tree", BOARD_DEFECTS[defect])
    assert_found(BOARD, tmp_path / "build", tree, broken)
