"""Drops of hidden robots for campaigns: all of a robot drawn together, with any mismatches on top."""

from __future__ import annotations

from collections.abc import Sequence

from tests.fixtures.emulated_drop import Drop
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.maneuver import Schedule
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.hidden import draw_hidden, hidden_drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth
from tfsat_host.robot import RobotModel, Uncertainty


def hidden(
    schedule: Schedule,
    filed: RobotModel,
    seed: int,
    faults: Sequence[str] = (),
    *,
    as_uncertain: bool = True,
    uncertainty: Uncertainty | None = None,
) -> tuple[Drop, Calibration]:
    """Simulate a drop of a hidden robot and return it for `errors_of`, with the certificate as filed.

    Args:
        schedule: The maneuver to fly.
        filed: The robot as its file states it.
        seed: Seed of all draws.
        faults: Faults as typed: `wrong-masses=2`, `gyro-bias-step@armed`.
        as_uncertain: Draw all that the file calls uncertain; else centers of mass and sensors alone.
        uncertainty: Used instead of the file's.
    """
    # Without the file's uncertainty only centers of mass and sensors are drawn.
    truth = draw_hidden(filed, seed, uncertainty=uncertainty) if as_uncertain else drawn_truth(filed, seed)
    return drop_hidden(truth, schedule, filed, faults)


def drop_hidden(
    truth: Truth, schedule: Schedule, filed: RobotModel, faults: Sequence[str] = ()
) -> tuple[Drop, Calibration]:
    """Simulate a drop of this very robot; returns as `hidden` does."""
    simulated_drop = hidden_drop(schedule, filed, truth, list(map(fault_named, faults)))
    truth = simulated_drop.truth
    drop = Drop(
        simulated_drop.log,
        schedule,
        filed,
        truth.model,
        truth.imperfections,
        simulated_drop.rows,
        simulated_drop.landed_s,
    )
    return drop, simulated_drop.calibration
