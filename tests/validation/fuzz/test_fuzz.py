"""A short fuzzing run of the link's frame receiver and of the whole board; and that it would find a defect.

`make fuzz` runs the same targets for longer.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.paths import REPOSITORY
from tests.validation.fuzz.fuzzing import BOARD, FRAME, TARGETS, Target, build, fuzz

RUNS = {FRAME.name: 100_000, BOARD.name: 10_000}
SHARED = ("tests/validation/fuzz", "firmware/arduino_sequencer/src", "tools/emulator/src/boards")
FRAME_HEADER = "firmware/arduino_sequencer/src/protocol/frame.h"
SEQUENCER = "firmware/arduino_sequencer/src/core/sequencer.cpp"

# Defects as a person might make them: file, what stands there, what is planted instead.
FRAME_DEFECTS = {
    "crc not checked": ("crc16(buffer_, size_ - 2) ==", "0 * crc16(buffer_, size_ - 2) <="),
    "frame too long": ("!overflow_ && ", ""),
    "frame too short": ("size_ >= kFrameOverheadBytes", "size_ >= 3"),
    "run cut short": ("run_left_ == 0 && size_", "size_"),
    "buffer overrun": ("size_ < sizeof buffer_", "size_ <= sizeof buffer_"),
    "run of 254": ("zero_pending_ = byte != 0xFF", "zero_pending_ = true"),
}
BOARD_DEFECTS = {
    "any token arms": ("if (token != retained_.token)", "if (token == 0)"),
    "a servo snaps back": ("if (state_ == SequencerState::kDone && !near", "if (false && !near"),
    "an open switch arms": ("if (switches_.levels() != 0) return", "if (switches_.levels() == 3) return"),
}


def planted(tree: Path, file: str, defect: tuple[str, str]) -> Path:
    """A copy of what the targets are built from, with one defect in it."""
    for folder in SHARED:
        shutil.copytree(REPOSITORY / folder, tree / folder)
    sound = (tree / file).read_text()
    assert sound.count(defect[0]) == 1, f"{file} has changed: plant the defect again"
    (tree / file).write_text(sound.replace(*defect))
    return tree


def assert_found(target: Target, folder: Path, tree: Path, broken: str) -> None:
    """The short run finds the defect, tells it by `broken`, and keeps the input that shows it."""
    outcome = fuzz(build(target, folder, tree), target, RUNS[target.name])
    assert len(outcome.findings) == 1, outcome.log
    assert broken in outcome.defect, outcome.log
    assert outcome.executions < RUNS[target.name]


@pytest.mark.parametrize("share", [0.2, pytest.param(1.0, marks=pytest.mark.prove)])
@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_nothing_is_found(target: Target, share: float, tmp_path: Path) -> None:
    """Replays the committed corpus and the seeds, then goes on from them."""
    known = len(list(target.corpus.iterdir())) + len(target.seeds)
    runs = round(share * RUNS[target.name])
    outcome = fuzz(build(target, tmp_path / "build"), target, runs)
    assert not outcome.findings, outcome.log
    assert outcome.executions >= runs > known
    assert outcome.corpus_size > len(target.seeds) / 2  # it was given what it should know


@pytest.mark.prove
@pytest.mark.parametrize("defect", FRAME_DEFECTS.values(), ids=FRAME_DEFECTS)
def test_a_defect_of_the_receiver_is_found(defect: tuple[str, str], tmp_path: Path) -> None:
    assert_found(FRAME, tmp_path / "build", planted(tmp_path / "tree", FRAME_HEADER, defect), "")


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
    tree = planted(tmp_path / "tree", SEQUENCER, BOARD_DEFECTS[defect])
    assert_found(BOARD, tmp_path / "build", tree, broken)
