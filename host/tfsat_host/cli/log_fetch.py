"""`tfsat-host log fetch`: a recording's way into a file, and what the file is worth."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tfsat_host.cli.advice import device_option
from tfsat_host.cli.connection import open_logger
from tfsat_host.cli.fetched import FetchedLogs
from tfsat_host.cli.log import pick, ram_warning
from tfsat_host.cli.log_words import entry_as_dict, size_words
from tfsat_host.cli.output import Output
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.log_names import RAM, copy_name, entry_words
from tfsat_host.devices.log_transfer import Outcome
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.partial_log import PartialLog
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.protocol.enums import DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry

FALL_WAIT_S = 15.0
"""RAM takes a drop until 5 s after the release at the earliest and a second after the landing."""
_ENDING_S = 2.0


@dataclass
class Copy:
    """One recording on this computer.

    Attributes:
        entry: As listed.
        path: Where it is.
        sha256: Of the file; empty if it was there already.
        resumed_blocks: Blocks that an earlier attempt had fetched.
        outcome: What became of its blocks.
        facts: What decoding says; empty where nothing can be decoded.
        warnings: What is lost or doubtful.
    """

    entry: LogEntry
    path: Path
    sha256: str = ""
    resumed_blocks: int = 0
    outcome: Outcome = field(default_factory=Outcome)
    facts: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    @property
    def is_whole(self) -> bool:
        """It holds what the logger holds, and nothing of it is damaged."""
        return not self.outcome.torn and not self.outcome.unreadable


def fetch(args: argparse.Namespace, out: Output) -> int:
    """Fetches one recording or all, judges them, and gives RAM free once its drop is safe."""
    fetched = FetchedLogs()
    with open_logger(args, out) as logger:
        entries = _entries(logger, out)
        holds_drop = bool(logger.status().ram_holds_drop)
        if args.which is None:
            wanted = [entry for entry in entries if entry.number != RAM or holds_drop]
        else:
            wanted = [pick(entries, args.which)]
        copies = []
        for entry in wanted:
            copy = _fetch_one(logger, entry, _target(args, entry), fetched, args, out)
            _judge(copy)
            copies.append(copy)
        released = any(_release_ram(logger, copy, out) for copy in copies)
        holds_drop = bool(logger.status().ram_holds_drop)
        result = {
            "logs": [_as_dict(copy) for copy in copies],
            "ram_released": released,
            "ram_holds_drop": holds_drop,
            "device": {"port": logger.port, **logger.identity.as_dict()},
        }
    out.result(result, lambda: _show(copies, released, out))
    for copy in copies:
        for warning in copy.warnings:
            out.warn(warning) if not warning.startswith(" ") else out.note(warning)
    if holds_drop:
        out.warn(ram_warning(device_option(args)))
    return DataLossError.exit_code if any(copy.warnings for copy in copies) else 0


def _entries(logger: LoggerClient, out: Output) -> list[LogEntry]:
    """What there is. A drop that RAM still takes is waited for; any other capture ends only if a person agrees."""
    try:
        return logger.logs()
    except BoardError as error:
        status = logger.status()
        if error.code != ErrorCode.WRONG_STATE or status.state != LoggerState.FAILED:
            raise
    if status.phase != DropPhase.WAITING:
        with out.progress("the card has failed and the drop goes into RAM: waiting for its end"):
            return logger.wait_for_logs(FALL_WAIT_S)
    out.confirm(
        "The card has failed, and the logger goes on in its RAM. Fetching ends that: a drop after it would not be "
        "recorded. Fetch now?",
        meaning="Nothing was done: the newest seconds stay in RAM, and it would keep a drop.",
    )
    logger.end_capture()
    return logger.wait_for_logs(_ENDING_S)


def _target(args: argparse.Namespace, entry: LogEntry) -> Path:
    if args.out is None:
        return Path(copy_name(entry))
    out: Path = args.out
    return out / copy_name(entry) if args.which is None or out.is_dir() else out


def _fetch_one(
    logger: LoggerClient,
    entry: LogEntry,
    target: Path,
    fetched: FetchedLogs,
    args: argparse.Namespace,
    out: Output,
) -> Copy:
    serial = logger.identity.serial
    there = fetched.copy_of(serial, entry)
    if there is not None and target.exists() and there.samefile(target):
        return Copy(entry, target)
    if target.exists() and not args.force:
        raise TfsatError(
            what=f"{target} exists and is not this recording (session {entry.session:08x}).",
            meaning="Nothing was overwritten.",
            next_step="Name another place with --out, or add --force to overwrite it.",
        )
    with PartialLog(target, entry, replace=args.force) as partial:
        copy = Copy(entry, target, resumed_blocks=partial.present_blocks)
        if partial.present_blocks:
            out.note(
                f"{partial.path} has {partial.present_blocks} of {entry.blocks} blocks already: going on."
            )
        with _kept_on_failure(partial, entry, out) as count:
            description = f"fetching {entry_words(entry)}, {size_words(entry.blocks * BLOCK_BYTES)}"
            with out.progress(description, total=entry.blocks) as advance:
                advance(partial.present_blocks)

                def put(index: int, block: bytes) -> None:
                    partial.put(index, block)
                    count()
                    advance(1)

                copy.outcome = logger.fetch_blocks(entry, partial.missing, put)
        copy.sha256 = partial.finish()
    if not copy.outcome.unreadable:
        fetched.add(serial, entry, target, copy.sha256)
    return copy


@contextmanager
def _kept_on_failure(partial: PartialLog, entry: LogEntry, out: Output) -> Iterator[Any]:
    """Gives what counts blocks; says of any end before the last that they are kept."""
    have = partial.present_blocks

    def count() -> None:
        nonlocal have
        have += 1

    def kept() -> str:
        return f"{have} of {entry.blocks} blocks are kept in {partial.path}."

    try:
        yield count
    except KeyboardInterrupt:
        out.note(f"{kept()} The same command goes on from there.")
        raise
    except TfsatError as error:
        if isinstance(error, BoardError):
            error.meaning = f"{error.meaning} {kept()}"
        else:
            error.meaning = f"{kept()} The recording is as it was, on the logger."
            error.next_step = f"{error.next_step}\nThe same log fetch goes on from there."
        raise


def _judge(copy: Copy) -> None:
    """What the file is worth, by decoding it."""
    from tfsat_host import sdlog
    from tfsat_host.sdlog.errors import LogError
    from tfsat_host.sdlog.summary import summary

    name = entry_words(copy.entry)
    for blocks, what in (
        (copy.outcome.unreadable, "the card does not read them; the copy has zeros there"),
        (copy.outcome.torn, "their CRC does not match: they are torn on the card itself"),
    ):
        if blocks:
            listed = ", ".join(map(str, blocks[:8])) + (", …" if len(blocks) > 8 else "")
            copy.warnings.append(f"{name}, {len(blocks)} blocks ({listed}): {what}.")
    try:
        copy.facts = summary(sdlog.load(copy.path))
        copy.warnings += copy.facts["warnings"]
    except LogError as error:
        copy.warnings.append(f"{name} came over whole, but: {error.what} {error.meaning}")


def _release_ram(logger: LoggerClient, copy: Copy, out: Output) -> bool:
    """Gives RAM free once its drop is on this computer's disk, each block proven."""
    if copy.entry.number != RAM or not logger.status().ram_holds_drop:
        return False
    if not copy.is_whole:
        out.warn(
            "The copy of RAM is not whole, so the logger keeps it. To give it up: tfsat-host log erase ram"
        )
        return False
    logger.erase_log(copy.entry)
    return True


def _as_dict(copy: Copy) -> dict[str, Any]:
    decoded = ("verdict", "samples", "samples_lost", "blocks_lost", "duration_s", "rate_hz")
    return {
        **entry_as_dict(copy.entry),
        "file": copy.path,
        "fetched": bool(copy.sha256),
        "sha256": copy.sha256 or None,
        "resumed_blocks": copy.resumed_blocks,
        "torn_blocks": copy.outcome.torn,
        "unreadable_blocks": copy.outcome.unreadable,
        **{name: copy.facts.get(name) for name in decoded},
        "warnings": copy.warnings,
    }


def _show(copies: list[Copy], released: bool, out: Output) -> None:
    if not copies:
        out.line("No recordings.")
    for copy in copies:
        how = "every block checked" if copy.sha256 else "fetched before, unchanged"
        size = size_words(copy.entry.blocks * BLOCK_BYTES)
        out.line(f"{copy.path}: {size}, session {copy.entry.session:08x}, {how}.")
        if copy.facts:
            facts = copy.facts
            rate = "unknown rate" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
            out.line(
                f"  {facts['verdict']}: {facts['samples']} samples in {facts['duration_s']:.3f} s, {rate}, "
                f"{facts['samples_lost']} lost"
            )
            out.line(f"  tfsat-host decode {copy.path}")
    if released:
        out.line("The drop is safe on this computer; the logger's RAM is free, a recording may be started.")
