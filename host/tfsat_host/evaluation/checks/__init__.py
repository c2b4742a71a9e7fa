"""Checks of a drop's data that need no truth: what the sensors say of each other, of gravity and of momentum."""

from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.checks.drop_checks import checks_of

__all__ = ["Check", "checks_of"]
