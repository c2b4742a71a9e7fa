"""The emulated robot's drop as cards bring it home: the verdict, the exit code, and no wrong value."""

from __future__ import annotations

import numpy as np
import pytest

from tests.paths import DOCS
from tests.sdlog.test_decode_command import decode_json
from tests.validation.decode_bench.report import describe_drop
from tests.validation.decode_bench.scenarios import CUT_AT_S, NOISE_SHARE, Scenario, make
from tests.validation.tables import read_rows
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.sdlog import DropLog, load

DECODED = DOCS / "decode-report" / "drops.csv"


@pytest.fixture(scope="module")
def scenarios(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Scenario]:
    all_scenarios = make(tmp_path_factory.mktemp("scenarios"))
    return {scenario.path.name: scenario for scenario in all_scenarios}


def assert_no_wrong_value(log: DropLog, complete_log: DropLog) -> None:
    """Assert that every sample and every event of `log` is also in the complete recording."""
    rows = np.searchsorted(complete_log.sample_index, log.sample_index)
    for name in ("sample_index", "t_us", "imu_counts", "angle_counts", "imu_valid", "switch_open", "clipped"):
        np.testing.assert_array_equal(getattr(log, name), getattr(complete_log, name)[rows])
    assert set(log.events) <= set(complete_log.events)


@pytest.mark.parametrize(
    ("name", "verdict", "exit_code"),
    [
        ("clean.bin", "complete", 0),
        ("cut.bin", "truncated", 3),
        ("noisy.bin", "damaged", 3),
        ("card.img", "complete", 0),
    ],
)
def test_verdict_exit_code_and_values(
    scenarios: dict[str, Scenario], name: str, verdict: str, exit_code: int
) -> None:
    scenario = scenarios[name]
    facts = decode_json(scenario.path, expect=exit_code)
    log, complete_log = load(scenario.path), load(scenario.card)
    assert [str(cell) for cell in describe_drop(scenario, exit_code, facts)] in read_rows(DECODED)
    assert (facts["verdict"], log.verdict, log.session) == (verdict, verdict, complete_log.session)
    assert_no_wrong_value(log, complete_log)
    if name == "cut.bin":
        assert log.release == complete_log.release
        assert abs(log.t_s[-1] - CUT_AT_S) < 0.03
    if name == "noisy.bin":
        hit = log.set_aside.foreign + log.set_aside.torn
        assert hit == round(NOISE_SHARE * scenario.card.stat().st_size / BLOCK_BYTES)
        assert log.blocks_lost == hit
        assert log.samples_lost == len(complete_log) - len(log)
        if log.release is not None and complete_log.release is not None:
            assert log.release.earliest_us <= complete_log.release.t_us <= log.release.latest_us
    if name in ("clean.bin", "card.img"):
        assert len(log) == len(complete_log)
    if name == "card.img":
        assert (facts["chosen_by"], len(facts["other_sessions"])) == ("time of day", 1)
