"""The card and the ring before it: there, with room for the day, and fast enough, by a recording that was made now."""

from __future__ import annotations

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import PreflightCheck, go, judge, no_go, not_made
from tfsat_host.preflight.preflight_evidence import (
    Evidence,
    Failed,
    Missing,
    RunningRecording,
    Trial,
    Unreached,
    require,
)
from tfsat_host.protocol.enums import CardState, ErrorCode, LoggerState
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import fields, record

MAX_STALL_MS = 500
"""A card may be busy with a write for 250 ms, SDXC for 500 ms (SD Physical Layer Simplified Spec. 6.00, 4.6.2.2)."""
MAX_RING_SHARE = 0.75
"""Of the ring; what is left bridges the longest stall that a sound card makes, at any rate (8 s, or 1.3 s at 1 kHz)."""
MIN_SHARE_WRITTEN = 0.5
"""Of the blocks that a running recording makes; the rest may be on its way to the card."""
_CARD_REMEDIES = {
    CardState.MISSING: ErrorCode.NO_CARD,
    CardState.UNREADABLE: ErrorCode.CARD_UNREADABLE,
    CardState.FULL: ErrorCode.CARD_FULL,
    CardState.WRITE_PROTECTED: ErrorCode.CARD_WRITE_PROTECTED,
    CardState.FAILING: ErrorCode.CARD_WRITE_FAILED,
}
_NEW_CARD = "Put in another card (docs/logger.md), then run this preflight again."
_TRIAL = fields(
    "verdict duration_s samples samples_dropped samples_lost blocks_lost worst_stall_ms=stall_max_ms "
    "ring_peak_blocks ring_blocks"
)
_RUNNING = fields("watched_s blocks_written=blocks samples_dropped ring_peak_blocks ring_blocks")


def check_card(evidence: Evidence) -> PreflightCheck:
    """Check that the logger calls its card ready and has not given one up.

    The logger accesses its card only when it has to write. A card that was taken out since is found by the
    recording made for `check_writing`, so the state afterwards counts.
    """
    answers = require(evidence.logger)
    status, card = answers.status, answers.later.card
    numbers = {"card": card.name.lower(), "logger_state": status.state.name.lower()}
    error = _CARD_REMEDIES.get(card)
    # A card that was given up during a recording left the error of that, which says more than its state.
    if status.state == LoggerState.FAILED and status.error != ErrorCode.NONE:
        error = status.error
    # A full card is sound: its room is judged by check_room().
    if card == CardState.FULL and error == ErrorCode.CARD_FULL and status.state != LoggerState.FAILED:
        return go("Card: readable (room: see card-room).", **numbers)
    if error is not None:
        what, _, cure = REMEDIES[error]
        return no_go(what, cure, **numbers)
    if card == CardState.UNKNOWN:
        return no_go(
            "Card: not examined yet, or its free room is being counted.",
            "Wait 10 s and run this again.",
            **numbers,
        )
    return go("Card: ready.", **numbers)


def check_ram(evidence: Evidence) -> PreflightCheck:
    """RAM holds no drop that no card has: a new recording would be refused, or end it."""
    holds = require(evidence.logger).status.ram_holds_drop
    return judge(
        ["a drop"] if holds else [],
        "Logger's RAM: holds {} that no card has.",
        Advice("Keep the power on. ", NextStep("log fetch", ("ram",))),
        "Logger's RAM: no unsaved drop.",
        ram_holds_drop=bool(holds),
    )


def check_room(evidence: Evidence) -> PreflightCheck:
    """Room for the day's recordings, each as large as the settings let it become."""
    answers = require(evidence.logger)
    free_mib, card, each_mib = answers.status.card_free_mib, answers.later.card, answers.settings.file_mib
    if card not in (CardState.READY, CardState.FULL):
        return not_made("There is no card whose room could be counted.", "See card.")
    needed_mib = each_mib * evidence.recordings
    need = f"Free: {free_mib} MiB (limit {needed_mib} MiB for {evidence.recordings} recordings of {each_mib} MiB)"
    return judge(
        [need] if card == CardState.FULL or free_mib < needed_mib else [],
        "{}.",
        Advice(
            NextStep("log fetch", ("all",)),
            ", then log erase all; or put in another card. For fewer drops: --drops N",
        ),
        f"{need}.",
        free_mib=free_mib,
        needed_mib=needed_mib,
        recordings=evidence.recordings,
        file_mib=each_mib,
    )


def check_writing(evidence: Evidence) -> PreflightCheck:
    """Check that a real recording reached the card whole, and that the card kept up with it."""
    answers = require(evidence.logger)
    if isinstance(answers.card, Failed):
        return no_go(answers.card.reason, answers.card.next_step)
    if isinstance(answers.card, Missing):
        raise Unreached(answers.card)
    check = judge_recording(answers.card) if isinstance(answers.card, Trial) else _of_running(answers.card)
    if answers.left and not check.blocks:
        next_step = Advice(NextStep("record stop"), ", then ", NextStep("log list"))
        return no_go(answers.left, next_step, **check.evidence)
    return check


def judge_recording(trial: Trial) -> PreflightCheck:
    """Judge a recording that was made for this, by what the card kept of it."""
    wrong = _slow(trial.samples_dropped, trial.stall_max_ms, trial.ring_peak_blocks, trial.ring_blocks)
    # Without those dropped before the card: the rest was written and did not come back.
    lost = trial.samples_lost - trial.samples_dropped
    if lost > 0 or trial.blocks_lost:
        wrong.append(f"{max(lost, 0)} samples and {trial.blocks_lost} blocks lost on the card (limit 0)")
    if trial.verdict != "complete" and not wrong:
        wrong.append(f"read back: {trial.verdict}")
    recording = f"Trial recording of {trial.duration_s:.1f} s"
    return judge(
        wrong,
        f"{recording}: {{}}.",
        _NEW_CARD,
        f"{recording}: read back whole, {trial.samples} samples, 0 lost, worst stall {trial.stall_max_ms} ms, ring "
        f"at most {_percent(trial.ring_peak_blocks, trial.ring_blocks)} full.",
        **record(_TRIAL, trial),
    )


def _of_running(running: RunningRecording) -> PreflightCheck:
    # Blocks that wait, times what each stands for, bound the longest stall from above.
    stall_ms = round(1000 * running.ring_peak_blocks * running.block_s)
    expected = running.watched_s / running.block_s
    # How long the card took to prepare the file is in the ring's peak: where it is high it tells nothing of stalls.
    wrong = _slow(running.samples_dropped, 0, running.ring_peak_blocks, running.ring_blocks)
    if running.blocks < MIN_SHARE_WRITTEN * expected:
        wrong.append(f"{running.blocks} blocks written ({expected:.0f} due)")
    return judge(
        wrong,
        f"Running recording, watched for {running.watched_s:.1f} s: {{}}.",
        _NEW_CARD,
        f"A recording runs already (session {running.session:08x}), so none was made for this: in "
        f"{running.watched_s:.1f} s the card took {running.blocks} blocks; since its start 0 samples were dropped and "
        f"the ring was at most {_percent(running.ring_peak_blocks, running.ring_blocks)} full.",
        **record(_RUNNING, running),
        session=f"{running.session:08x}",
        stall_at_most_ms=stall_ms,
    )


def _slow(dropped: int, stall_ms: int, peak: int, ring: int) -> list[str]:
    wrong = []
    if dropped:
        wrong.append(f"{dropped} samples dropped, card too slow (limit 0)")
    if stall_ms > MAX_STALL_MS:
        wrong.append(f"worst stall {stall_ms} ms (limit {MAX_STALL_MS} ms)")
    if peak > MAX_RING_SHARE * ring:
        wrong.append(f"ring {_percent(peak, ring)} full (limit {100 * MAX_RING_SHARE:g} %)")
    return wrong


def _percent(part: int, total: int) -> str:
    return f"{100 * part / max(total, 1):.0f} %"
