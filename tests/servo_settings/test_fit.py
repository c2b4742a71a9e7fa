"""Whether a maneuver stays within the limits: host and ARM agree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sequencer.board import Board, connect
from tests.sequencer.maneuvers import flyable
from tfsat_host.devices.client import BoardError, BoardRefusal
from tfsat_host.maneuver import Maneuver, four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.servo_settings import FACTORY, ServoSettings, find_misfit


def limited(*max_cdeg: int) -> ServoSettings:
    servos = zip(FACTORY.servos, max_cdeg, strict=True)
    return replace(FACTORY, servos=tuple(replace(servo, max_cdeg=most) for servo, most in servos))


@settings(max_examples=60)
@given(flyable(), st.tuples(*[st.just(9000) | st.integers(1, 9000)] * 3))
def test_arm_refuses_what_the_host_says_does_not_fit(
    new_board: Callable[..., Board], maneuver: Maneuver, max_cdeg: tuple[int, int, int]
) -> None:
    sequencer = connect(new_board())
    stored = sequencer.upload(schedule_maneuver(maneuver)).stored
    sequencer.write_settings(limited(*max_cdeg))
    if find_misfit(stored.moves, limited(*max_cdeg)) is None:
        assert sequencer.arm() == SequencerState.ARMED
    else:
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.SETTINGS_DO_NOT_FIT


def test_the_first_stroke_that_leaves_is_named() -> None:
    moves = [(stroke.joint, stroke.angle_cdeg) for stroke in schedule_maneuver(four_stroke(59, 70)).strokes]
    assert find_misfit(moves, limited(5900, 7000, 1)) is None
    misfit = find_misfit(moves, limited(5900, 6999, 1))
    assert misfit == "stroke 2 takes joint 2 to 70 deg, but its servo settings allow 0 to 69.99 deg"


def test_settings_are_taken_in_safe_only(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    with pytest.raises(BoardError) as caught:
        sequencer.write_settings(limited(1, 1, 1))
    assert caught.value.code == ErrorCode.WRONG_STATE
    assert sequencer.settings().settings == FACTORY
