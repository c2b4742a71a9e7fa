"""The numbers of the result section and what the discussion makes of them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tests.validation.paper_numbers.numbers import GIVEN, Row, row
from tfsat_host.dynamics.history import TimedMove, history_from_moves
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.propagate import propagate
from tfsat_host.evaluation.com_fit.momentum_average import cutoff_hz
from tfsat_host.robot import RobotModel

HUNG_DEG = 6.0
FIRST_STROKE_DEG = 54.8
RATE_DEG_S = (-0.73, -0.48, -0.77)
BEFORE_DEG = (-0.03, -0.18, -0.26)
AFTER_DEG = (-0.07, -0.08, -0.21)
FALL_S = 2.5
BODY_1 = 0


def result_rows(robot: RobotModel) -> list[Row]:
    """Build the rows for the drop's results, recomputed where they can be."""
    still, turning = (flown_deg(robot, rate) for rate in ((0.0, 0.0, 0.0), RATE_DEG_S))
    # Norms of the paper's three components; it prints 0.31 and 0.24 deg.
    before, after = float(np.linalg.norm(BEFORE_DEG)), float(np.linalg.norm(AFTER_DEG))
    return [
        row(
            "reorientation of body 1 in the drop",
            "23.3",
            turning,
            unit="deg",
            details={"without the initial rates": f"{still:.1f} deg"},
        ),
        Row(
            "first stroke, commanded 59 deg",
            f"{FIRST_STROKE_DEG} deg",
            "-",
            GIVEN,
        ),
        Row(
            "initial rates about x, y, z",
            "-0.73, -0.48, -0.77 deg/s",
            "-",
            GIVEN,
        ),
        row(
            "cutoff of a moving average over 25 samples",
            "5",
            cutoff_hz(25, 280.0),
            unit="Hz",
        ),
        row(
            "final attitude error before the correction",
            "0.31",
            before,
            unit="deg",
        ),
        row(
            "final attitude error after it",
            "0.24",
            after,
            unit="deg",
        ),
        row(
            "reduction of the error",
            "30",
            # The paper prints 30 %; from its own numbers the reduction is 25 %.
            100.0 * (1.0 - 0.237 / 0.314),
            unit="%",
            details={"excess of the one over the other": f"{100.0 * (0.314 / 0.237 - 1.0):.0f} %"},
        ),
    ]


def flown_deg(robot: RobotModel, rate_deg_s: tuple[float, ...]) -> float:
    """Compute by how many deg body 1 turns in the fall.

    The first stroke is as flown, and joint 1 hangs open by 6 deg.
    """
    # As flown: the first stroke turned 54.8 deg instead of 59, and back.
    starts_s, sizes_deg = (0.70, 1.05, 1.47, 1.82), (FIRST_STROKE_DEG, 70.0, -FIRST_STROKE_DEG, -70.0)
    moves = [
        TimedMove(k % 2, np.radians(size), start_s, start_s + abs(size) / 170.0)
        for k, (start_s, size) in enumerate(zip(starts_s, sizes_deg, strict=True))
    ]
    history = history_from_moves(robot, moves, start_rad=np.radians([HUNG_DEG, 0.0, 0.0]), end_s=FALL_S)
    flight = propagate(
        Multibody.of(robot, BODY_1), history, initial_rate_rad_s=np.radians(rate_deg_s), step_s=0.005, order=6
    )
    return float(np.degrees(Rotation.from_quat(flight.quaternion_xyzw[-1]).magnitude()))
