"""Campaign 1c: sequencer, logger and decoder tell the same releases of the same edges."""

from __future__ import annotations

import ctypes
import random
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from tests.fixtures.cpp.compiling import build_shared
from tests.paths import REPOSITORY
from tests.validation.campaign import Broken
from tfsat_host.protocol.limits import (
    LANDING_LATEST_US,
    RELEASE_BOUNCE_US,
    RELEASE_CHATTER_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_HUNG_US,
    RELEASE_SEATED_US,
)
from tfsat_host.sdlog.release_rule import SwitchEdge, releases_by_rule

FIRST_US = 20_000
AFTERWARDS_US = RELEASE_SEATED_US + 20_000
LATEST_US = LANDING_LATEST_US - AFTERWARDS_US
"""The logger's time of landing ends its watch."""
MAX_EDGES = 24
_LIMITS_US = (RELEASE_HUNG_US, RELEASE_DEBOUNCE_US, RELEASE_BOUNCE_US, RELEASE_CHATTER_US, RELEASE_SEATED_US)
_GAPS_US = ((1, 60), (1, 3_000), *((limit - 2, limit + 2) for limit in _LIMITS_US), (60_000, 300_000))
_PERIODS_US = (1_000, 3_571, 10_000)
Told = tuple[int, int, int, bool]
"""t = 0, between when the robot left (µs), and whether it was a false release."""


class _Told(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_uint32) for name in ("at_us", "first_us", "last_us", "false_release"))


class Agreement(NamedTuple):
    """What was compared.

    Attributes:
        trains: Edge trains.
        releases: That all three tell.
        ambiguous: Of them, with an interval that holds two.
        false_releases: Of them.
    """

    trains: int
    releases: int
    ambiguous: int
    false_releases: int


def build_rule(out: Path) -> Path:
    """Build the firmware's release rule as a library."""
    logger = REPOSITORY / "firmware" / "teensy_logger" / "src"
    sources = [
        REPOSITORY / "tests" / "sdlog" / "rule_bridge.cpp",
        logger / "core" / "drop_watch.cpp",
        logger / "release" / "release_detector.cpp",
    ]
    return build_shared(sources, out, [])


@cache
def _load_rule(library: Path) -> ctypes.CDLL:
    rule = ctypes.CDLL(str(library))
    rule.sequencer_tells.restype = rule.logger_tells.restype = ctypes.c_size_t
    return rule


def edge_train(rng: random.Random) -> list[SwitchEdge]:
    """Switches that change at random, both closed at first; gaps of every kind, most of all near the rule's limits."""
    t_us, opened = FIRST_US, [False, False]
    edges = []
    for number in range(rng.randint(1, MAX_EDGES)):
        t_us += rng.randint(*rng.choice(_GAPS_US))
        if number and t_us > LATEST_US:
            break
        switches = (0, 1) if rng.random() < 0.3 else (rng.randrange(2),)
        for switch in switches:
            opened[switch] = not opened[switch]
            edges.append((t_us, switch, opened[switch]))
    return edges


def compare(library: Path, edges: Sequence[SwitchEdge], seed: int) -> list[Told]:
    """Compare the releases that sequencer, logger and decoder find in the edges, and return them.

    Raises Broken where they differ.
    """
    rule = _load_rule(library)
    end_us = edges[-1][0] + AFTERWARDS_US
    decoder = [
        (release.at_us, *release.left_us, release.false_us is not None)
        for release in releases_by_rule(edges, 0, end_us)
        if release.certain_us is not None
    ]
    arrays = (
        (ctypes.c_uint32 * len(edges))(*(edge[0] for edge in edges)),
        (ctypes.c_uint8 * len(edges))(*(edge[1] for edge in edges)),
        (ctypes.c_uint8 * len(edges))(*(edge[2] for edge in edges)),
    )
    reports = (_Told * (len(edges) + 1))()
    size, end = ctypes.c_size_t(len(edges)), ctypes.c_uint32(end_us)
    report_count = rule.sequencer_tells(*arrays, size, end, ctypes.c_uint32(seed + 1), reports)
    sequencer = [
        (report.at_us, report.first_us, report.last_us, bool(report.false_release))
        for report in reports[:report_count]
    ]
    period_us = ctypes.c_uint32(_PERIODS_US[seed % len(_PERIODS_US)])
    report_count = rule.logger_tells(*arrays, size, end, period_us, reports)
    logger = [(report.at_us, bool(report.false_release)) for report in reports[:report_count]]
    if decoder != sequencer or [(at_us, is_false) for at_us, _, _, is_false in decoder] != logger:
        raise Broken(f"decoder {decoder}, sequencer {sequencer}, logger {logger} of {list(edges)}")
    return decoder


def one_rule(library: Path, seed: int, trains: int) -> Agreement:
    """So many trains, of the seed, through a library of `build_rule`. Raises Broken."""
    rng = random.Random(seed)
    reports = [report for number in range(trains) for report in compare(library, edge_train(rng), number)]
    ambiguous = sum(first_us < last_us for _, first_us, last_us, _ in reports)
    return Agreement(trains, len(reports), ambiguous, sum(is_false for *_, is_false in reports))
