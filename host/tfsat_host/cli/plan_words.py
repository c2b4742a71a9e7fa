"""What `tfsat-host plan` shows of a flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns

if TYPE_CHECKING:
    from tfsat_host.plan.flight import Flight

_WHY = {
    "within tolerance": "The measured error is within the tolerance, the true one is not: the noise is too great "
    "for it.",
    "no progress": "No single loop brings it nearer any more.",
    "given up": "The last plans brought no progress; it ends where it was measured nearest.",
    "primitives used up": "The primitives were used up; --most allows more.",
}


def show(result: dict[str, Any], flight: Flight, out: Output) -> None:
    """The primitives one by one, where they lead, and what would be possible."""
    _show_steps(result["steps"], out)
    if not flight.steps and flight.reached:
        out.line(
            f"Reached: it is there at the start, within {result['tolerance_deg']:g} deg. Nothing is flown."
        )
    else:
        out.line(
            f"{'Reached' if flight.reached else 'NOT REACHED'}: {_shown(result['error_deg'])} deg left of "
            f"{result['start_error_deg']:.1f} deg, tolerance {result['tolerance_deg']:g} deg, in "
            f"{result['duration_s']:.1f} s by {result['primitives']} of {result['table_size']} primitives."
        )
    if result["axis_rate_deg_s"] is not None:
        out.line(
            f"About the axis of this turn the best loop turns by {result['axis_rate_deg_s']:.2f} deg/s: the angle "
            f"alone takes {result['axis_time_s']:.1f} s by it."
        )
    if result["open_loop_error_deg"] is not None:
        out.line(f"Without feedback {_shown(result['open_loop_error_deg'])} deg would be left.")
    if not flight.reached:
        out.line(_advice(result))
    if result["measured_to_deg"] > result["tolerance_deg"]:
        out.line(
            f"The tolerance is below the noise: the attitude is measured to {result['measured_to_deg']:.2g} deg, "
            "and what is measured within the tolerance is so by chance."
        )
    if result["file"] is not None:
        out.line(f"Written to {result['file']}.")
    if result["history"] is not None:
        out.line(
            f"Joint angles written to {result['history']}: tfsat-host simulate --robot {result['robot_file']} "
            f"--history {result['history']}"
        )


_STEPS: Columns = (
    Column("number", "number"),
    Column("strokes", "joint:angle / deg"),
    Column("t_s", "t", form=".1f"),
    Column("measured_error_deg", "measured"),
    Column("error_deg", "error"),
)


def _show_steps(steps: Sequence[Mapping[str, Any]], out: Output) -> None:
    ends_s = accumulate(step["duration_s"] for step in steps)
    rows = [
        {**step, "number": count, "strokes": _strokes(step), "t_s": end_s}
        for count, (step, end_s) in enumerate(zip(steps, ends_s, strict=True), 1)
    ]
    if rows:
        show_rows(_STEPS, rows, out)


def _strokes(step: Mapping[str, Any]) -> str:
    return " ".join(f"{stroke['joint']}:{stroke['angle_deg']:+.1f}" for stroke in step["strokes"])


def _advice(result: dict[str, Any]) -> str:
    """What came of it, and what would be possible where that is certain."""
    why = _WHY[result["outcome"]]
    if result["outcome"] == "within tolerance":
        return why
    least = f"{why} The smallest error on the way was {_shown(result['least_error_deg'])} deg"
    if result["possible_tolerance_deg"] is None:
        return f"{least}."
    return f"{least}: --tolerance {result['possible_tolerance_deg']:g} is met."


def _shown(angle_deg: float) -> str:
    """An angle with three digits; what is only rounding is none."""
    return f"{angle_deg if angle_deg >= 1e-9 else 0.0:.3g}"
