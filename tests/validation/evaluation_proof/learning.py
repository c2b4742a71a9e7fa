"""What `design --learn com` is worth: hidden robots dropped with its maneuver and with the paper's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.campaign import keep_result
from tests.validation.evaluation_proof.errors import join_errors
from tests.validation.evaluation_proof.figures import figures
from tests.validation.evaluation_proof.hidden import hidden
from tests.validation.simulation_based_calibration.drops import CHIPS, FILED
from tests.validation.tables import csv_text
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import Maneuver, schedule_maneuver
from tfsat_host.rehearsal.learning import USUAL, learn

ROBOTS = 50
FIRST_SEED = 9001


class Lesson(NamedTuple):
    """One robot: errors of the nine offsets, by the maneuver's name."""

    by: Mapping[str, Errors]


@cache
def maneuvers() -> dict[str, Maneuver]:
    """Return the paper's maneuver and the one from which a drop learns most; takes a minute."""
    # Once a process: the search takes a minute and is the same for all robots.
    learnt = learn(FILED, "com").lessons[0]
    return {USUAL[0]: USUAL[1], learnt.name: learnt.maneuver}


def one_robot(seed: int) -> Lesson:
    """Simulate two drops of a hidden robot, one with each maneuver."""
    return Lesson({name: _drop_errors(maneuver, seed) for name, maneuver in maneuvers().items()})


def _drop_errors(maneuver: Maneuver, seed: int) -> Errors:
    schedule = schedule_maneuver(maneuver)
    drop, calibration = hidden(schedule, FILED, seed, [CHIPS])
    fit = evaluate(drop.log, FILED, calibration, schedule).explained.fit
    return Errors(fit.values[:9] - drop.true_com_offsets_mm, fit.std[:9])


def robot(seed: int) -> Lesson:
    """Or what it was before with the same code."""
    lesson: Lesson = keep_result(
        f"lesson-{seed}", "tests.validation.evaluation_proof.learning", partial(one_robot, seed)
    )
    return lesson


def compare_maneuvers(lessons: Sequence[Lesson]) -> str:
    """Return a table with a row a maneuver: errors of the nine offsets over all robots."""
    rows = [
        (name.removeprefix("to learn: "), *figures(join_errors(lesson.by[name] for lesson in lessons)))
        for name in lessons[0].by
    ]
    columns = ("maneuver", "rms", "largest", "stated ±, median", "z", "95 % hold")
    return csv_text(columns, rows)


def learning_csv(lessons: Sequence[Lesson]) -> str:
    """Robot by robot."""
    rows = [
        (
            str(FIRST_SEED + k),
            *(
                f"{np.sqrt((v**2).mean()):.3f}"
                for errors in lesson.by.values()
                for v in (errors.error, errors.std)
            ),
        )
        for k, lesson in enumerate(lessons)
    ]
    columns = [f"{name}, {what}" for name in lessons[0].by for what in ("error rms", "± rms")]
    return csv_text(("robot", *columns), rows)
