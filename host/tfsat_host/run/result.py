"""One evaluated drop as the object of `--json`; docs/evaluation.md says what each key means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.quantity import Column, Columns, record, records

if TYPE_CHECKING:
    from tfsat_host.errors import TfsatError
    from tfsat_host.evaluation.verdict import Verdict
    from tfsat_host.run.evaluated import EvaluatedRun

Json = dict[str, Any]

_RECORDING: Columns = (
    Column("file", of=lambda run: str(run.files.recording)),
    Column("session", of=lambda run: f"{run.found.log.session:08x}"),
    Column(
        "released",
        of=lambda run: None if run.recorded is None else run.recorded.isoformat(timespec="milliseconds"),
    ),
    Column("samples", of=lambda run: len(run.found.log)),
    *(Column(key, of=f"found.log.{key}") for key in ("verdict", "samples_lost", "blocks_lost", "rate_hz")),
)


def result_of(run: EvaluatedRun) -> Json:
    """Everything that was found in a drop; plain numbers, lists and text, NaN where something is unknown."""
    from tfsat_host.evaluation.result.drop import JOINTS, LAG, STANDING, STROKES, bodies, fall, joints
    from tfsat_host.evaluation.result.model import model
    from tfsat_host.evaluation.result.tables import CHECKS

    found = run.found
    of_bodies = bodies(found)
    return {
        "drop": str(run.place),
        "verdict": run.verdict.as_dict(),
        # The turn of body 1 under the keys that everybody looks for first.
        **{key: value for key, value in of_bodies[0].items() if key not in ("body", "bridged")},
        "strokes": records(STROKES, found.strokes),
        "standing": records(STANDING, found.standing),
        **model(found),
        "checks": records(CHECKS, found.checks),
        "bodies": of_bodies,
        "joints": records(JOINTS, joints(found.motion)),
        "until_s": float(found.motion.t_s[-1]),
        "lag": record(LAG, found.motion.lag),
        **fall(found),
        "notes": [*found.notes, *run.remarks],
        "calibration": run.calibration_facts,
        "maneuver": None if run.files.maneuver is None else str(run.files.maneuver),
        "robot": found.model.name,
        "recording": record(_RECORDING, run),
    }


def refused_as_dict(place: object, error: TfsatError, verdict: Verdict) -> Json:
    """One of several drops that could not be evaluated."""
    from tfsat_host.json_values import error_as_dict

    return {"drop": str(place), "verdict": verdict.as_dict(), "error": error_as_dict(error)}
