"""The paper's 59/70, one joint at a time, flown by the model of a drop whose joints moved together."""

from __future__ import annotations

from tfsat_host.dynamics.simulation import Simulation, fly
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.maneuver import four_stroke, schedule_maneuver

REFERENCE = schedule_maneuver(four_stroke(59.0, 70.0))


def fly_reference(evaluation: Evaluation) -> Simulation | None:
    """Simulate 59/70 from the release to the end of the evaluation, by the nominal model with the drop's momentum.

    None: no joints moved together, a stroke was not flown, or attitudes are not given.
    """
    schedule = evaluation.schedule
    # A loop that was not closed has turned by the open joints' poses: no gain.
    closed = all(stroke.moved for stroke in evaluation.strokes)
    if schedule is None or schedule.moving_at_once < 2 or not closed or not evaluation.is_given():
        return None
    # Until the first stroke the predicted rate of the base is that of the drop's momentum alone.
    rate_rad_s = evaluation.explained.nominal.prediction.rate_rad_s[0]
    until_s = float(evaluation.motion.bodies[evaluation.model.base].t_s[-1])
    return fly(evaluation.model, REFERENCE, until_s=until_s, initial_rate_rad_s=rate_rad_s)
