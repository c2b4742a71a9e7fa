"""One sensor that contradicts all others is left out, and the others give every number with a ± that holds."""

from __future__ import annotations

import numpy as np
import pytest

from tests.evaluation.corrupted import (
    Flown,
    Wrong,
    axes_exchanged,
    gyro_plus,
    gyro_scaled,
    gyro_stuck,
    gyros_late,
    healthy_drop,
    sensor_moved,
    sensor_reversed,
    sensor_stuck,
)
from tests.evaluation.drops import MODEL, STDS, assert_angle_holds, few_of, turn_off
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.result.evaluation_tables import EVALUATION
from tfsat_host.evaluation.result.model_result import worth_of
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.quantity import record
from tfsat_host.sdlog import DropLog


def steps(log: DropLog, body: int, by_deg_s: tuple[float, float, float]) -> DropLog:
    """Return the log with the gyro's bias jumping in the middle of the second stroke."""
    return gyro_plus(log, body, np.outer(log.t_s > 1.2, by_deg_s))


FAULTS: list[tuple[str, Wrong]] = [
    ("gyro of body 2", lambda log: steps(log, 2, (0.5, -0.3, 0.4))),
    ("angle sensor 1 of joint 2", lambda log: sensor_moved(log, 2, 1.5)),
    # The body whose reorientation is asked for, at the end of the chain: one neighbour is left to tell its rate.
    ("gyro of body 1", lambda log: gyro_scaled(log, 1, (1.03, 1.02, 0.98))),
    ("gyro of body 3", lambda log: gyro_stuck(log, 3, 0.9)),
    ("gyro of body 4", lambda log: gyros_late(log, (4,), 2)),
    ("gyro of body 2", lambda log: axes_exchanged(log, 2, ((0, 1, 0), (1, 0, 0), (0, 0, -1)))),
    ("angle sensor 2 of joint 1", lambda log: sensor_reversed(log, 1)),
    ("angle sensor 1 of joint 1", lambda log: sensor_stuck(log, 0, 1.0)),
]


def evaluate_with(healthy: Flown, wrong: Wrong) -> Evaluation:
    return evaluate(wrong(healthy.drop.log), MODEL, healthy.calibration, healthy.drop.schedule)


@pytest.fixture(scope="module")
def healthy() -> Flown:
    return healthy_drop()


@pytest.mark.parametrize(("name", "wrong"), few_of(*FAULTS, least=3))
def test_the_others_tell_what_happened(healthy: Flown, name: str, wrong: Wrong) -> None:
    evaluation = evaluate_with(healthy, wrong)
    assert evaluation.left_out is not None and evaluation.left_out.name == name
    assert not {"rates", "attitudes", "strokes"} & {*evaluation.withheld}
    for body in (1, 2, 3, 4):
        off = turn_off(healthy.drop, evaluation.motion, body)
        assert off.stds < STDS and off.std_deg < 0.5
    for joint in (1, 2, 3):
        assert_angle_holds(healthy.drop, evaluation.motion, joint, widest_deg=0.2)
    # The numbers may be used; a drop with a broken sensor is no good one, and nothing is corrected by it.
    verdict = verdict_of(evaluation)
    assert verdict.level == "doubtful" and f"{name} left out" in verdict.sentence
    assert worth_of(evaluation) == "withheld"
    assert record(EVALUATION, evaluation)["left_out"] == name


def test_a_body_without_its_gyro_is_less_certain(healthy: Flown) -> None:
    whole = evaluate_with(healthy, lambda log: log)
    without = evaluate_with(healthy, lambda log: steps(log, 1, (0.5, -0.3, 0.4)))
    assert whole.left_out is None and record(EVALUATION, whole)["left_out"] is None
    assert without.reorientation.std_rad > 1.1 * whole.reorientation.std_rad


def test_two_wrong_sensors_are_not_taken_for_one(healthy: Flown) -> None:
    def both(log: DropLog) -> DropLog:
        return sensor_moved(steps(log, 2, (0.5, -0.3, 0.4)), 5, 1.5)

    evaluation = evaluate_with(healthy, both)
    assert evaluation.left_out is None and {"attitudes", "strokes"} <= {*evaluation.withheld}
