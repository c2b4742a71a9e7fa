"""When the robot was released, among handling, chatter, knocks and lost edges."""

from __future__ import annotations

import numpy as np
import pytest

from tfsat_host.sdlog.events import DropEvent, release_time_us

T_US = np.arange(0, 4_000_000, 4000, dtype=np.int64)


def edge(t_us: int, switch: int, is_open: bool) -> DropEvent:
    return DropEvent(t_us, "switch_edge", switch, int(is_open), 0)


def stroke(t_us: int) -> DropEvent:
    return DropEvent(t_us, "stroke", 0, 0, 0)


def levels(*opened_us: int) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    return np.stack([opened_us[switch] <= T_US for switch in range(2)], axis=1)


NEVER = 1 << 60
CLOSED = levels(NEVER, NEVER)


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
    assert release_time_us(tuple(events), T_US, CLOSED) == expected


def test_lost_edges_are_replaced_by_the_samples() -> None:
    assert release_time_us((), T_US, levels(1_000_000, 1_200_000)) == 1_200_000
    assert release_time_us((edge(1_198_500, 1, True),), T_US, levels(1_000_000, 1_200_000)) == 1_200_000


def test_switches_that_were_open_from_the_start_are_no_release() -> None:
    assert release_time_us((), T_US, levels(0, 0)) is None
