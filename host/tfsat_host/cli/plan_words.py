"""What `tfsat-host plan` shows of a flight."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.orbit import Flight

_WHY = {
    "within tolerance": "The measured error is within the tolerance, the true one is not: the noise is too great "
    "for it.",
    "no progress": "No single loop brings it nearer any more.",
    "given up": "The last plans brought no progress; it ends where it was measured nearest.",
    "primitives used up": "The primitives were used up; --most allows more.",
}


def show(result: dict[str, Any], flight: Flight, out: Output) -> None:
    """The primitives one by one, where they lead, and what would be possible."""
    _show_steps(flight, out)
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


def _show_steps(flight: Flight, out: Output) -> None:
    rows = []
    elapsed_s = 0.0
    for count, step in enumerate(flight.steps, start=1):
        elapsed_s += step.primitive.duration_s
        strokes = [f"{joint + 1}:{math.degrees(angle):+.1f}" for joint, angle in step.primitive.strokes]
        errors = (f"{math.degrees(error):.3f}" for error in (step.measured_error_rad, step.error_rad))
        rows.append((count, " ".join(strokes), f"{elapsed_s:.1f}", *errors))
    if rows:
        out.table(("", "joint:angle / deg", "t / s", "measured / deg", "error / deg"), rows)


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
