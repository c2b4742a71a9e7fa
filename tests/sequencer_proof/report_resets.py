"""Section 4 of the report: resets and the watchdog."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.report_text import range_ms, signed_range_us, table
from tests.sequencer_proof.resets import MOST_KNOCKS, Moment


def render(proof: Proof) -> str:
    rows = [
        (
            part.moment.value,
            part.cause.name.lower().replace("_", "-"),
            part.count,
            "ARMED, counted" if part.moment is Moment.ARMED else f"FAULT `{part.moment.fault.name.lower()}`",
            range_ms(part.silence),
            signed_range_us(part.errors) if part.errors else "nothing moves",
        )
        for part in proof.resets
    ]
    hangs = [
        (
            part.state.name,
            part.count,
            f"{part.reset_after.least / 1000:g} to {part.reset_after.greatest / 1000:g} ms",
        )
        for part in proof.hangs
    ]
    return (
        "## 4. Resets and the watchdog\n\n"
        "At random moments, after up to "
        f"{MOST_KNOCKS} knocks. Afterwards every servo got pulses of the width from before and no other; the "
        "knocks were\nstill counted, and the last run's report was still there; DISARM cleared state and fault.\n"
        "The pulse that was under way ends with the reset, since the chip lets its pins go: no "
        "program can help that.\n\n"
        + table(
            (
                "reset while",
                "cause",
                "resets",
                "came back as",
                "first pulse after",
                "errors of the release after",
            ),
            rows,
        )
        + "\n\nA main loop that hangs (the same firmware but for a planted endless loop, begun on "
        "order) is reset by the watchdog:\n\n" + table(("hung while", "times", "reset after"), hangs)
    )
