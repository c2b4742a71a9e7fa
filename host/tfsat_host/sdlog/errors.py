"""Why a file gives no drop log."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.errors import TfsatError, UsageError

LOOK_AGAIN = (
    "Copy the recording (DROP0001.BIN and up) off the card once more and decode the copy: "
    "tfsat-host decode SD.bin"
)


class LogError(TfsatError):
    """The file is no log, or one that would decode to wrong values (exit code 1)."""


class NoBlockError(LogError):
    """The file holds not one undamaged block (exit code 1)."""


class SessionError(UsageError):
    """The recording asked for is not in the file (exit code 2)."""


def not_a_file(path: Path, candidates: list[Path]) -> LogError:
    """A directory was given; `candidates` are the logs in it."""
    if len(candidates) == 1:
        step = f"It holds one log: tfsat-host decode {candidates[0]}"
    elif candidates:
        step = "It holds several logs, name one: " + ", ".join(str(c) for c in candidates)
    else:
        step = "Name the file that came off the card: tfsat-host decode DROP0001.BIN"
    return LogError(what=f"{path} is a directory, not a log.", meaning="Nothing was decoded.", next_step=step)


def missing(path: Path) -> LogError:
    """There is no such file."""
    return LogError(
        what=f"There is no file {path}.",
        meaning="Nothing was decoded.",
        next_step="Check the name; on the card the recordings are called DROP0001.BIN and up.",
    )


def unreadable(path: Path, reason: str) -> LogError:
    """The system refused to read."""
    return LogError(
        what=f"{path} cannot be read: {reason}.",
        meaning="Nothing was decoded; what is on the card is untouched.",
        next_step="Check the permissions; if it is on the card, copy the whole card to an image first "
        "(ddrescue) and decode the image.",
    )


def not_seekable(path: Path) -> LogError:
    """A pipe, a socket or an endless device."""
    return LogError(
        what=f"{path} is not a file that can be read from any place: it is a pipe or a stream.",
        meaning="Nothing was decoded: a recording is put together from all over its file.",
        next_step="Save it to a file first, and decode that: cat ... >SD.bin; tfsat-host decode SD.bin",
    )


def empty(path: Path) -> LogError:
    """Zero bytes."""
    return NoBlockError(
        what=f"{path} is empty (0 bytes).",
        meaning="The logger never opened a recording in it, or the copy failed.",
        next_step=LOOK_AGAIN,
    )


def never_written(path: Path, size_bytes: int) -> LogError:
    """Preallocated by the logger, all zero."""
    return NoBlockError(
        what=f"{path} holds {size_bytes} zero bytes and no block: "
        "it was prepared for a recording that never began.",
        meaning="Nothing was recorded in this file.",
        next_step="Look for another file on the card; before the next drop, tfsat-host status must show "
        "the logger recording.",
    )


def no_blocks(path: Path, detail: str) -> LogError:
    """Not one undamaged block of ours."""
    return NoBlockError(
        what=f"{path} is not a tfsat log: {detail}.",
        meaning="Nothing was decoded.",
        next_step="Give a recording off the logger's card (DROP0001.BIN and up), a copy, or an image of the card.",
    )


def newer_version(path: Path) -> LogError:
    """All blocks have an unknown layout version."""
    return LogError(
        what=f"{path} was recorded with a block layout that this program does not know.",
        meaning="Nothing was decoded; the recording itself is undamaged.",
        next_step="Take the release of tfsat that the logger runs, and in its folder: python -m pip install .",
    )


def no_header(path: Path, session: int) -> LogError:
    """The header and all its copies are gone: the scales are unknown."""
    return LogError(
        what=f"{path}: recording {session:08x} has lost its header and every copy of it.",
        meaning="The scales of its numbers are unknown, so no value can be given.",
        next_step=LOOK_AGAIN,
    )


def absurd_header(path: Path, session: int, reason: str) -> LogError:
    """The header is undamaged as far as its CRC goes, and makes no sense."""
    return LogError(
        what=f"{path}: the header of recording {session:08x} makes no sense: {reason}.",
        meaning="Its values would be wrong by an unknown factor, so none are given.",
        next_step="Flash the logger from this release and record again; keep the file as evidence.",
    )


def no_samples(path: Path, session: int, others: tuple[int, ...]) -> LogError:
    """A header, and nothing else."""
    step = "Look for another file on the card."
    if others:
        step = "The file also holds " + ", ".join(f"--session {other:08x}" for other in others) + "."
    return LogError(
        what=f"{path}: recording {session:08x} has no samples.",
        meaning="The recording ended before anything was measured.",
        next_step=step,
    )


def no_such_session(path: Path, wanted: int, sessions: tuple[int, ...]) -> SessionError:
    """`--session` names a recording that is not there."""
    return SessionError(
        what=f"{path} holds no recording {wanted:08x}.",
        meaning="Nothing was decoded.",
        next_step="It holds: " + ", ".join(f"{session:08x}" for session in sessions),
    )


def changed_while_read(path: Path) -> LogError:
    """The file got shorter or its blocks changed between two looks."""
    return LogError(
        what=f"{path} changed while it was read.",
        meaning="Nothing was decoded.",
        next_step="Wait until the copy from the card has ended, then run the same command again.",
    )


def too_many_pieces(path: Path, most: int) -> LogError:
    """Undamaged blocks in an order that no logger leaves behind."""
    return LogError(
        what=f"{path} holds undamaged blocks in more than {most} separate pieces.",
        meaning="Nothing was decoded: this is no recording that a logger wrote, nor what a failing card leaves of one.",
        next_step="Decode the recording's own file (DROP0001.BIN and up) instead of an image that mixes many.",
    )


def too_large(path: Path) -> LogError:
    """The columns of the recording do not fit in memory."""
    return LogError(
        what=f"The recording in {path} does not fit in this computer's memory.",
        meaning="Nothing was decoded; the file itself may be in order.",
        next_step="Close other programs, or decode on a computer with more memory: "
        "a recording takes about 1.3 times its file.",
    )
