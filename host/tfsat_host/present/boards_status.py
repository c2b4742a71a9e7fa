"""State of both boards, and what blocks a drop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tfsat_host.devices.logger import drop_in_danger
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.error_columns import error_columns, or_error
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.logger_state import (
    LOGGER_DETAILS,
    LOGGER_FACTS,
    LOGGER_JSON,
    RAM_HOLDS_DROP,
    LoggerReport,
    attention,
)
from tfsat_host.present.output import GREEN, RED, YELLOW, Output, refusal_name
from tfsat_host.present.sequencer_state import (
    SEQUENCER_DETAILS,
    SEQUENCER_FACTS,
    SEQUENCER_JSON,
    SequencerReport,
)
from tfsat_host.present.terminal import bullets, sentences, show_facts, write_verdict
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import Column, Columns, columns_of

_MOVING = {
    SequencerState.ARMED: "ARMED: the release starts the maneuver",
    SequencerState.RUNNING: "RUNNING: the maneuver moves the joints",
    SequencerState.JOGGING: "JOGGING: one joint is moved",
}


@dataclass(frozen=True, slots=True)
class BoardsStatus:
    """What both boards reported.

    Attributes:
        sequencer: None: it was not asked, or did not answer.
        logger: Likewise.
        errors: Why a board that is plugged in did not answer, by its name.
    """

    sequencer: SequencerReport | None
    logger: LoggerReport | None
    errors: Mapping[BoardName, TfsatError]

    @property
    def arm_refusal(self) -> TfsatError | None:
        """Why `arm` would refuse: the sequencer's reason, else the logger's, which the sequencer does not know."""
        if self.sequencer is None or self.logger is None or not self.sequencer.may_be_armed:
            return None if self.sequencer is None else self.sequencer.refusal
        return self.logger.refusal

    @property
    def blocks(self) -> list[str]:
        """What blocks a drop, each with what to type next; empty: nothing."""
        texts: list[str] = []
        if (
            self.sequencer is not None
            and self.sequencer.status.state not in _MOVING
            and (refusal := self.sequencer.refusal)
        ):
            name = refusal_name(refusal.code)
            texts.append(Advice(f"Sequencer: {refusal.what} ({name}) ", refusal.next_step))
        if self.logger is not None:
            if self.logger.status.ram_holds_drop:
                texts.append(Advice("Logger: RAM ", RAM_HOLDS_DROP))
            elif (danger := self.logger.refusal) is not None:
                texts.append(Advice(f"Logger: {danger.what} {danger.meaning} ", danger.next_step))
        return texts

    @property
    def warnings(self) -> list[str]:
        """What a person has to know that does not block a drop, or is more than that; most urgent first."""
        texts = list(self.sequencer.attention) if self.sequencer is not None else []
        if self.logger is not None and drop_in_danger(self.logger.status):
            texts = [*attention(self.logger.status), *texts]
        return texts

    @property
    def verdict(self) -> tuple[str, str]:
        """The state as one line for people, and its colour."""
        if self.logger is not None and drop_in_danger(self.logger.status):
            return "DROP IN DANGER: it is in the logger's RAM only", RED
        if count := len(self.blocks):
            return f"BLOCKED: {count} item{'s block' if count > 1 else ' blocks'} a drop", RED
        if self.sequencer is None:
            return "UNKNOWN: sequencer not read", YELLOW
        state = self.sequencer.status.state
        if state in _MOVING:
            return _MOVING[state], YELLOW
        # Whether the drop would be recorded only the logger tells.
        return ("READY TO ARM", GREEN) if self.logger else ("READY TO ARM: logger not read", YELLOW)

    def show(self, out: Output, *, full: bool) -> None:
        """Show the verdict, what blocks a drop, and both boards; the verdict again at the end."""
        write_verdict(*self.verdict, out)
        bullets([*self.blocks, *self.warnings], out)
        boards: list[tuple[object, Columns, Columns]] = [
            (self.sequencer, SEQUENCER_FACTS, SEQUENCER_DETAILS),
            (self.logger, LOGGER_FACTS, LOGGER_DETAILS),
        ]
        for report, facts, details in boards:
            if report is not None:
                out.line()
                show_facts((*facts, *details) if full else facts, report, out)
        out.line()
        if not full:
            sentences([Advice("All details: ", NextStep("status", ("--full",)))], out)
        write_verdict(*self.verdict, out)


_SEQUENCER: Columns = (*columns_of("sequencer", SEQUENCER_JSON), Column("arm_refusal", columns=error_columns))
BOARDS: Columns = (
    Column(
        "sequencer",
        of=lambda status: status if status.sequencer else status.errors.get("sequencer"),
        columns=or_error(_SEQUENCER),
    ),
    Column(
        "logger",
        of=lambda status: status.logger or status.errors.get("logger"),
        columns=or_error(LOGGER_JSON),
    ),
)
"""Both reports for `--json`; null for a board that is not plugged in."""
