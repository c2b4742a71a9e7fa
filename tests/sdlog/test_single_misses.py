"""Single readings that a sensor missed are told, and speak against nothing; more of them do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder
from tfsat_host.sdlog import load
from tfsat_host.sdlog.summary import grave_warnings, single_misses, warnings

WITHOUT_IMU_2 = ALL_VALID & ~0x2


def test_single_misses_are_few_and_alone() -> None:
    valid = np.ones(1000, bool)
    assert single_misses(valid)
    valid[[3, 5, 900]] = False
    assert single_misses(valid)
    valid[4] = False
    assert not single_misses(valid)
    often = np.ones(1000, bool)
    often[:22:2] = False
    assert not single_misses(often)


@pytest.mark.parametrize(("samples", "grave"), [(1, 0), (2, 1)])
def test_one_is_told_and_not_grave(tmp_path: Path, samples: int, grave: int) -> None:
    recorder = Recorder()
    for block in range(60):
        if block == 30:
            recorder.data(samples, flags=WITHOUT_IMU_2)
        recorder.data()
    recorder.close()
    path = tmp_path / "SD.bin"
    path.write_bytes(recorder.image())
    log = load(path)
    assert [line for line in warnings(log) if "IMU of body 2" in line]
    assert len(grave_warnings(log)) == grave
