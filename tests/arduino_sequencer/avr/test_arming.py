"""What the flashed image keeps, in EEPROM and through a reset in RAM, and when it refuses to arm for it."""

from __future__ import annotations

import pytest

from tests.arduino_sequencer.avr.flight import assert_maneuver_flown, run_until_lines_are_low
from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import OLD, connect
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.servo_settings import FACTORY

MANEUVER_ADDRESS, SETTINGS_ADDRESS = 512, 768
WITHIN_CONTENT = 9
UNFOLD = schedule_maneuver(Maneuver((Stroke(1, 59.0),)))


def refusal(client: SequencerClient) -> ErrorCode:
    with pytest.raises(BoardRefusal) as raised:
        client.arm()
    return raised.value.code


def restart_with(board: AvrBoard, eeprom: bytes) -> SequencerClient:
    board.power(False)
    board.set_eeprom(eeprom)
    board.cable(False)
    board.power(True)
    return connect(board)


def release(board: AvrBoard) -> int:
    """Without bounce; returns when both switches were open, in ns."""
    for index in (0, 1):
        board.switch(index, closed=False)
        board.run(100)
    # The second switch opened 100 us before the end of this loop.
    return (board.now_us - 100) * 1000


def hang_up(board: AvrBoard) -> None:
    for index in (0, 1):
        board.switch(index, closed=True)
    board.run(20_000)


def test_a_new_board_arms_only_once_a_maneuver_is_uploaded(new_sequencer: AvrBoard) -> None:
    new_sequencer.power(True)
    client = connect(new_sequencer)
    assert refusal(client) == ErrorCode.NO_MANEUVER
    # Refused means limp: no pulse may have left the board.
    new_sequencer.run(100_000)
    assert new_sequencer.edges() == []
    client.upload(OLD)
    assert client.arm() == SequencerState.ARMED


@pytest.mark.parametrize("address", [MANEUVER_ADDRESS, SETTINGS_ADDRESS])
def test_a_damaged_record_forbids_arming_until_both_are_uploaded_again(
    sequencer: AvrBoard, address: int
) -> None:
    # Both stores must be in use, or a damaged byte of an empty one would go unnoticed.
    connect(sequencer).write_settings(FACTORY)
    damaged = bytearray(sequencer.eeprom())
    # One bit within the record's content: only the CRC can tell.
    damaged[address + WITHIN_CONTENT] ^= 0x10
    client = restart_with(sequencer, bytes(damaged))
    assert refusal(client) == ErrorCode.STORE_DAMAGED
    client.upload(OLD)
    client.write_settings(FACTORY)
    assert client.arm() == SequencerState.ARMED
    # The repaired stores outlast the power.
    client = restart_with(sequencer, sequencer.eeprom())
    assert client.arm() == SequencerState.ARMED


def test_a_run_that_ends_away_from_the_start_pose_must_be_disarmed(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    # One stroke to 59 deg and none back: the run ends away from the start pose.
    client.upload(UNFOLD)
    client.arm()
    sequencer.run(50_000)
    release(sequencer)
    # The fall's 2.5 s and a little more.
    sequencer.run(2_600_000)
    hang_up(sequencer)
    assert client.status().state == SequencerState.DONE
    assert refusal(client) == ErrorCode.NOT_AT_START_POSE
    # The refusal changes nothing.
    assert client.status().state == SequencerState.DONE
    # Disarmed, its servos are limp: nothing snaps back when it arms.
    client.disarm()
    assert client.arm() == SequencerState.ARMED


@pytest.mark.parametrize("cause", list(ResetCause))
def test_knocks_and_the_last_run_survive_a_reset_but_not_power_off(
    sequencer: AvrBoard, cause: ResetCause
) -> None:
    client = connect(sequencer)
    client.arm()
    for _ in range(3):
        # One switch alone opens for longer than the debounce: a knock, no release.
        sequencer.switch(1, closed=False)
        sequencer.run(20_000)
        sequencer.switch(1, closed=True)
        sequencer.run(20_000)
    sequencer.reset(cause)
    client = connect(sequencer)
    assert (client.status().state, client.status().knocks) == (SequencerState.ARMED, 3)
    # Edges so far are of the reset; the next ones are of the flight.
    run_until_lines_are_low(sequencer)
    sequencer.edges()
    released_ns = release(sequencer)
    sequencer.run(2_600_000)
    assert_maneuver_flown(sequencer, released_ns)
    run_report = client.run_report()
    assert (run_report.released, run_report.stroke_count) == (1, len(OLD.strokes))
    sequencer.reset(cause)
    assert connect(sequencer).run_report() == run_report
    # Power off, unlike a reset, clears the RAM that keeps the run.
    client = restart_with(sequencer, sequencer.eeprom())
    assert client.run_report().released == 0
    assert client.status().knocks == 0
