"""A USB host that begins control transfers and ends none resets nothing; what it leaves unread moves nothing."""

from __future__ import annotations

import pytest

from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.limits import JOG_CONFIRM
from tfsat_host.protocol.messages import JogRequest, SequencerStatusRequest

RUN_US = 3_000_000
"""The watchdog bites after one second."""


@pytest.mark.parametrize("every_us", [2_000, 11_000])
def test_at_power_up_the_board_starts_once(
    new_sequencer: AvrBoard, uploaded_eeprom: bytes, every_us: int
) -> None:
    new_sequencer.set_eeprom(uploaded_eeprom)
    new_sequencer.usb_half_transfers(every_us)
    new_sequencer.cable(True)
    new_sequencer.power(True)
    new_sequencer.run(RUN_US)
    new_sequencer.usb_half_transfers(0)
    status = connect(new_sequencer).status()
    assert status.uptime_ms > 0.9 * RUN_US / 1000
    assert status.state == SequencerState.SAFE


def test_after_a_reset_the_board_is_armed_once_more(sequencer: AvrBoard) -> None:
    connect(sequencer).arm()
    sequencer.run(50_000)
    sequencer.usb_half_transfers(2_000)
    sequencer.reset(ResetCause.WATCHDOG)
    sequencer.run(RUN_US)
    sequencer.usb_half_transfers(0)
    status = connect(sequencer).status()
    assert (status.state, status.resets_while_armed) == (SequencerState.ARMED, 1)


def test_a_release_right_after_a_reset_is_a_fault_and_one_later_is_flown(sequencer: AvrBoard) -> None:
    """The board looks at its switches while it still reads its own image."""
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    sequencer.reset(ResetCause.WATCHDOG)
    # The image takes a quarter of a second to read.
    sequencer.run(60_000)
    for index in (0, 1):
        sequencer.switch(index, closed=False)
    sequencer.run(20_000)
    assert sequencer.edges()
    sequencer.run(400_000)
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.resets_while_armed) == (SequencerState.RUNNING, 1)


def test_an_order_that_the_board_has_not_read_goes_with_the_port(sequencer: AvrBoard) -> None:
    """A host leaves its answers unread, asks for a jog and closes the port: whoever opens it next moves nothing."""
    connect(sequencer)
    question = encode_frame(Frame(SequencerStatusRequest.TYPE, 7, b""))
    order = encode_frame(Frame(JogRequest.TYPE, 8, JogRequest(1, 0, 4500, JOG_CONFIRM).encode()))
    unread = 0
    # About as many answers as fill the host's buffer: of some the board cannot get rid, and reads no further.
    for questions in range(100, 108):
        for _ in range(questions):
            sequencer.write(question)
            sequencer.run(2_000)
        sequencer.write(order)
        sequencer.run(1_200_000)
        unread += not sequencer.edges()
        sequencer.port(False)
        sequencer.run(20_000)
        sequencer.read()
        sequencer.port(True)
        sequencer.run(100_000)
        assert not sequencer.edges(), questions
        while sequencer.read():
            sequencer.run(5_000)
    assert unread > 2
