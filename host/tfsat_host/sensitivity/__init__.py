"""How sure a rotation is: its derivatives by every parameter of the model, and a Monte Carlo over their errors.

    plan = Plan.of(robot, [PlannedStroke(0, 1.03, 0.7), ...], rate_rad_s=2.97)
    parameters = Parameters.of(robot, plan)
    sources = error_sources(parameters, robot.uncertainty)
    linear = linear_spread(derivatives(parameters), sources)
    outcomes = run_locally(Study(parameters, sources, samples=10_000, seed=1))

On a Dask cluster: `cluster.run_on_cluster(study, address)`. Knows nothing of terminals.
"""

from tfsat_host.sensitivity.derivatives import Derivatives, LinearSpread, derivatives, linear_spread
from tfsat_host.sensitivity.local import run_locally
from tfsat_host.sensitivity.parameters import Parameters
from tfsat_host.sensitivity.sources import ErrorSources, error_sources
from tfsat_host.sensitivity.strokes import Plan, PlannedStroke
from tfsat_host.sensitivity.study import Outcomes, Study
from tfsat_host.sensitivity.summary import Summary, TimeLimit, summary

__all__ = [
    "Derivatives",
    "ErrorSources",
    "LinearSpread",
    "Outcomes",
    "Parameters",
    "Plan",
    "PlannedStroke",
    "Study",
    "Summary",
    "TimeLimit",
    "derivatives",
    "error_sources",
    "linear_spread",
    "run_locally",
    "summary",
]
