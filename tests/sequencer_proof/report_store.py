"""Section 2 of the report: power cuts, and bytes of the EEPROM that are others."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.damage import Place
from tests.sequencer_proof.power_cuts import Record, Tear
from tests.sequencer_proof.report_text import table
from tfsat_host.protocol.enums import ErrorCode


def render(proof: Proof) -> str:
    return f"{_cuts(proof)}\n\n{_damage(proof)}"


def _cuts(proof: Proof) -> str:
    rows = []
    for cuts in proof.cuts:
        outcomes = [f"{cuts.old[tear]} / {cuts.told[tear]} / {cuts.new[tear]}" for tear in Tear]
        repeated = f"{cuts.stored_afterwards} of {cuts.points}"
        rows.append((cuts.record.value, cuts.history.value, cuts.writes, cuts.points, *outcomes, repeated))
    points = sum(cuts.points for cuts in proof.cuts)
    header = ("upload of", "store held", "byte writes", "cut at", *(f"byte {tear.value}" for tear in Tear),
              "stored when repeated")  # fmt: skip
    rewrites = ", ".join(
        f"{record.value} {writes}" for record, writes in zip(Record, proof.rewrites, strict=True)
    )
    return (
        "## 2. Power cuts and damage\n\n"
        f"The power fails in the middle of every single EEPROM byte write of an upload: {points} cut "
        "points, each with the byte under way\n"
        f"torn in {len(Tear)} ways: {points * len(Tear)} power-ups. The cells *old / told / new*: how often "
        "the board then held the old record and armed with it,\nheld the old one and refused ARM because of the "
        "upload, or held the new one and armed, read back over the link. **Neither, or a mix of both: never.**\n"
        "*Old* ends with the third byte of the marker that says that an upload has begun. The other store "
        "stayed bit for bit what it was. Where no\nmaneuver had ever been stored, ARM was refused for that "
        "instead of *old*.\n\n"
        + table(header, rows)
        + "\n\nNo byte was written with what it held already. A second upload of what is stored left every byte as "
        f"it was; byte writes, to note that it\nhad begun and to take that back: {rewrites}."
    )


def _damage(proof: Proof) -> str:
    codes = (ErrorCode.STORE_DAMAGED, ErrorCode.UPLOAD_INTERRUPTED, ErrorCode.STORE_OLD_LAYOUT)
    rows = [
        (damaged.case.value, place.value, damaged.values[place], damaged.armed[place],
         *(damaged.refused[place, code] for code in codes))
        for damaged in proof.damaged
        for place in Place
    ]  # fmt: skip
    header = (
        "EEPROM with",
        "the byte is of",
        "tried",
        "armed, unchanged",
        *(f"`{c.name.lower()}`" for c in codes),
    )
    sampled = sum(image.tried for image in proof.damaged_image)
    return (
        "**One byte of the EEPROM is another**, after a power cut: each byte in use set to each of 256 values, "
        "every other to 8, in the\n*native* core, whose store is this firmware's source and knows no time. "
        "**Armed with another maneuver "
        "or other servo settings than those committed last: never.**\n\n"
        + table(header, rows)
        + f"\n\nThe flashed image gave the same answers to {sampled} of these, picked at random."
    )
