"""Recordings and live samples over a cable that loses, spoils and repeats: what arrives is right."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import pairwise
from typing import cast

import pytest

from tests.devices.log_transfer.bench import Bench
from tfsat_host.devices.board_errors import BoardError, board_error
from tfsat_host.devices.client import Client
from tfsat_host.devices.log_transfer import (
    RAM,
    READINGS,
    UNREADABLE_LIMIT,
    Listing,
    TransferError,
    is_whole,
    list_logs,
    session_of,
)
from tfsat_host.devices.monitoring import StreamMeter
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.framing import FrameReceiver
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.messages import (
    ErrorReply,
    LogEntry,
    LogListReply,
    LogListRequest,
    LogPartStream,
)
from tfsat_host.run.fetched_log import pick

MIB = 2**20
UNIX_US = 1_790_000_000_123_456


def _piece_in(frame: bytes) -> LogPartStream | None:
    for received in FrameReceiver().feed(frame):
        if received.type == LogPartStream.TYPE:
            return LogPartStream.decode(received.payload)
    return None


def _block_in(frame: bytes) -> int | None:
    """Return the number of the block that a frame holds a part of, or None."""
    piece = _piece_in(frame)
    return None if piece is None else piece.block


def _part_in(frame: bytes) -> int | None:
    """Return the number of the part within its block that a frame holds, or None."""
    piece = _piece_in(frame)
    return None if piece is None else piece.part


def test_the_list_tells_each_recording_and_the_copies_are_the_cards_files(bench: Bench) -> None:
    sessions = [bench.record(0.3), bench.record(0.6), bench.record(0.2)]
    entries = bench.logger.logs()
    assert [entry.number for entry in entries] == [RAM, 1, 2, 3]
    assert [entry.session for entry in entries] == [sessions[2], *sessions]
    # Nobody told the logger the time of day.
    assert all(entry.closed and not entry.wall_clock_us for entry in entries)
    on_card = bench.robot.card_slot.files()
    assert {entry.number: bench.fetch(entry) for entry in entries[1:]} == on_card
    assert bench.fetch(entries[0]) == on_card[3], "RAM has the last one, too"


def test_a_recording_that_was_erased_is_gone_and_the_others_stay(bench: Bench) -> None:
    for _ in range(3):
        bench.record(0.2)
    card_files = bench.robot.card_slot.files()
    bench.logger.erase_log(bench.entry(2))
    del card_files[2]
    assert bench.robot.card_slot.files() == card_files
    assert [entry.number for entry in bench.logger.logs()] == [RAM, 1, 3]


def test_an_erase_whose_answer_was_lost_is_no_error(bench: Bench) -> None:
    bench.record(0.2)
    entry, lost = bench.entry(1), [0]

    # The answer to the erase is lost once: the second erase finds nothing to do.
    def lose_the_first_answer(frame: bytes) -> bytes:
        lost[0] += 1
        return b"" if lost[0] == 1 else frame

    bench.cable.corrupt = lose_the_first_answer
    bench.logger.erase_log(entry)
    assert bench.robot.card_slot.files() == {}


def test_what_another_recording_has_replaced_is_neither_read_nor_erased(bench: Bench) -> None:
    bench.record(0.2)
    old = bench.entry(1)
    bench.logger.erase_log(old)
    # The number is the same, the session is another.
    bench.record(0.2)
    with pytest.raises(BoardError) as refused:
        bench.fetch(old)
    assert refused.value.code == ErrorCode.LOG_CHANGED
    with pytest.raises(BoardError) as refused:
        bench.logger.erase_log(old)
    assert refused.value.code == ErrorCode.LOG_CHANGED
    assert list(bench.robot.card_slot.files()) == [1]


@pytest.mark.parametrize("share", [0.01, 0.2])
def test_frames_that_are_damaged_or_lost_are_asked_for_again(bench: Bench, share: float) -> None:
    bench.record(2.0)
    entry, chance = bench.entry(1), random.Random(7)
    damaged = 0

    def damage(frame: bytes) -> bytes:
        nonlocal damaged
        # The shortest frames are left alone.
        if chance.random() > share or len(frame) < 8:
            return frame
        damaged += 1
        if chance.random() < 0.5:
            return b""
        place = chance.randrange(len(frame) - 1)
        # Never a zero: it would end the frame.
        return frame[:place] + bytes([frame[place] ^ 0x55 or 1]) + frame[place + 1 :]

    bench.cable.corrupt = damage
    assert bench.fetch(entry) == bench.robot.card_slot.files()[1]
    assert damaged > 5


def test_a_block_that_is_torn_on_the_card_is_read_three_times_and_kept_as_it_is(bench: Bench) -> None:
    bench.record(1.0)
    torn = bytearray(bench.robot.card_slot.files()[1])
    torn[7 * BLOCK_BYTES + 300] ^= 0xFF
    bench.robot.card_slot.put(2, bytes(torn))
    entry, blocks, read = bench.entry(2), dict[int, bytes](), list[int | None]()

    def watch(frame: bytes) -> bytes:
        read.append(_block_in(frame))
        return frame

    bench.cable.corrupt = watch
    outcome = bench.logger.fetch_blocks(entry, [(0, entry.blocks)], blocks.__setitem__)
    assert outcome.torn == [7]
    assert outcome.unreadable == []
    assert b"".join(blocks[index] for index in range(entry.blocks)) == torn
    # Three readings of the torn block, one of its neighbour.
    assert read.count(7) == READINGS * read.count(6)


def test_a_block_that_the_card_does_not_read_costs_no_other(bench: Bench) -> None:
    bench.record(1.0)
    entry, blocks = bench.entry(1), dict[int, bytes]()
    # Every part of one block is lost, and no other.
    bench.cable.corrupt = lambda frame: b"" if _block_in(frame) == 5 else frame
    outcome = bench.logger.fetch_blocks(entry, [(0, entry.blocks)], blocks.__setitem__)
    expected = bytearray(bench.robot.card_slot.files()[1])
    expected[5 * BLOCK_BYTES : 6 * BLOCK_BYTES] = bytes(BLOCK_BYTES)
    assert outcome.unreadable == [5]
    assert b"".join(blocks[index] for index in range(entry.blocks)) == expected


def test_a_card_that_reads_nothing_is_an_error_after_some_blocks(bench: Bench) -> None:
    bench.record(1.0)
    entry = bench.entry(1)
    bench.cable.corrupt = lambda frame: b"" if _block_in(frame) is not None else frame
    with pytest.raises(TransferError, match=f"none of the blocks 0 to {UNREADABLE_LIMIT - 1}"):
        bench.fetch(entry)


def test_a_cable_that_always_loses_the_same_is_given_up(bench: Bench) -> None:
    bench.record(0.3)
    entry = bench.entry(1)
    # One part of every block is always lost.
    bench.cable.corrupt = lambda frame: b"" if _part_in(frame) == 7 else frame
    with pytest.raises(TransferError, match="loses too much") as failed:
        bench.fetch(entry)
    assert "another cable" in failed.value.next_step


def test_a_cable_that_is_pulled_leaves_right_blocks(bench: Bench) -> None:
    bench.record(1.0)
    entry, blocks = bench.entry(1), dict[int, bytes]()
    bench.cable.cut_after = bench.cable.received + 10_000
    with pytest.raises(PortError):
        bench.logger.fetch_blocks(entry, [(0, entry.blocks)], blocks.__setitem__)
    on_card = bench.robot.card_slot.files()[1]
    # What arrived before the pull is right, block by block.
    assert all(on_card[i * BLOCK_BYTES : (i + 1) * BLOCK_BYTES] == block for i, block in blocks.items())


def test_the_unused_room_of_a_power_cut_crosses_in_runs(bench: Bench) -> None:
    bench.logger.start_recording()
    bench.logger.wait_for_card()
    bench.wait(1.0)
    bench.robot.set_power(BoardIndex.LOGGER, False)
    bench.robot.set_power(BoardIndex.LOGGER, True)
    bench.wait(0.5)
    entry = bench.entry(1)
    assert not entry.closed
    assert entry.blocks * BLOCK_BYTES == 32 * MIB
    before = bench.cable.received
    copy = bench.fetch(entry)
    assert copy == bench.robot.card_slot.files()[1]
    # The recording is in there among the unused room.
    assert copy.count(b"TFS1") > 40, "there is a recording in it"
    # A quarter of a MiB for 32: runs of zeros cross as counts.
    assert bench.cable.received - before < MIB // 4, "zeros cross as counts"


def test_time_of_day_stands_in_the_header_and_in_the_list(bench: Bench) -> None:
    bench.logger.start_recording(unix_us=UNIX_US)
    bench.wait(1.0)
    bench.logger.stop_recording()
    entry = bench.entry(1)
    # The first block is stamped within a tenth of a second.
    assert 0 <= entry.wall_clock_us - UNIX_US < 100_000
    assert abs(bench.logger.status().unix_us - UNIX_US - 1_000_000) < 500_000
    copy = bench.fetch(entry)
    assert is_whole(copy[:BLOCK_BYTES])
    assert session_of(copy) == entry.session


def test_nothing_is_listed_or_read_while_it_records(bench: Bench) -> None:
    bench.record(0.2)
    entry = bench.entry(1)
    bench.logger.start_recording()
    for refused_request in (
        bench.logger.logs,
        lambda: bench.fetch(entry),
        lambda: bench.logger.erase_log(entry),
    ):
        with pytest.raises(BoardError) as refused:
            refused_request()
        assert refused.value.code == ErrorCode.WRONG_STATE


_RAM = LogEntry(number=0, session=7, blocks=100, wall_clock_us=0, closed=1)


class _WithoutCard:
    """Answers for RAM, and refuses what needs the card."""

    def __init__(self, code: ErrorCode) -> None:
        self._code = code

    def request(self, request: LogListRequest, _reply: type[LogListReply]) -> LogListReply:
        if request.from_number == 0:
            # RAM alone answers.
            return LogListReply(found=1, entry=_RAM)
        raise board_error(ErrorReply(LogListRequest.TYPE, self._code, -1))


def _list_without_card(code: ErrorCode) -> Listing:
    return list_logs(cast(Client, _WithoutCard(code)))


def test_ram_is_listed_without_a_card() -> None:
    listing = _list_without_card(ErrorCode.NO_CARD)
    assert listing.entries == [_RAM]
    assert pick(listing, 0) == _RAM
    with pytest.raises(BoardError) as refused:
        pick(listing, 1)
    assert refused.value.code == ErrorCode.NO_CARD, "not: there is no such recording"


def test_a_logger_that_records_lists_nothing() -> None:
    with pytest.raises(BoardError):
        _list_without_card(ErrorCode.WRONG_STATE)


def test_a_thousand_samples_a_second_arrive_without_a_gap(bench: Bench) -> None:
    settings = bench.logger.settings().settings
    bench.logger.write_settings(replace(settings, rate_hz=1000))
    samples: list[LiveSample] = []
    meter = StreamMeter()
    with bench.logger.live() as scales:
        assert scales.rate_hz == 1000
        while len(samples) < 5000:
            arrived = bench.logger.live_samples()
            meter.add(arrived)
            samples += arrived
    first = samples[0].index
    assert [sample.index - first for sample in samples] == list(range(len(samples)))
    # Every sample 1000 us after the last, not one missing.
    assert {after.time_us - before.time_us for before, after in pairwise(samples)} == {1000}
    assert (meter.rate_hz, meter.missed) == (1000.0, 0)
    assert bench.logger.status().late_ticks == 0


def test_it_goes_on_beside_a_recording(bench: Bench) -> None:
    settings = bench.logger.settings().settings
    bench.logger.write_settings(replace(settings, rate_hz=1000))
    bench.logger.start_recording()
    meter = StreamMeter()
    with bench.logger.live():
        for _ in range(200):
            meter.add(bench.logger.live_samples())
    stopped = bench.logger.stop_recording()
    assert meter.missed == 0
    assert stopped.samples_dropped == 0
