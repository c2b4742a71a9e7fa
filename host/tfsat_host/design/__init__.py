"""Maneuver design: the closed loop of strokes that turns a robot farthest in a given time.

found = design(load_robot(), DesignSettings(time_limit_s=1.5))
found.optimum.alpha_deg, found.optimum.sequence, found.gap_deg
"""

from tfsat_host.design.maneuver_design import Candidate, Design, design
from tfsat_host.design.problem import DesignError, DesignSettings, Problem
from tfsat_host.design.swarm import Coefficient, SwarmSettings

__all__ = [
    "Candidate",
    "Coefficient",
    "Design",
    "DesignError",
    "DesignSettings",
    "Problem",
    "SwarmSettings",
    "design",
]
