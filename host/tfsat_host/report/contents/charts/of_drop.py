"""All charts of a drop, in the order in which one reads them."""

from __future__ import annotations

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.chart import Chart
from tfsat_host.report.contents.charts.attitude import attitude_error_chart, euler_chart
from tfsat_host.report.contents.charts.joints import joint_chart
from tfsat_host.report.contents.charts.momentum import (
    averaged_momentum_chart,
    momentum_chart,
    momentum_spectrum_chart,
)
from tfsat_host.report.contents.charts.rates import rate_chart, rate_spectrum_chart, unexplained_chart
from tfsat_host.report.contents.charts.sensors import force_chart, gyro_residual_chart
from tfsat_host.report.contents.charts.windows import attitude_spectrum_chart, window_chart


def charts_of(found: Evaluation) -> dict[str, Chart]:
    """By id."""
    drawn = (
        euler_chart(found),
        rate_chart(found),
        joint_chart(found),
        averaged_momentum_chart(found),
        attitude_error_chart(found),
        momentum_spectrum_chart(found),
        rate_spectrum_chart(found),
        attitude_spectrum_chart(found),
        momentum_chart(found),
        unexplained_chart(found),
        gyro_residual_chart(found),
        force_chart(found),
        window_chart(found),
    )
    return {chart.id: chart for chart in drawn}
