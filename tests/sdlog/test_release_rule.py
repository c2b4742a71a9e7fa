"""The decoder's release rule is the boards': all three run on the same switch edges."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.proof.campaign import Broken
from tests.sequencer_proof import one_rule
from tfsat_host.protocol import limits


@pytest.fixture(scope="module")
def rule(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return one_rule.build_rule(tmp_path_factory.mktemp("rule") / "rule.so")


def test_the_same_edges_give_the_same_releases(rule: Path) -> None:
    """A million of them: `make sequencer-report`."""
    agreement = one_rule.one_rule(rule, 59, 5_000)
    assert agreement.trains == 5_000
    assert agreement.releases > 1_000
    assert agreement.ambiguous > 300
    assert agreement.false_releases > 100


def test_a_rule_that_differs_by_a_microsecond_is_seen(rule: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HUNG", "DEBOUNCE", "BOUNCE", "CHATTER", "SEATED"):
        limit = f"tfsat_host.sdlog.release_rule.RELEASE_{name}_US"
        with monkeypatch.context() as context:
            context.setattr(limit, getattr(limits, f"RELEASE_{name}_US") + 1)
            with pytest.raises(Broken):
                one_rule.one_rule(rule, 59, 5_000)


def test_eleven_openings_of_a_millisecond_and_then_the_release(rule: Path) -> None:
    edges = []
    for number in range(11):
        for after_us, is_open in ((0, True), (1_000, False)):
            edges += [(one_rule.FIRST_US + 5_000 * number + after_us, switch, is_open) for switch in (0, 1)]
    released_us = one_rule.FIRST_US + 55_000
    edges += [(released_us, switch, True) for switch in (0, 1)]
    ((at_us, first_us, last_us, is_false),) = one_rule.compare(rule, edges, 0)
    assert (first_us, last_us, is_false) == (one_rule.FIRST_US, released_us, False)
    assert 0 <= released_us - at_us <= limits.RELEASE_BOUNCE_US
