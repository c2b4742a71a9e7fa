"""The card and the ring before it: there, with room for the day, and fast enough, by a recording that was made now."""

from __future__ import annotations

from tfsat_host.preflight.check import Check, go, no_go
from tfsat_host.preflight.evidence import Evidence, Failed, Missing, Running, Trial, unreached
from tfsat_host.protocol.enums import CardState, ErrorCode, LoggerState
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import fields, record

MOST_STALL_MS = 500
"""A card may be busy with a write for 250 ms, SDXC for 500 ms (SD Physical Layer Simplified Spec. 6.00, 4.6.2.2)."""
MOST_RING_SHARE = 0.75
"""Of the ring; what is left bridges the longest stall that a sound card makes, at any rate (8 s, or 1.3 s at 1 kHz)."""
LEAST_SHARE_WRITTEN = 0.5
"""Of the blocks that a running recording makes; the rest may be on its way to the card."""
_CARD_REMEDIES = {
    CardState.MISSING: ErrorCode.NO_CARD,
    CardState.UNREADABLE: ErrorCode.CARD_UNREADABLE,
    CardState.FULL: ErrorCode.CARD_FULL,
    CardState.WRITE_PROTECTED: ErrorCode.CARD_WRITE_PROTECTED,
    CardState.FAILING: ErrorCode.CARD_WRITE_FAILED,
}


def check_card(evidence: Evidence) -> Check:
    """A card that the logger calls ready, and a logger that has not given one up.

    The logger asks its card only when it has to write: a card that was taken out since is found by the recording that
    was made for `check_writing`, so what it says afterwards counts.
    """
    name = "card"
    answers = evidence.logger
    if isinstance(answers, Missing):
        return unreached(name, answers)
    status, card = answers.status, answers.later.card
    numbers = {"card": card.name.lower(), "logger_state": status.state.name.lower()}
    error = _CARD_REMEDIES.get(card)
    if status.state == LoggerState.FAILED and status.error != ErrorCode.NONE:
        error = status.error
    if card == CardState.FULL and error == ErrorCode.CARD_FULL and status.state != LoggerState.FAILED:
        return go(name, "It is there and can be read; its room is another check.", **numbers)
    if error is not None:
        what, _, cure = REMEDIES[error]
        return no_go(name, what, cure, **numbers)
    if card == CardState.UNKNOWN:
        return no_go(
            name,
            "The logger has not looked at its card yet, or counts its free room.",
            "Wait 10 s and run this again.",
            **numbers,
        )
    return go(name, "It is there and ready.", **numbers)


def check_ram(evidence: Evidence) -> Check:
    """RAM holds no drop that no card has: a new recording would be refused, or end it."""
    name = "ram"
    answers = evidence.logger
    if isinstance(answers, Missing):
        return unreached(name, answers)
    if answers.status.ram_holds_drop:
        return no_go(
            name,
            "The logger's RAM holds a drop that no card has.",
            "Keep the power on. tfsat-host log fetch ram",
            ram_holds_drop=True,
        )
    return go(name, "RAM holds no drop that no card has.", ram_holds_drop=False)


def check_room(evidence: Evidence) -> Check:
    """Room for the day's recordings, each as large as the settings let it become."""
    name = "card-room"
    answers = evidence.logger
    if isinstance(answers, Missing):
        return unreached(name, answers)
    status, card, each_mib = answers.status, answers.later.card, answers.settings.file_mib
    needed_mib = each_mib * evidence.recordings
    numbers = {
        "free_mib": status.card_free_mib,
        "needed_mib": needed_mib,
        "recordings": evidence.recordings,
        "file_mib": each_mib,
    }
    if card not in (CardState.READY, CardState.FULL):
        return unreached(name, Missing("There is no card whose room could be counted.", "See card."))
    if card == CardState.FULL or status.card_free_mib < needed_mib:
        return no_go(
            name,
            f"{status.card_free_mib} MiB are free; {evidence.recordings} recordings of {each_mib} MiB need "
            f"{needed_mib} MiB.",
            "tfsat-host log fetch all, then log erase all; or put in another card. For fewer drops: --drops N",
            **numbers,
        )
    return go(
        name,
        f"{status.card_free_mib} MiB are free; {evidence.recordings} recordings of {each_mib} MiB need {needed_mib}.",
        **numbers,
    )


def check_writing(evidence: Evidence) -> Check:
    """A real recording reached the card whole, and the card kept up with it."""
    name = "card-writing"
    answers = evidence.logger
    if isinstance(answers, Missing):
        return unreached(name, answers)
    if isinstance(answers.card, Failed):
        return no_go(name, answers.card.reason, answers.card.next_step)
    if isinstance(answers.card, Missing):
        return unreached(name, answers.card)
    check = (
        _of_trial(name, answers.card) if isinstance(answers.card, Trial) else _of_running(name, answers.card)
    )
    if answers.left and not check.blocks:
        return no_go(name, answers.left, "tfsat-host record stop, then tfsat-host log list", **check.evidence)
    return check


_TRIAL = fields(
    "verdict duration_s samples samples_dropped samples_lost blocks_lost worst_stall_ms=stall_max_ms "
    "ring_peak_blocks ring_blocks"
)
_RUNNING = fields("watched_s blocks_written=blocks samples_dropped ring_peak_blocks ring_blocks")


def _of_trial(name: str, trial: Trial) -> Check:
    numbers = record(_TRIAL, trial)
    said = _slow(trial.samples_dropped, trial.stall_max_ms, trial.ring_peak_blocks, trial.ring_blocks)
    lost = trial.samples_lost - trial.samples_dropped
    if lost > 0 or trial.blocks_lost:
        said.append(f"{max(lost, 0)} samples and {trial.blocks_lost} blocks were lost on the card")
    if trial.verdict != "complete" and not said:
        said.append(f"what was read back is {trial.verdict}")
    if said:
        return no_go(name, _sentence("A recording of", trial.duration_s, said), _NEW_CARD, **numbers)
    return go(
        name,
        f"A recording of {trial.duration_s:.1f} s was read back whole: {trial.samples} samples, 0 lost, worst stall "
        f"{trial.stall_max_ms} ms, ring at most {_percent(trial.ring_peak_blocks, trial.ring_blocks)} full.",
        **numbers,
    )


def _of_running(name: str, running: Running) -> Check:
    stall_ms = round(1000 * running.ring_peak_blocks * running.block_s)
    expected = running.watched_s / running.block_s
    numbers = {
        **record(_RUNNING, running),
        "session": f"{running.session:08x}",
        "stall_at_most_ms": stall_ms,
    }
    # How long the card took to prepare the file is in the ring's peak: so it says nothing of stalls where it is high.
    said = _slow(running.samples_dropped, 0, running.ring_peak_blocks, running.ring_blocks)
    if running.blocks < LEAST_SHARE_WRITTEN * expected:
        said.append(f"the card took {running.blocks} blocks, {expected:.0f} were due")
    if said:
        return no_go(
            name,
            _sentence("The running recording, watched for", running.watched_s, said),
            _NEW_CARD,
            **numbers,
        )
    return go(
        name,
        f"A recording runs already (session {running.session:08x}), so none was made for this: in "
        f"{running.watched_s:.1f} s the card took {running.blocks} blocks; since its start 0 samples were dropped and "
        f"the ring was at most {_percent(running.ring_peak_blocks, running.ring_blocks)} full.",
        **numbers,
    )


_NEW_CARD = "Put in another card (docs/logger.md), then run this preflight again."


def _slow(dropped: int, stall_ms: int, peak: int, ring: int) -> list[str]:
    said = []
    if dropped:
        said.append(f"{dropped} samples were dropped before a card that was too slow")
    if stall_ms > MOST_STALL_MS:
        said.append(f"the card took nothing for {stall_ms} ms ({MOST_STALL_MS} are allowed)")
    if peak > MOST_RING_SHARE * ring:
        said.append(f"the ring was {_percent(peak, ring)} full ({100 * MOST_RING_SHARE:g} % are allowed)")
    return said


def _sentence(of: str, duration_s: float, said: list[str]) -> str:
    return f"{of} {duration_s:.1f} s: {'; '.join(said)}."


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / max(whole, 1):.0f} %"
