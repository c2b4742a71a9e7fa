"""One evaluated drop as the object of `--json`; docs/evaluation.md says what each key means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.cli.evaluate.result_fall import fall_as_dict
from tfsat_host.cli.evaluate.result_model import model_as_dict

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.errors import TfsatError
    from tfsat_host.evaluation.checks.check import Check
    from tfsat_host.evaluation.evaluation import Evaluation, Turn
    from tfsat_host.evaluation.initial_rates import InitialRate
    from tfsat_host.evaluation.motion.motion import Motion
    from tfsat_host.evaluation.strokes.standing_joints import Standing
    from tfsat_host.evaluation.strokes.strokes_flown import FlownStroke
    from tfsat_host.evaluation.verdict import Verdict

Json = dict[str, Any]


def result_of(run: EvaluatedRun) -> Json:
    """Everything that was found in a drop; plain numbers, lists and text, NaN where something is unknown."""
    found = run.found
    return {
        "drop": str(run.place),
        "verdict": verdict_as_dict(run.verdict),
        **_body_1(found),
        "initial_rate_deg_s": _degrees(found.initial_rates[0].rate_rad_s),
        "initial_rate_deg_s_std": _degrees(found.initial_rates[0].std_rad_s),
        "strokes": [_stroke(stroke) for stroke in found.strokes],
        "standing": [_standing(one) for one in found.standing],
        **model_as_dict(found),
        "checks": [_check(check) for check in found.checks],
        "bodies": [
            _body(number, turn, rate)
            for number, (turn, rate) in enumerate(zip(found.turns, found.initial_rates, strict=True), 1)
        ],
        "joints": _joints(found.motion),
        "until_s": float(found.motion.t_s[-1]),
        "lag": _lag(found.motion),
        **fall_as_dict(found),
        "notes": [*found.notes, *run.remarks],
        "calibration": run.calibration_facts,
        "maneuver": None if run.files.maneuver is None else str(run.files.maneuver),
        "robot": found.model.name,
        "recording": _recording(run),
    }


def refused_as_dict(place: object, error: TfsatError, verdict: Verdict) -> Json:
    """One of several drops that could not be evaluated."""
    from tfsat_host.cli.output import error_as_dict

    return {"drop": str(place), "verdict": verdict_as_dict(verdict), "error": error_as_dict(error)}


def verdict_as_dict(verdict: Verdict) -> Json:
    """A verdict."""
    return {"level": verdict.level, "sentence": verdict.sentence, "reasons": list(verdict.reasons)}


def _body_1(found: Evaluation) -> Json:
    """The turn of body 1 under the keys that everybody looks for first."""
    turn = _turn(found.reorientation)
    return {key: value for key, value in turn.items() if key != "bridged"}


def _turn(turn: Turn) -> Json:
    import numpy as np
    from scipy.spatial.transform import Rotation

    return {
        "reorientation_deg": float(np.rad2deg(turn.angle_rad)),
        "reorientation_deg_std": float(np.rad2deg(turn.std_rad)),
        "rotation_vector_deg": _degrees(turn.rotation_vector_rad),
        "attitude_covariance_deg2": (np.rad2deg(np.rad2deg(turn.covariance))).tolist(),
        "euler_zyx_deg": _degrees(turn.euler_zyx_rad),
        "quaternion_xyzw": Rotation.from_rotvec(turn.rotation_vector_rad).as_quat(canonical=True).tolist(),
        "bridged": turn.bridged,
    }


def _body(number: int, turn: Turn, rate: InitialRate) -> Json:
    return {
        "body": number,
        **_turn(turn),
        "initial_rate_deg_s": _degrees(rate.rate_rad_s),
        "initial_rate_deg_s_std": _degrees(rate.std_rad_s),
    }


def _stroke(stroke: FlownStroke) -> Json:
    return {
        "stroke": stroke.number,
        "joint": stroke.joint,
        "scheduled_s": stroke.scheduled_s,
        "logged_s": stroke.logged_s,
        "commanded_deg": _degree(stroke.commanded_rad),
        "moved": stroke.moved,
        "size_deg": _degree(stroke.size_rad),
        "size_deg_std": _degree(stroke.size_std_rad),
        "short_deg": _degree(stroke.short_rad),
        "start_s": stroke.start_s,
        "start_s_std": stroke.start_std_s,
        "dead_time_s": stroke.dead_time_s,
        "end_s": stroke.end_s,
        "mean_rate_deg_s": _degree(stroke.mean_rate_rad_s),
        "peak_rate_deg_s": _degree(stroke.peak_rate_rad_s),
        "overshoot_deg": _degree(stroke.overshoot_rad),
        "settling_s": stroke.settling_s,
        "unfinished": stroke.unfinished,
        "remark": stroke.remark,
    }


def _standing(one: Standing) -> Json:
    return {
        "joint": one.joint,
        "from_s": one.from_s,
        "until_s": one.until_s,
        "drift_deg": _degree(one.drift_rad),
        "drift_deg_std": _degree(one.drift_std_rad),
        "greatest_deg": _degree(one.greatest_rad),
        "greatest_at_s": one.greatest_at_s,
        "unexpected": one.unexpected,
        "crept": one.crept,
        "remark": one.remark,
    }


def _joints(motion: Motion) -> list[Json]:
    import numpy as np

    release = int(np.searchsorted(motion.t_s, 0.0))
    found = []
    for joint in motion.joints:
        std = joint.std_rad()
        found.append(
            {
                "joint": joint.joint,
                "initial_deg": _degree(joint.angle_rad[release]),
                "initial_deg_std": _degree(std[release]),
                "final_deg": _degree(joint.angle_rad[-1]),
                "final_deg_std": _degree(std[-1]),
                "sensed": joint.sensed,
                "sensors": [
                    {
                        "sensor": sensor.sensor,
                        "mean_deg": _degree(sensor.mean_rad),
                        "rms_deg": _degree(sensor.rms_rad),
                        "greatest_deg": _degree(sensor.greatest_rad),
                        "expected_deg": _degree(sensor.expected_rad),
                    }
                    for sensor in joint.sensors
                ],
            }
        )
    return found


def _lag(motion: Motion) -> Json:
    lag = motion.lag
    return {
        "measured": lag.measured,
        "delay_ms": 1e3 * lag.delay_s,
        "delay_ms_std": 1e3 * lag.delay_std_s,
        "expected_ms": 1e3 * lag.expected_s,
    }


def _check(check: Check) -> Json:
    return {
        "name": check.name,
        "verdict": check.verdict,
        "value": check.value,
        "threshold": check.threshold,
        "unit": check.unit,
        "sentence": check.sentence,
        "cause": check.cause,
        "next_step": check.next_step,
    }


def _recording(run: EvaluatedRun) -> Json:
    log = run.found.log
    return {
        "file": str(run.files.recording),
        "session": f"{log.session:08x}",
        "released": None if run.recorded is None else run.recorded.isoformat(timespec="milliseconds"),
        "verdict": log.verdict,
        "samples": len(log),
        "samples_lost": log.samples_lost,
        "blocks_lost": log.blocks_lost,
        "rate_hz": log.rate_hz,
    }


def _degree(angle_rad: float) -> float:
    import numpy as np

    return float(np.rad2deg(angle_rad)) + 0.0


def _degrees(angles_rad: Any) -> list[float]:
    import numpy as np

    degrees: list[float] = (np.rad2deg(angles_rad) + 0.0).tolist()
    return degrees
