"""The fall itself as JSON: clocks, release, landing, micro-gravity, release velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tfsat_host.evaluation.clocks.clock_fit import ClockFit
    from tfsat_host.evaluation.evaluation import Evaluation
    from tfsat_host.evaluation.fall.fall_instants import Instant
    from tfsat_host.evaluation.fall.micro_gravity import MicroGravity
    from tfsat_host.evaluation.witnesses.laser import ReleaseVelocity, Velocity

Json = dict[str, Any]


def fall_as_dict(found: Evaluation) -> Json:
    """The keys of an evaluation that speak of the fall."""
    clocks, velocity = found.clocks, found.release_velocity
    return {
        "clocks": {
            "sequencer": _clock(clocks.sequencer) if clocks else None,
            "video": _clock(clocks.video) if clocks else None,
        },
        "rest": {"duration_s": found.rest.duration_s},
        "release": {"std_s": found.instants.release_std_s, "felt": _instant(found.instants.release)},
        "landing": {"logged_s": found.instants.landing_logged_s, "felt": _instant(found.instants.landing)},
        "micro_gravity": _micro_gravity(found.micro_gravity),
        "release_velocity": None if velocity is None else _release_velocity(velocity),
        "fall_findings": [*found.instants.findings, *found.micro_gravity.findings],
    }


def _clock(fit: ClockFit | None) -> Json | None:
    if fit is None:
        return None
    return {
        "offset_s": fit.offset_s,
        "offset_s_std": fit.offset_std_s,
        "rate_ppm": fit.rate_ppm,
        "rate_ppm_std": fit.rate_ppm_std,
        "events": [
            {
                "event": one.pair.event,
                "clock_s": one.pair.clock_s,
                "logger_s": one.pair.logger_s,
                "residual_s": one.residual_s,
                "residual_s_std": one.std_s,
                "used": one.used,
            }
            for one in fit.residuals
        ],
        "findings": list(fit.findings),
    }


def _instant(instant: Instant | None) -> Json | None:
    return None if instant is None else {"t_s": instant.t_s, "t_s_std": instant.std_s}


def _micro_gravity(found: MicroGravity) -> Json:
    return {
        "windows": [
            {
                "name": quality.window.name,
                "from_s": quality.window.from_s,
                "until_s": quality.window.until_s,
                "bodies": [
                    {
                        "body": body.body,
                        "samples": body.samples,
                        "residual_g": body.residual_g.tolist(),
                        "residual_g_std": body.residual_std_g.tolist(),
                        "motion_rms_g": body.motion_rms_g,
                    }
                    for body in quality.bodies
                ],
            }
            for quality in found.windows
        ],
        "changes_g": found.changes_g.tolist(),
        "changes_g_std": found.changes_std_g.tolist(),
        "gravity_before_release": [
            {
                "body": one.body,
                "felt_g": one.norm_g,
                "felt_g_std": one.norm_std_g,
                "less_fall_g": one.less_fall_norm_g,
                "less_fall_g_std": one.less_fall_std_g,
                "passes": bool(one.passes),
            }
            for one in found.gravity
        ],
    }


def _release_velocity(found: ReleaseVelocity) -> Json:
    return {
        "downward": _velocity(found.downward),
        "downward_judged": found.downward_judged,
        "transversal_x": _velocity(found.transversal_x),
        "transversal_y": _velocity(found.transversal_y),
        "transversal_speed": _velocity(found.transversal_speed),
        "transversal_judged": found.transversal_judged,
        "samples": found.samples,
        "samples_left_out": found.samples_left_out,
        "scatter_mm": found.scatter_mm,
        "from_s": found.from_s,
        "until_s": found.until_s,
    }


def _velocity(velocity: Velocity | None) -> Json | None:
    if velocity is None:
        return None
    return {
        "mm_s": velocity.value_mm_s,
        "mm_s_std": velocity.std_mm_s,
        "interval_mm_s": [velocity.low_mm_s, velocity.high_mm_s],
    }
