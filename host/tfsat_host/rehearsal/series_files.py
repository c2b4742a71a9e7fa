"""What many rehearsed drops leave: a table of them, and their result."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from dataclasses import asdict
from typing import Any

from tfsat_host.maneuver import Maneuver, format_maneuver
from tfsat_host.rehearsal.many import Distribution, Flown, Series
from tfsat_host.rehearsal.result_folder import ResultFolder
from tfsat_host.robot import RobotModel
from tfsat_host.run.files import MANEUVER, ROBOT

TABLE, SUMMARY = "runs.csv", "runs.json"


def write_series(
    folder: ResultFolder,
    maneuver: Maneuver,
    filed: RobotModel,
    outcomes: tuple[Flown, ...],
    result: dict[str, Any],
) -> None:
    """Maneuver, robot, a table with a row for each drop, and the result; all or none. Raises UsageError, OSError."""
    robot = filed.path.read_bytes()  # which may lie in this very folder
    with folder.replaced():
        folder.file(MANEUVER).write_text(format_maneuver(maneuver), encoding="utf-8")
        folder.file(ROBOT).write_bytes(robot)
        folder.file(TABLE).write_text(_rows(outcomes), encoding="utf-8")
        folder.file(SUMMARY).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        folder.sealed()


def series_as_dict(
    series: Series, asked: int, outcomes: tuple[Flown, ...], told: tuple[Distribution, ...]
) -> dict[str, Any]:
    """For `--json`, and for the folder."""
    verdicts = [one.verdict for one in outcomes]
    timing = [abs(off) for one in outcomes for off in one.strokes_off_us if off == off]
    return {
        "runs": len(outcomes),
        "asked": asked,
        "seed": series.seed,
        "robot": {"name": series.filed.name, "file": str(series.filed.path)},
        "as_filed": series.as_filed,
        "imu": outcomes[0].imu or None,
        "faults": list(series.faults),
        "faults_noticed": [_noticed(name, outcomes) for name in series.faults],
        "broke_design": [one.number for one in outcomes if one.broke_design],
        "dropped": sum(not one.refused for one in outcomes),
        "no_go": dict(Counter(name for one in outcomes for name in one.no_go)),
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


def _rows(outcomes: tuple[Flown, ...]) -> str:
    """CSV: a row for each drop, with the seed that flies it again alone."""
    names = list(dict.fromkeys(one.name for outcome in outcomes for one in outcome.compared))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [f"{name} {what}" for name in names for what in ("found", "std", "true")]
    writer.writerow(["number", "seed", "no_go", "refused", "verdict", "samples_lost", *columns])
    for outcome in outcomes:
        by_name = {one.name: (one.found, one.std, one.true) for one in outcome.compared}
        values = [f"{value:.9g}" for name in names for value in by_name.get(name, (float("nan"),) * 3)]
        told = (" ".join(outcome.no_go), outcome.refused, outcome.verdict, outcome.samples_lost)
        writer.writerow([outcome.number, outcome.seed, *told, *values])
    return text.getvalue()


def _noticed(name: str, outcomes: tuple[Flown, ...]) -> dict[str, Any]:
    """In how many drops a fault struck and was noticed, and by whom."""
    told = [one.noticed[name] for one in outcomes if name in one.noticed]
    return {
        "name": name,
        "struck": len(told),
        "noticed": sum(bool(who) for who in told),
        "noticed_by": dict(Counter(who for each in told for who in each)),
    }
