"""Damaged logs by the thousand, judged against the truth; `make fuzz-decode` does it a million times."""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.validation.fuzz.log_mutations import Script, check, mutate_log, pristine
from tfsat_host.sdlog import blocks, copies
from tfsat_host.sdlog.block_decoder import Footers

RUNS = 300


def scripts(count: int) -> Iterator[bytes]:
    # The same scripts every time: a failure can be repeated.
    chance = random.Random(4)
    for _ in range(count):
        yield chance.randbytes(chance.randint(0, 60))


def outcomes(folder: Path) -> Counter[str]:
    return Counter(check(script, folder / "SD.bin") for script in scripts(RUNS))


def test_every_damaged_log_is_right_or_flagged(tmp_path: Path) -> None:
    came_of_it = outcomes(tmp_path)
    assert came_of_it.total() == RUNS
    for outcome in ("complete", "truncated", "damaged", "refused", "resealed: damaged"):
        # Every outcome must occur in at least 2 % of the runs, or the test would judge too little.
        assert came_of_it[outcome] > RUNS // 50, came_of_it


def test_an_empty_script_leaves_the_log_as_it_is(tmp_path: Path) -> None:
    assert mutate_log(Script(b"")).data == pristine()
    assert check(b"", tmp_path / "SD.bin") == "complete"


def test_a_crc_that_is_not_checked_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The fault: every block counts as intact.
    monkeypatch.setattr(blocks, "_crc_is_right", lambda data: np.ones(len(data) // 512, np.bool_))
    with pytest.raises((AssertionError, ValueError)):
        outcomes(tmp_path)


def test_blocks_of_the_wrong_recording_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Detect a decoder that takes blocks of the wrong recording.

    All blocks are given the same session, so that the old recording's would fill the new one's gaps.
    """

    def one_session(data: memoryview) -> blocks.BlockScan:
        looked = blocks.look(data)
        # Blocks of the remains now claim to be of the new recording.
        looked.heads["session"] = 0x1234ABCD
        return looked

    monkeypatch.setattr(copies, "look", one_session)
    # `load` imported the function by name: both references are replaced.
    monkeypatch.setattr(sys.modules["tfsat_host.sdlog.load"], "look", one_session)
    with pytest.raises((AssertionError, KeyError)):
        outcomes(tmp_path)


def test_a_second_end_that_is_overlooked_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_end_counts(self: Footers, number: int, payload: bytes) -> None:
        self.last_number = number

    monkeypatch.setattr(Footers, "add", no_end_counts)
    with pytest.raises(AssertionError):
        assert check(b"", tmp_path / "SD.bin") == "complete"
