"""What there is to fetch when the card has gone: RAM's is there, and nobody says that the card is empty."""

from __future__ import annotations

from typing import cast

import pytest

from tfsat_host.devices.client import BoardError, Client, board_error
from tfsat_host.devices.log_transfer import Listing, list_logs
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.messages import ErrorReply, LogEntry, LogListReply, LogListRequest
from tfsat_host.run.fetched_log import pick

_RAM = LogEntry(number=0, session=7, blocks=100, wall_clock_us=0, closed=1)


class _WithoutCard:
    """Answers for RAM, and refuses what needs the card."""

    def __init__(self, code: ErrorCode) -> None:
        self._code = code

    def request(self, request: LogListRequest, _reply: type[LogListReply]) -> LogListReply:
        if request.from_number == 0:
            return LogListReply(found=1, entry=_RAM)
        raise board_error(ErrorReply(LogListRequest.TYPE, self._code, -1))


def _listed(code: ErrorCode) -> Listing:
    return list_logs(cast(Client, _WithoutCard(code)))


def test_ram_is_listed_without_a_card() -> None:
    listing = _listed(ErrorCode.NO_CARD)
    assert listing.entries == [_RAM]
    assert pick(listing, 0) == _RAM
    with pytest.raises(BoardError) as refused:
        pick(listing, 1)
    assert refused.value.code == ErrorCode.NO_CARD, "not: there is no such recording"


def test_a_logger_that_records_lists_nothing() -> None:
    with pytest.raises(BoardError):
        _listed(ErrorCode.WRONG_STATE)
