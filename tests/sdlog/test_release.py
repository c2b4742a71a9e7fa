"""When the robot was released, among handling, chatter, knocks and lost edges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import drop_with_release
from tests.sdlog.test_values import write
from tfsat_host.sdlog import load
from tfsat_host.sdlog.events import DropEvent
from tfsat_host.sdlog.release import find_release

T_US = np.arange(0, 4_000_000, 4000, dtype=np.int64)


def edge(t_us: int, switch: int, is_open: bool) -> DropEvent:
    return DropEvent(t_us, "switch_edge", switch, int(is_open), 0)


def stroke(t_us: int) -> DropEvent:
    return DropEvent(t_us, "stroke", 0, 0, 0)


def levels(*opened_us: int) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    return np.stack([opened_us[switch] <= T_US for switch in range(2)], axis=1)


NEVER = 1 << 60


def sampled(events: list[DropEvent]) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """What the samples show of the edges."""
    shown = levels(NEVER, NEVER)
    for event in events:
        if event.name == "switch_edge":
            shown[event.t_us <= T_US, event.index] = bool(event.arg)
    return shown


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ([], None),
        ([edge(1_000_000, 0, True)], None),
        ([edge(1_000_000, 0, True), edge(1_000_250, 1, True)], 1_000_250),
        # Chatter after the first moment at which both were open.
        (
            [
                edge(1_000_000, 0, True),
                edge(1_000_250, 1, True),
                edge(1_001_000, 0, False),
                edge(1_003_000, 0, True),
            ],
            1_000_250,
        ),
        # A knock: both open, for less than the debounce; then the release.
        (
            [
                edge(1_000_000, 0, True),
                edge(1_000_100, 1, True),
                edge(1_002_000, 0, False),
                edge(1_002_100, 1, False),
                edge(2_000_000, 1, True),
                edge(2_000_300, 0, True),
            ],
            2_000_300,
        ),
        # Handled before the drop: the release is the last before the strokes.
        (
            [
                edge(500_000, 0, True),
                edge(500_000, 1, True),
                edge(900_000, 0, False),
                edge(900_000, 1, False),
                edge(1_500_000, 0, True),
                edge(1_500_700, 1, True),
                stroke(2_200_700),
                edge(3_000_000, 0, False),
                edge(3_000_000, 1, False),
                edge(3_100_000, 0, True),
                edge(3_100_000, 1, True),
            ],
            1_500_700,
        ),
    ],
)
def test_release(events: list[DropEvent], expected: int | None) -> None:
    found = find_release(events, T_US, sampled(events))
    assert (found.t_us if found else None) == expected
    assert found is None or found.uncertainty_us == 0


def test_lost_edges_are_replaced_by_the_samples_and_their_uncertainty() -> None:
    shown = levels(1_000_000, 1_200_000)
    found = find_release((), T_US, shown)
    assert found is not None
    assert (found.earliest_us, found.t_us, found.latest_us) == (1_196_000, 1_200_000, 1_200_000)


def test_switches_that_were_open_from_the_start_are_no_release() -> None:
    assert find_release((), T_US, levels(0, 0)) is None


@pytest.mark.parametrize("run", [1, 2, 3, 10, 40])
def test_whatever_blocks_are_lost_the_release_is_right_or_its_uncertainty_covers_it(
    run: int, tmp_path: Path
) -> None:
    recorder, release_us = drop_with_release()
    flagged = 0
    for first in range(1, len(recorder.blocks) - run):
        left = recorder.blocks[:first] + recorder.blocks[first + run :]
        log = load(write(tmp_path / "SD.bin", b"".join(left)))
        if log.release is None:
            assert log.verdict != "complete"
            assert log.doubts, "strokes without a release are doubtful"
            continue
        assert log.release.earliest_us <= release_us <= log.release.latest_us, first
        if log.release_us != release_us:
            flagged += 1
            assert log.t_s_origin == "release (doubtful)"
            assert any("release switches are lost" in doubt for doubt in log.doubts)
    assert flagged
