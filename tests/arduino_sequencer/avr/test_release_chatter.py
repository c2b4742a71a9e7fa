"""The first switch's contacts chatter faster than an interrupt can follow just before the second opens."""

from __future__ import annotations

import pytest

from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import OLD, connect
from tests.fixtures.sequencer.pulses import onsets_ns

WORST_ERROR_NS = 50_000
BEFORE_RELEASE_US = 40


@pytest.mark.parametrize("open_us", [4, 5, 6, 9])
@pytest.mark.parametrize("closed_us", [4, 5, 6, 9])
def test_the_release_is_the_second_switch_opening(sequencer: AvrBoard, open_us: int, closed_us: int) -> None:
    connect(sequencer).arm()
    sequencer.run(50_000)
    # Two short bounces of the first switch, each faster than an interrupt.
    for _ in range(2):
        sequencer.switch(1, closed=False)
        sequencer.run(open_us)
        sequencer.switch(1, closed=True)
        sequencer.run(closed_us)
    sequencer.switch(1, closed=False)
    sequencer.run(BEFORE_RELEASE_US)
    sequencer.switch(0, closed=False)
    released_ns = sequencer.now_us * 1000
    sequencer.run(2_600_000)
    onsets = onsets_ns(sequencer.edges())
    assert [joint for joint, _ in onsets] == [stroke.joint for stroke in OLD.strokes]
    for (_, onset_ns), stroke in zip(onsets, OLD.strokes, strict=True):
        # 50 us: what one lost edge may cost.
        assert abs(onset_ns - released_ns - stroke.t_us * 1000) <= WORST_ERROR_NS
