"""Section 3 of the report: abuse of the link."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.link_abuse import LAST_BEGIN_US, STEP_US, Abuse
from tests.sequencer_proof.noise import STATES, Noise
from tests.sequencer_proof.report_text import table
from tfsat_host.protocol.enums import ErrorCode


def render(proof: Proof) -> str:
    return "\n\n".join([_abuse(proof), _noise(proof)])


def _abuse(proof: Proof) -> str:
    rows = []
    for abuse in Abuse:
        parts = [part for part in proof.abused if part.abuse is abuse]
        rows.append((abuse.value, sum(part.runs for part in parts), sum(part.moved for part in parts)))
    header = ("host", "runs", "runs in which a stroke began on another cycle than undisturbed")
    return (
        "## 3. Abuse of the link\n\n"
        f"Each kind begins at every {STEP_US // 1000} ms of a run, 0 to {LAST_BEGIN_US / 1e6:g} s "
        "after the release; "
        "before, the host asks for STATUS and reads the answers.\n"
        "The four onsets are compared with those of a run without a cable, cycle by cycle.\n\n"
        + table(header, rows)
    )


def _noise(proof: Proof) -> str:
    rows = []
    for noise in Noise:
        parts = [part for part in proof.noisy if part.noise is noise]
        sent = [sum(part.sent[state] for part in parts) for state in STATES]
        counts = [
            sum(part.rejected for part in parts),
            sum(part.answers for part in parts),
            sum(part.refusals for part in parts),
            sum(part.arms_refused[ErrorCode.STALE_TOKEN] for part in parts),
            sum(part.drops for part in parts),
        ]
        rows.append((noise.value, sum(sent), *sent, *counts))
    names = [state.name for state in STATES]
    header = (
        "sent",
        "in all",
        *names,
        "frames found damaged",
        "answers",
        "of them refusals",
        "of them ARM in SAFE, for its token",
        "drops flown on time",
    )
    return (
        "Noise at random moments. It never armed the board, disarmed it, moved a servo or a stroke "
        "by a cycle, or changed "
        "one bit of the EEPROM. In SAFE the board\nlacked nothing but the right token to be armed: what ARM "
        "frames it refused, it refused for that.\nThe frames are of every type but DISARM, which always works, and "
        "JOINT_REPORT and MANEUVER_BEGIN, which forbid ARM; ARM has any token but the "
        "right one, JOG any flag but the right one.\n\n" + table(header, rows)
    )
