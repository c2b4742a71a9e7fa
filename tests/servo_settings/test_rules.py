"""Host and board accept and refuse the same settings, mean the same pulses by them, and fit the same maneuvers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.arduino_sequencer.maneuvers import flyable, overlapping
from tests.fixtures.sequencer.board import JOINTS, Board
from tests.fixtures.sequencer.cable import OLD, client, connect
from tests.fixtures.sequencer.pulses import pulses
from tests.servo_settings.values import all_settings, valid_settings
from tfsat_host.devices.board_errors import BoardError, BoardRefusal
from tfsat_host.maneuver import Maneuver, Stroke, four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, Origin, SequencerState
from tfsat_host.protocol.messages import ServoSetting, SettingsWriteReply, SettingsWriteRequest
from tfsat_host.servo_settings import (
    FACTORY,
    FRAME,
    MOVING,
    Misfit,
    ServoSettings,
    SettingsDefect,
    find_defect,
    find_misfit,
    pulse_ns,
)

NewBoard = Callable[..., Board]
USUAL = FACTORY.servos[0]


def board_refusal_detail(board: Board, servo_settings: ServoSettings) -> int | None:
    """Return the detail of the board's refusal, or None if it accepts the settings.

    The host's own checks are bypassed.
    """
    try:
        client(board).request(
            SettingsWriteRequest(
                servo_settings.frame_us, servo_settings.servos, servo_settings.moving_at_once
            ),
            SettingsWriteReply,
        )
    except BoardError as error:
        # Any other refusal would hide that the rules differ.
        assert error.code == ErrorCode.SETTING_OUT_OF_RANGE, error
        return error.detail
    return None


def of_joint_2(servo: ServoSetting) -> ServoSettings:
    return replace(FACTORY, servos=(USUAL, servo, USUAL))


@settings(max_examples=250)
@given(all_settings())
@example(FACTORY)
@example(of_joint_2(replace(USUAL, zero_us=1500, ns_per_deg=11_112)))  # 2500.08 us at 90 deg
# 2499 + 0.51 x 2 = 2500.02 us, with the least slope and hardly any range.
@example(of_joint_2(ServoSetting(2499, 2000, 0, 0, 51)))
def test_both_accept_or_both_refuse(new_board: NewBoard, servo_settings: ServoSettings) -> None:
    finding = find_defect(servo_settings)
    # A setting that one takes and the other refuses would fail only at the robot.
    assert board_refusal_detail(new_board(), servo_settings) == (finding and finding.index)


@settings(max_examples=100)
@given(valid_settings())
def test_valid_settings_pass(servo_settings: ServoSettings) -> None:
    assert find_defect(servo_settings) is None


@pytest.mark.parametrize(
    ("changed", "code", "index", "key"),
    [
        # One step beyond each limit.
        (replace(FACTORY, frame_us=4999), SettingsDefect.FRAME_RANGE, FRAME, "frame_ms"),
        (replace(FACTORY, frame_us=20_001), SettingsDefect.FRAME_RANGE, FRAME, "frame_ms"),
        (replace(FACTORY, moving_at_once=4), SettingsDefect.MOVING_RANGE, MOVING, "moving_at_once"),
        (of_joint_2(replace(USUAL, ns_per_deg=1999)), SettingsDefect.SLOPE_RANGE, 1, "us_per_deg"),
        (of_joint_2(replace(USUAL, ns_per_deg=30_001)), SettingsDefect.SLOPE_RANGE, 1, "us_per_deg"),
        (of_joint_2(replace(USUAL, min_cdeg=1)), SettingsDefect.JOINT_LIMITS, 1, "limits_deg"),
        (of_joint_2(replace(USUAL, min_cdeg=-1)), SettingsDefect.JOINT_LIMITS, 1, "limits_deg"),
        (of_joint_2(replace(USUAL, max_cdeg=9001)), SettingsDefect.JOINT_LIMITS, 1, "limits_deg"),
        (of_joint_2(replace(USUAL, max_cdeg=0)), SettingsDefect.JOINT_LIMITS, 1, "limits_deg"),
        (of_joint_2(replace(USUAL, zero_us=499)), SettingsDefect.PULSE_RANGE, 1, "zero_us"),
        # 1501 + 90 x 11.111 = 2501 us; reversed, 1000 - 90 x 11.111 = 0 us.
        (of_joint_2(replace(USUAL, zero_us=1501)), SettingsDefect.PULSE_RANGE, 1, "us_per_deg"),
        (of_joint_2(replace(USUAL, reversed=1)), SettingsDefect.PULSE_RANGE, 1, "us_per_deg"),
    ],
)
def test_every_defect_has_its_name(
    board: Board, changed: ServoSettings, code: SettingsDefect, index: int, key: str
) -> None:
    finding = find_defect(changed)
    assert finding is not None
    assert (finding.code, finding.index, finding.key) == (code, index, key)
    assert board_refusal_detail(board, changed) == index


@settings(max_examples=25)
@given(valid_settings())
def test_stored_read_back_and_still_there_after_a_power_cut(
    new_board: NewBoard, servo_settings: ServoSettings
) -> None:
    board = new_board()
    first = connect(board).write_settings(servo_settings)
    assert (first.written, first.stored.origin, first.stored.settings) == (
        True,
        Origin.UPLOADED,
        servo_settings,
    )
    # The same settings again cost no EEPROM write: its cells wear out.
    again = connect(board).write_settings(servo_settings)
    assert (again.written, again.stored) == (False, first.stored)
    board.power_cycle()
    assert connect(board).settings() == first.stored


def test_a_new_board_has_the_factory_settings(board: Board) -> None:
    stored = connect(board).settings()
    assert (stored.origin, stored.generation, stored.settings) == (Origin.FACTORY, 0, FACTORY)


@settings(max_examples=10)
@given(valid_settings())
def test_the_pulse_of_0_deg_is_what_the_file_says(new_board: NewBoard, servo_settings: ServoSettings) -> None:
    """Measured at the pins of the armed board, whatever maneuver it holds."""
    board = new_board()
    # OLD reaches 70 deg: with a smaller limit ARM would refuse.
    fitting = replace(servo_settings, servos=tuple(replace(s, max_cdeg=9000) for s in servo_settings.servos))
    fitting = fitting if find_defect(fitting) is None else FACTORY
    sequencer = connect(board)
    sequencer.write_settings(fitting)
    assert sequencer.read_back().timed_strokes == OLD.strokes
    sequencer.arm()
    # Five of the slowest frames, 20 ms each.
    board.run(100_000)
    edges = board.edges()
    for joint in range(JOINTS):
        train = pulses(edges, joint)
        assert {pulse.width_ns for pulse in train} == {pulse_ns(fitting.servos[joint], 0)}
        assert train[-1].rise_ns - train[-2].rise_ns == fitting.frame_us * 1000


def limit_angles(*max_cdeg: int) -> ServoSettings:
    servos = zip(FACTORY.servos, max_cdeg, strict=True)
    return replace(FACTORY, servos=tuple(replace(servo, max_cdeg=most) for servo, most in servos))


@settings(max_examples=60)
@given(flyable() | overlapping(), st.tuples(*[st.just(9000) | st.integers(1, 9000)] * 3), st.integers(1, 3))
def test_arm_refuses_what_the_host_says_does_not_fit(
    new_board: Callable[..., Board], maneuver: Maneuver, max_cdeg: tuple[int, int, int], at_once: int
) -> None:
    sequencer = connect(new_board())
    stored = sequencer.upload(schedule_maneuver(maneuver)).stored
    servo_settings = replace(limit_angles(*max_cdeg), moving_at_once=at_once)
    sequencer.write_settings(servo_settings)
    # Host and board must agree: a maneuver beyond a stop is refused by both or by neither.
    misfit = find_misfit(stored.timed_strokes, servo_settings)
    if misfit is None:
        assert sequencer.arm() == SequencerState.ARMED
    else:
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == misfit.code


def test_the_first_stroke_that_leaves_is_named() -> None:
    strokes = schedule_maneuver(four_stroke(59, 70)).strokes
    # Exactly at both limits; joint 3 does not move, so its limit does not count.
    assert find_misfit(strokes, limit_angles(5900, 7000, 1)) is None
    assert find_misfit(strokes, limit_angles(5900, 6999, 1)) == Misfit(
        ErrorCode.SETTINGS_DO_NOT_FIT,
        "stroke 2 takes joint 2 to 70 deg, but its servo settings allow 0 to 69.99 deg",
        2,
    )


def test_the_first_stroke_that_moves_too_many_is_named() -> None:
    together = Maneuver((Stroke(1, 90, 0.7), Stroke(2, 90, 0.7), Stroke(3, 90, 1.22), Stroke(1, -90, 1.23)))
    strokes = schedule_maneuver(together).strokes
    # 90 deg take 0.53 s: joint 3 begins while both others still move.
    assert find_misfit(strokes, replace(FACTORY, moving_at_once=3)) is None
    assert find_misfit(strokes, replace(FACTORY, moving_at_once=2)) == Misfit(
        ErrorCode.TOO_MANY_MOVING,
        "stroke 3 makes 3 joints move at once, but the servo settings allow moving_at_once = 2",
        3,
    )


def test_settings_are_taken_in_safe_only(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    with pytest.raises(BoardError) as caught:
        sequencer.write_settings(limit_angles(1, 1, 1))
    assert caught.value.code == ErrorCode.WRONG_STATE
    # Changed while armed, the next pulse would jerk a joint.
    assert sequencer.settings().settings == FACTORY
