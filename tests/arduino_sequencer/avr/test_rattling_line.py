"""A switch's line that rattles without end does not keep a host from opening the port and disarming."""

from __future__ import annotations

import pytest

from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import connect
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.messages import DisarmRequest, SequencerStatusReply, SequencerStatusRequest

RATTLED_US = 1_500_000


def rattle(board: AvrBoard, for_us: int, half_period_us: int) -> None:
    """Open and close one switch, the other one stays closed."""
    ends_us = board.now_us + for_us
    while board.now_us < ends_us:
        board.switch(0, closed=not board.closed[0])
        board.run(half_period_us)


@pytest.mark.parametrize("half_period_us", [8, 45, 55, 58, 60, 300, 2_000])
@pytest.mark.parametrize("stage_pause_us", [0, 1_000])
def test_a_host_comes_through(sequencer: AvrBoard, half_period_us: int, stage_pause_us: int) -> None:
    connect(sequencer).arm()
    sequencer.port(False)
    sequencer.usb_stage_pause(stage_pause_us)
    sequencer.run(100_000)
    rattle(sequencer, 500_000, half_period_us)
    sequencer.port(True)
    rattle(sequencer, RATTLED_US, half_period_us)
    sequencer.write(b"\0" + encode_frame(Frame(DisarmRequest.TYPE, 1, b"")))
    sequencer.write(encode_frame(Frame(SequencerStatusRequest.TYPE, 2, b"")))
    rattle(sequencer, 100_000, half_period_us)
    assert len(sequencer.read()) > SequencerStatusReply.SIZE
    sequencer.switch(0, closed=True)
    sequencer.run(20_000)
    sequencer.cable(False)
    sequencer.usb_stage_pause(0)
    status = connect(sequencer).status()
    assert (status.state, status.resets_while_armed) == (SequencerState.SAFE, 0)
