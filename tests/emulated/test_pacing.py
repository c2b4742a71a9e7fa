"""Virtual time against a clock that the test turns."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.emulated.real_time import MAX_BACKLOG_S, Pacer
from tfsat_host.emulated.server import STEP_US

STEP_S = STEP_US / 1e6


@given(st.lists(st.floats(0.0, MAX_BACKLOG_S * 0.99), max_size=200), st.floats(0.0, 1e6))
def test_virtual_time_follows_a_clock_that_goes_in_any_small_jumps(
    jumps_s: list[float], start_s: float
) -> None:
    pacer = Pacer(start_s)
    now_s = start_s
    steps = 0
    for jump_s in jumps_s:
        now_s += jump_s
        steps += pacer.steps_due(now_s)
        # Behind the clock by less than a step, and never before it.
        assert now_s - start_s - 1.001 * STEP_S <= steps * STEP_S <= now_s - start_s + 1e-6
        assert 0.0 <= pacer.wait_s(now_s) <= 1.001 * STEP_S
    assert pacer.lag_s == 0.0
    assert not pacer.new_lag()


def test_after_the_wait_a_step_is_due() -> None:
    pacer = Pacer(100.0)
    now_s = 100.0003
    assert pacer.steps_due(now_s) == 0
    assert pacer.steps_due(now_s + pacer.wait_s(now_s) + 1e-9) == 1


def test_a_long_hiccup_is_given_up_and_told_once() -> None:
    pacer = Pacer(0.0)
    # No more than the backlog is caught up at once.
    assert pacer.steps_due(10.0) == MAX_BACKLOG_S / STEP_S
    assert pacer.lag_s == pytest.approx(10.0 - MAX_BACKLOG_S)
    # Told once, however often somebody asks.
    assert pacer.new_lag()
    pacer.steps_due(20.0)
    assert not pacer.new_lag()
    assert pacer.steps_due(20.0015) == 1
