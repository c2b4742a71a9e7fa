"""Smooth joint histories in closed form, with their derivatives.

Times may have any shape (...); what comes back is (..., joints).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import ArrayLike

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import JointHistory


class ClosedForm(Protocol):
    """What simulators are driven by."""

    def angles(self, t: ArrayLike) -> FloatArray: ...

    def rates(self, t: ArrayLike) -> FloatArray: ...

    def accelerations(self, t: ArrayLike) -> FloatArray: ...


class SineHistory:
    """Every joint swings by a sum of sines of its own, within `reach_rad`, from the first instant."""

    def __init__(
        self, rng: np.random.Generator, joints: int, *, terms: int = 1, reach_rad: float = 1.0
    ) -> None:
        self.amplitude = rng.uniform(0.3, 1.0, (terms, joints)) * reach_rad / terms
        self.omega = rng.uniform(2.0, 8.0, (terms, joints))
        self.phase = rng.uniform(0.0, 6.0, (terms, joints))

    def _phase(self, t: ArrayLike) -> FloatArray:
        return np.asarray(t, dtype=np.float64)[..., None, None] * self.omega + self.phase

    def angles(self, t: ArrayLike) -> FloatArray:
        return np.asarray((self.amplitude * np.sin(self._phase(t))).sum(axis=-2))

    def rates(self, t: ArrayLike) -> FloatArray:
        return np.asarray((self.amplitude * self.omega * np.cos(self._phase(t))).sum(axis=-2))

    def accelerations(self, t: ArrayLike) -> FloatArray:
        return np.asarray((-self.amplitude * self.omega**2 * np.sin(self._phase(t))).sum(axis=-2))

    def __call__(self, t: float) -> tuple[FloatArray, FloatArray]:
        return self.angles(t), self.rates(t)

    def all(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.angles(t), self.rates(t), self.accelerations(t)


class PolynomialHistory:
    """Every joint follows a random polynomial of degree 6 within `reach_rad`, in motion from the first instant."""

    def __init__(
        self, rng: np.random.Generator, joints: int, *, duration_s: float, reach_rad: float = np.pi / 2
    ) -> None:
        self.duration_s = duration_s
        weights = rng.normal(size=(joints, 7)) / np.arange(1, 8)
        # Every joint stays within its reach, whatever its weights are.
        weights *= reach_rad * rng.uniform(0.5, 1.0, (joints, 1)) / np.abs(weights).sum(axis=1, keepdims=True)
        self._series = [Chebyshev(row, domain=[0.0, duration_s]) for row in weights]

    def angles(self, t: ArrayLike) -> FloatArray:
        return self._evaluate_series(t, 0)

    def rates(self, t: ArrayLike) -> FloatArray:
        return self._evaluate_series(t, 1)

    def accelerations(self, t: ArrayLike) -> FloatArray:
        return self._evaluate_series(t, 2)

    def _evaluate_series(self, t: ArrayLike, order: int) -> FloatArray:
        at = np.asarray(t, dtype=np.float64)
        return np.stack([np.asarray(series.deriv(order)(at)) for series in self._series], axis=-1)

    def __call__(self, t: float) -> tuple[FloatArray, FloatArray]:
        return self.angles(t), self.rates(t)

    def joint_history(self) -> JointHistory:
        """Return the history as one polynomial piece, which leaves the choice of steps to the integration."""
        # Powers from the highest down, as JointHistory keeps them.
        powers = [series.convert(kind=Polynomial).coef[::-1] for series in self._series]
        return JointHistory(
            np.array([0.0, self.duration_s]), np.asarray(np.stack(powers, axis=-1)[:, None], dtype=np.float64)
        )
