"""What `reproduce` found, for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import Column, Columns

if TYPE_CHECKING:
    from tfsat_host.run.bundle.comparing import Compared

_SHOWN = 20


def show(result: dict[str, Any], compared: Sequence[Compared], out: Output) -> None:
    """Part by part, then what is missing, lost, changed or doubtful, and the verdict last."""
    out.line(f"Unpacked  {printable(result['folder'])}: {result['files']} files, every hash is right.")
    out.line(f"Manifest  SHA-256 {result['manifest_sha256']}: compare it with the logbook's.")
    for one in compared:
        word = "NOT DONE" if one.lacking else "not done" if one.differs is None else "same"
        word = "REFUSED" if one.refused else word
        word = f"{len(one.differs)} DIFFER" if one.differs else word
        out.line(f"{one.what.capitalize()}: {word}. {printable(one.sentence)}")
        if one.differs:
            show_rows(DIFFERENCES, one.differs[:_SHOWN], out)
            if len(one.differs) > _SHOWN:
                out.line(f"… and {len(one.differs) - _SHOWN} more: --json has all.")
    for missing in result["missing"]:
        out.line(
            f"{'LOST' if missing['lost'] else 'Missing'} when bundled: {printable(missing['what'])}: "
            f"{printable(missing['why'])}"
        )
    for sentence in result["record"]:
        out.line(f"CHANGED   {printable(sentence)}")
    for sentence in result["doubts"]:
        out.line(f"DOUBTFUL  {printable(sentence)}")
    if result["environment"]:
        out.line(f"Computed with something else than then: {printable(' '.join(result['environment']))}")
    if result["not_computed"]:
        names = ", ".join(map(printable, result["not_computed"]))
        out.line(f"Kept as it was, not computed: {names}")
    if not result["same"]:
        out.line("NOT THE SAME: see above.")
    elif result["complete"]:
        out.line("SAME: the raw data give what was bundled.")
    else:
        out.line(f"SAME as far as it could be computed, and not whole: {printable(_briefly(result))}.")


def _briefly(result: dict[str, Any]) -> str:
    """What stands above at length: how much was lost or changed, or could not be computed."""
    counts = {
        "LOST": sum(missing["lost"] for missing in result["missing"]),
        "CHANGED": len(result["record"]),
        "DOUBTFUL": len(result["doubts"]),
        "NOT COMPUTED": sum(one["lacking"] for one in result["compared"]),
    }
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count) + " (above)"


def _value(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)[:80]


DIFFERENCES: Columns = (
    Column("key", "what"),
    Column("bundled", "bundled", words=lambda one: _value(one.bundled)),
    Column("recomputed", "recomputed", words=lambda one: _value(one.recomputed)),
    Column("relative", "relative", form=".1e"),
)
