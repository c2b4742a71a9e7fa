"""The fall itself: clocks, release, landing, micro-gravity, release velocity."""

from __future__ import annotations

from typing import Any

from tfsat_host.evaluation.clocks.clock_fit import ClockFit
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.laser.velocity import Velocity
from tfsat_host.quantity import Column, Columns, Table, fields, nested, record

_INSTANT: Columns = (Column("t_s", std="std_s"),)
_EVENT: Columns = (
    *fields("event=pair.event clock_s=pair.clock_s logger_s=pair.logger_s used"),
    Column("residual_s", std="std_s"),
)


def _used(fit: ClockFit) -> str:
    return f"{sum(one.used for one in fit.residuals)} of {len(fit.residuals)}"


def _greatest_residual_s(fit: ClockFit) -> float:
    return max((abs(one.residual_s) for one in fit.residuals if one.used), default=float("nan"))


CLOCK: Columns = (
    Column("", "clock", words=lambda fit: fit.name),
    Column("offset_s", "offset", std="offset_std_s", form="+.3f", shown_in="ms"),
    Column("rate_ppm", "fast by", std="rate_ppm_std", form="+.1f"),
    Column("", "events used", words=_used),
    Column("events", of="residuals", columns=_EVENT),
    *fields("findings"),
)
_SHOWN_CLOCK: Columns = (
    *CLOCK,
    Column("greatest_residual_s", "greatest residual", of=_greatest_residual_s, shown_in="ms"),
)

_MICRO_GRAVITY: Columns = (
    Column(
        "windows",
        columns=(
            *fields("name=window.name from_s=window.from_s until_s=window.until_s"),
            Column(
                "bodies",
                columns=(
                    *fields("body samples motion_rms_g"),
                    Column("residual_g", std="residual_std_g"),
                ),
            ),
        ),
    ),
    Column("changes_g", std="changes_std_g"),
    Column(
        "gravity_before_release",
        of="gravity",
        columns=(
            *fields("body"),
            Column("felt_g", of="norm_g", std="norm_std_g"),
            Column("less_fall_g", of="less_fall_norm_g", std="less_fall_std_g"),
            Column("passes", of=lambda one: bool(one.passes)),
        ),
    ),
)


def _interval(velocity: Velocity) -> list[float]:
    return [velocity.low_mm_s, velocity.high_mm_s]


_VELOCITY: Columns = (
    Column("mm_s", of="value_mm_s"),
    Column("mm_s_std", of="std_mm_s"),
    Column("interval_mm_s", of=_interval),
)
_RELEASE_VELOCITY: Columns = (
    *(
        Column(name, columns=_VELOCITY)
        for name in ("downward", "transversal_x", "transversal_y", "transversal_speed")
    ),
    *fields("downward_judged transversal_judged samples samples_left_out scatter_mm from_s until_s"),
)


def fall(found: Evaluation) -> dict[str, Any]:
    """The keys of JSON that speak of the fall."""
    clocks, instants = found.clocks, found.instants
    return {
        "clocks": {
            "sequencer": nested(CLOCK, clocks.sequencer if clocks else None),
            "video": nested(CLOCK, clocks.video if clocks else None),
        },
        "rest": {"duration_s": found.rest.duration_s},
        "release": {"std_s": instants.release_std_s, "felt": nested(_INSTANT, instants.release)},
        "landing": {"logged_s": instants.landing_logged_s, "felt": nested(_INSTANT, instants.landing)},
        "micro_gravity": record(_MICRO_GRAVITY, found.micro_gravity),
        "release_velocity": nested(_RELEASE_VELOCITY, found.release_velocity),
        "fall_findings": [*instants.findings, *found.micro_gravity.findings],
    }


def clock_table(found: Evaluation) -> Table:
    """Of the clocks besides the logger's."""
    fits = (found.clocks.sequencer, found.clocks.video) if found.clocks else ()
    return Table(
        "Clocks",
        _SHOWN_CLOCK,
        [fit for fit in fits if fit is not None],
        "Against the logger's clock, by which all times are given.",
    )
