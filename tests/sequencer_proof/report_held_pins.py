"""Section 4 of the report, continued: servo pins that are held."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.held_pins import UNSEEN_US
from tests.sequencer_proof.report_text import table


def render(proof: Proof) -> str:
    rows = [
        (
            ", ".join(f"D{8 + joint}" for joint in part.joints),
            part.level.name.lower(),
            part.count,
            part.on_time,
            part.late,
            part.missed,
            part.extra_marks,
        )
        for part in proof.held
    ]
    return (
        "### Pins held\n\n"
        "Servo pins that are held at a level, from before the arming or from a random moment on, and let go at a "
        "random moment or\nnever; half of these moments lie around the first pulse of a stroke. Then a watchdog or "
        "brown-out reset at a random moment\nof the run or after it, and the pins let go. What a servo had been "
        "told is read off its pin: the width of the last whole pulse.\nAfter every reset each servo got pulses of "
        "that width and no other (or none, where the board came back SAFE); STATUS told the\nangles and the number "
        "of strokes, RUN_REPORT when each began, or that it did not, and the stroke line had marked each.\nRuns in "
        f"which a pulse was cut or stretched by less than {UNSEEN_US} µs are left out: an interrupt may look that "
        "late.\n\n"
        + table(
            ("held", "level", "runs", "strokes on time", "late", "missed", "marks of pulses cut short"),
            rows,
        )
    )
