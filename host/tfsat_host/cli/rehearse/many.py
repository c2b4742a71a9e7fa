"""Many rehearsed drops: flown on all cores, told as a distribution."""

from __future__ import annotations

import argparse
import csv
import io
import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.cli.rehearse.prepared import image_of
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver, Schedule
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.rehearsal.many import Campaign, Distribution, Outcome
    from tfsat_host.robot import RobotModel

TABLE, SUMMARY = "runs.csv", "runs.json"


def rehearse_many(
    args: argparse.Namespace,
    maneuver: Maneuver,
    schedule: Schedule,
    filed: RobotModel,
    faults: tuple[Fault, ...],
    out: Output,
) -> int:
    """Returns the exit code: 0 if every drop was flown, recorded whole and evaluated."""
    from tfsat_host.maneuver import format_maneuver
    from tfsat_host.rehearsal.many import Campaign, distributions, fly_many

    names = tuple(fault.name for fault in faults)
    campaign = Campaign(schedule, filed, args.seed, args.as_filed, image_of(args, out), names)
    with out.progress("rehearsing", total=args.runs) as advance:
        outcomes = fly_many(campaign, args.runs, progress=lambda: advance(1))
    told = distributions(outcomes)
    result = _result(campaign, outcomes, told)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "maneuver.toml").write_text(format_maneuver(maneuver), encoding="utf-8")
    (args.out / TABLE).write_text(_rows(outcomes), encoding="utf-8")
    (args.out / SUMMARY).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    out.result(result, lambda: _show(result, told, args, out))
    return 0 if result["good"] == result["runs"] else DataLossError.exit_code


def _result(
    campaign: Campaign, outcomes: tuple[Outcome, ...], told: tuple[Distribution, ...]
) -> dict[str, Any]:
    verdicts = [one.verdict for one in outcomes]
    timing = [abs(off) for one in outcomes for off in one.strokes_off_us if off == off]
    return {
        "runs": len(outcomes),
        "seed": campaign.seed,
        "faults": list(campaign.faults),
        "dropped": sum(not one.refused for one in outcomes),
        **{level: verdicts.count(level) for level in ("good", "doubtful", "failed", "none")},
        "samples_lost": sum(max(0, one.samples_lost) for one in outcomes),
        "stroke_timing_us": {
            "rms": (sum(off**2 for off in timing) / len(timing)) ** 0.5 if timing else None,
            "largest": max(timing, default=None),
        },
        "distributions": [asdict(one) for one in told],
        "refused": [
            {"number": one.number, "seed": one.seed, "why": one.refused} for one in outcomes if one.refused
        ],
    }


def _rows(outcomes: tuple[Outcome, ...]) -> str:
    """CSV: a row for each drop, with the seed that flies it again alone."""
    names = list(dict.fromkeys(one.name for outcome in outcomes for one in outcome.compared))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [f"{name} {what}" for name in names for what in ("found", "std", "true")]
    writer.writerow(["number", "seed", "refused", "verdict", "samples_lost", *columns])
    for outcome in outcomes:
        by_name = {one.name: (one.found, one.std, one.true) for one in outcome.compared}
        values = [f"{value:.9g}" for name in names for value in by_name.get(name, (float("nan"),) * 3)]
        writer.writerow(
            [outcome.number, outcome.seed, outcome.refused, outcome.verdict, outcome.samples_lost, *values]
        )
    return text.getvalue()


def _show(
    result: dict[str, Any], told: tuple[Distribution, ...], args: argparse.Namespace, out: Output
) -> None:
    rows = [
        (
            one.name,
            one.unit,
            f"{one.mean_true:.3f}",
            f"{one.spread_true:.3f}",
            f"{one.rms_error:.4f}",
            f"{one.largest_error:.4f}",
            f"{one.stated_std:.4f}",
            f"{100.0 * one.held:.0f} %",
        )
        for one in told
    ]
    columns = ("", "unit", "true, mean", "spread", "error, rms", "largest", "stated ±", "95 % hold")
    if rows:
        out.table(columns, rows, title=f"What {result['runs']} evaluations found, beside the truth")
    out.line(
        f"Dropped {result['dropped']} of {result['runs']}: {result['good']} good, {result['doubtful']} doubtful, "
        f"{result['failed'] + result['none']} without an evaluation. Samples lost: {result['samples_lost']}."
    )
    timing = result["stroke_timing_us"]
    if timing["rms"] is not None:
        out.line(
            f"Strokes came {timing['rms']:.0f} us rms from their schedule, {timing['largest']:.0f} us at most, by the "
            "logger's clock."
        )
    for one in result["refused"][:3]:
        out.line(f"Drop {one['number']} was not let go: {one['why']}")
    out.line(f"Each drop: {args.out / TABLE}; one of them again: tfsat-host rehearse … --seed SEED")
