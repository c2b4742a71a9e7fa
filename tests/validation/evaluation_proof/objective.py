"""Where the paper's objective is really least: what its search would find, did it not stop."""

from __future__ import annotations

import numpy as np
from scipy.optimize import Bounds, minimize

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.model_comparison import ComparedModel, ModelInput
from tfsat_host.evaluation.com_fit.paper_swarm import momentum_polynomial

_UNIT = 1e-2
"""Of the objective, kg m^2/s: an optimizer wants numbers about one."""


def least_of_objective(driven: ModelInput, start: FloatArray) -> FloatArray:
    """(9,) offsets in mm, downhill from `start`; it has one minimum, and every start leads there."""
    offsets = driven.offsets.alone
    # CoM offsets alone, as the paper's objective has them.
    polynomial, bounds = momentum_polynomial(offsets, driven.flown), offsets.bounds

    def objective(values: FloatArray) -> float:
        return float(polynomial.objective(values[None])[0]) / _UNIT

    within = Bounds(-bounds, bounds)
    # The polynomial is smooth with one minimum: a local search from the swarm's result reaches it.
    optimum = minimize(
        objective, start, method="L-BFGS-B", bounds=within, tol=1e-13, options={"maxfun": 50_000}
    )
    return np.asarray(optimum.x)


def with_centers(driven: ModelInput, values: FloatArray) -> ComparedModel:
    """Apply CoM offsets (9,), in mm, to the model and leave all else as filed."""
    # Further parameters of the fit stay zero: the file's values.
    return driven.with_offsets(np.pad(values, (0, len(driven.offsets) - len(values))))
