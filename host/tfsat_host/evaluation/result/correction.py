"""Whether the correction of the model is one to make: told by the data, plausible, and more than noise."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.special import chdtri

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.comparison import AttitudeError
from tfsat_host.evaluation.model_fit.explained import EXPECTED_DISTANCE

NOT_CALLED_FOR = 0.05
"""A correction as great as this one comes of noise alone in more than this share of drops: none is called for."""
MISSED = f"95 % lie below {EXPECTED_DISTANCE:g}"

Worth = Literal["to be made", "not called for", "withheld"]


def significance(found: Evaluation) -> float:
    """Distance of the p offsets from zero over what 95 % of corrections of a right model stay below."""
    fit = found.explained.fit
    p = len(fit.values)
    squared = fit.values @ np.linalg.solve(fit.covariance[:p, :p], fit.values)
    return float(np.sqrt(squared / chdtri(p, NOT_CALLED_FOR)))


def worth_of(found: Evaluation) -> Worth:
    """Of the correction that was found."""
    if found.explained.withheld:
        return "withheld"
    before = found.explained.before.error.mahalanobis
    if before <= EXPECTED_DISTANCE and significance(found) <= 1.0:
        return "not called for"
    return "to be made"


def correction_sentences(found: Evaluation) -> tuple[str, ...]:
    """For a person who has to decide what to change in the robot file."""
    worth, untold = worth_of(found), found.identifiability.untold
    if worth == "withheld":
        return ("The correction is withheld: change nothing by it.", *found.explained.withheld)
    if worth == "not called for":
        return (
            "No correction is called for: the model as filed explains the motion, and what was found beyond it is "
            "within its own uncertainty.",
        )
    if untold:
        told = len(found.identifiability.directions) - len(untold)
        return (
            f"Only {told} of {len(found.identifiability.directions)} directions are told by the data. The offsets go "
            "together: single ones along the others are the prior's, and none of those is to be filed.",
        )
    return ()


def distance_words(error: AttitudeError) -> str:
    """How far an attitude error is from zero, in its own uncertainty."""
    return f"{error.mahalanobis:.1f} standard deviations ({MISSED})"
