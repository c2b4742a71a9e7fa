"""Section 2 of the report: power cuts."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.power_cuts import Tear
from tests.sequencer_proof.report_text import table


def render(proof: Proof) -> str:
    rows = []
    for cuts in proof.cuts:
        outcomes = [f"{cuts.old[tear]} / {cuts.new[tear]}" for tear in Tear]
        repeated = f"{cuts.stored_afterwards} of {cuts.points}"
        rows.append((cuts.record.value, cuts.history.value, cuts.writes, cuts.points, *outcomes, repeated))
    points = sum(cuts.points for cuts in proof.cuts)
    header = ("upload of", "store held", "byte writes", "cut at", *(f"byte {tear.value}" for tear in Tear),
              "stored when repeated")  # fmt: skip
    return (
        "## 2. Power cuts\n\n"
        f"The power fails in the middle of every single EEPROM byte write of an upload: {points} cut "
        "points, each with the byte under way\n"
        f"torn in {len(Tear)} ways: {points * len(Tear)} power-ups. The cells *old / new*: how often "
        "the board then held the "
        "old and how often the new record, read back\nover the link. **Neither, or a mix of both: "
        "never.** The other store "
        "stayed bit for bit what it was. ARM\nwas refused only where no maneuver had ever been stored.\n\n"
        + table(header, rows)
        + "\n\nNo byte was written with what it held already. A second upload of what is stored writes "
        f"{max(proof.rewrites)} bytes."
    )
