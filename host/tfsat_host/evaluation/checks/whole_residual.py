"""All that a drop tells of its own errors, as one vector: what its sensors disagree about, what the model leaves.

An error of a gyro is in both, and is counted once. While the sensors contradict each other as they are certified,
nothing that a model makes of them means anything: the vector is then theirs alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.model_rows import ModelRows
from tfsat_host.evaluation.checks.stated_errors import ByGyros, StatedErrors, axis_std_rad
from tfsat_host.evaluation.motion.gyro_signal import derivative

_AS_CERTIFIED = np.zeros(9)


@dataclass(frozen=True, eq=False)
class WholeResidual:
    """`data.size` rows of the sensors, then those of the model.

    Attributes:
        data: What the sensors disagree about.
        stated: By which errors.
        model: What the model leaves over; None: not asked.
    """

    data: Consistency
    stated: StatedErrors
    model: ModelRows | None

    @cached_property
    def residual(self) -> FloatArray:
        """(size,)."""
        return np.concatenate([self.data.residual, self.model.residual if self.model else []])

    @cached_property
    def known(self) -> BoolArray:
        """(size,) rows that rest on enough readings."""
        return np.concatenate([self.stated.known, np.ones(self._model_size, bool)])

    @property
    def size(self) -> int:
        return self.data.size + self._model_size

    @property
    def _model_size(self) -> int:
        return len(self.model.residual) if self.model else 0

    def stack(self, of_sensors: FloatArray | None, of_model: FloatArray | None = None) -> FloatArray:
        """(size, q) of columns of either part; None: zeros."""
        q = next(part.shape[1] for part in (of_sensors, of_model) if part is not None)
        out = np.zeros((self.size, q))
        if of_sensors is not None:
            out[: self.data.size] = of_sensors
        if of_model is not None:
            out[self.data.size :] = of_model
        return out

    def with_sensors(self, residual: FloatArray) -> FloatArray:
        """(size,) with another residual (data.size,) of the sensors."""
        return np.concatenate([residual, self.residual[self.data.size :]])

    def by_gyro(self, body: int, rates_rad_s: FloatArray) -> FloatArray:
        """(size, q) by what one gyro shows more in the fall, (q, n, 3) body axes."""
        of_sensors = self.data.rate_part(body, rates_rad_s, self.data.rotations).T
        if self.model is None:
            return of_sensors
        # Through the fusion, which takes all gyros: the others show nothing more.
        every = np.zeros((*rates_rad_s.shape[:2], self.data.bodies, 3))
        every[:, :, body] = rates_rad_s
        return self.stack(of_sensors, self.model.by_gyros(every))

    @cached_property
    def by_gyros(self) -> ByGyros:
        """All rows."""
        ours = self.stated.by_gyros
        if self.model is None:
            return ours
        data, bodies = self.data, self.data.bodies
        # Eleven columns a gyro in one batch: nine parameters, delay and second moment of its lag.
        changes = np.zeros((11 * bodies, len(data.t_s), bodies, 3))
        for body, rates in enumerate(data.rates):
            own = changes[11 * body : 11 * (body + 1), :, body]
            own[:9] = np.moveaxis(data.jacobian[:, body], 2, 0)
            own[9] = derivative(data.t_s, rates)
            own[10] = derivative(data.t_s, own[9])
        theirs = self.model.by_gyros(changes).reshape(-1, bodies, 11)
        # The model's rows are of the fall: there errors of the whole drop and of the fall alone are one.
        parts = (theirs[..., :9], theirs[..., :9], theirs[..., 9], theirs[..., 10])
        return ByGyros(*(np.concatenate(pair) for pair in zip(ours, parts, strict=True)))

    @cached_property
    def by_tilts(self) -> FloatArray:
        """(size, 6) by tilts of the joints' axes, rad."""
        if self.model is None:
            return self.data.tilt_jacobian
        prior = self.model.motion.fusion.prior
        has_tilt = prior.tilt > 0.0
        # Exact tilts have no column; the unit keeps the quotient finite.
        unit = np.where(has_tilt, prior.tilt, 1.0)
        return self.stack(self.data.tilt_jacobian, has_tilt * self.model.by_errors[:, prior.tilts] / unit)

    @cached_property
    def whitening(self) -> FloatArray:
        """(k, k) makes independent numbers of variance one of the k known rows, if all is as filed and certified."""
        stated, model = self.stated, self.model
        # As certified: without the floors that the single checks grant.
        parts = [
            self.by_gyros.as_stated(self.data, _AS_CERTIFIED),
            self.by_tilts * axis_std_rad(self.data),
            self.stack(stated.by_sensors),
            self.stack(stated.by_fallback),
        ]
        if model is None:
            parts.append(stated.by_starts * np.pi)
        else:
            prior, by_errors = model.motion.fusion.prior, model.by_errors
            others = np.concatenate(
                [by_errors[:, prior.starts.stop :], model.by_offsets, model.by_momentum.reshape(-1, 3)],
                axis=1,
            )
            parts += [
                # A start is in the rows of sensors and model, and is counted once.
                self.stack(stated.by_starts * prior.start, by_errors[:, prior.starts]),
                self.stack(None, others),
            ]
        design = np.concatenate(parts, axis=1)
        covariance = design @ design.T
        sensors = slice(0, self.data.size)
        covariance[sensors, sensors] += stated.noise
        if model is not None:
            covariance[self.data.size :, self.data.size :] += model.noise
        # Inverse Cholesky factor of the known rows; the others are integrated out.
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance[np.ix_(self.known, self.known)])))

    def whiten(self, rows: FloatArray) -> FloatArray:
        """(k, ...) of vectors (size, ...)."""
        return np.asarray(self.whitening @ rows[self.known])
