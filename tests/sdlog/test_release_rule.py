"""The decoder's release rule is the sequencer's: both run on the same switch edges."""

from __future__ import annotations

import ctypes
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.protocol.native import REPOSITORY, build_shared
from tfsat_host.protocol.limits import RELEASE_DEBOUNCE_US
from tfsat_host.sdlog.release import SwitchEdge, release_times

END_US = 400_000
# Gaps between edges: chatter, near the debounce (but never within a poll of it), rest.
GAPS_US = st.one_of(
    st.integers(1, 3000),
    st.integers(RELEASE_DEBOUNCE_US - 900, RELEASE_DEBOUNCE_US - 200),
    st.integers(RELEASE_DEBOUNCE_US + 200, 30_000),
)
TOGGLES = st.lists(st.tuples(GAPS_US, st.integers(0, 1)), max_size=60)


@pytest.fixture(scope="module")
def detector(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    core = REPOSITORY / "firmware" / "arduino_sequencer" / "src" / "core"
    sources = [Path(__file__).with_name("release_bridge.cpp"), core / "release_detector.cpp"]
    library = ctypes.CDLL(str(build_shared(sources, tmp_path_factory.mktemp("release") / "release.so", [])))
    library.first_release_us.restype = ctypes.c_int64
    return library


def switch_edges(toggles: list[tuple[int, int]]) -> list[SwitchEdge]:
    """Each toggle changes one switch, both closed at first, after its gap."""
    t_us, opened = 20_000, [False, False]
    edges = []
    for gap_us, switch in toggles:
        t_us += gap_us
        opened[switch] = not opened[switch]
        edges.append((t_us, switch, opened[switch]))
    return [edge for edge in edges if edge[0] < END_US - 2 * RELEASE_DEBOUNCE_US]


def firmware_release(detector: ctypes.CDLL, edges: list[SwitchEdge]) -> int | None:
    count = len(edges)
    times = (ctypes.c_uint32 * count)(*(edge[0] for edge in edges))
    switches = (ctypes.c_uint8 * count)(*(edge[1] for edge in edges))
    opens = (ctypes.c_uint8 * count)(*(edge[2] for edge in edges))
    found = detector.first_release_us(times, switches, opens, ctypes.c_size_t(count), ctypes.c_uint32(END_US))
    return None if found < 0 else found


@settings(max_examples=2000)
@given(TOGGLES)
def test_the_same_edges_give_the_same_release(detector: ctypes.CDLL, toggles: list[tuple[int, int]]) -> None:
    edges = switch_edges(toggles)
    releases = release_times(edges, 0, END_US)
    assert (releases[0] if releases else None) == firmware_release(detector, edges)


def test_chatter_for_longer_than_a_release_starts_anew(detector: ctypes.CDLL) -> None:
    toggles = [(0, 0)] + [(2500, 1)] * 61  # switch 2 chatters for 150 ms and stays open
    edges = switch_edges(toggles)
    (release,) = release_times(edges, 0, END_US)
    assert release == firmware_release(detector, edges)
    assert edges[-1][0] - release <= 60_000
