"""All that a drop tells of its own errors, as one vector: what its sensors disagree about, what the model leaves.

An error of a gyro is in both, and is counted once. While the sensors contradict each other as they are certified,
nothing that a model makes of them means anything: the vector is then theirs alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.sensors.gyro import PARAMETERS
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import (
    MOMENTS,
    ByGyros,
    StatedErrors,
    axis_std_rad,
    by_calibrated_axes,
    lag_columns,
)
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples, derivatives, flown_of
from tfsat_host.evaluation.motion.error_model import carry_angles
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S
from tfsat_host.evaluation.motion.motion import SETTLED_S, Motion
from tfsat_host.evaluation.motion.rate_fusion import rates_by_angles
from tfsat_host.evaluation.motion.samples import Blocks, turned_from

_AS_CERTIFIED = np.zeros(PARAMETERS)


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
        # One batch: of each gyro its parameters, then the moments of its lag.
        each = PARAMETERS + MOMENTS
        changes = np.zeros((each * bodies, len(data.t_s), bodies, 3))
        for body, rates in enumerate(data.rates):
            own = changes[each * body : each * (body + 1), :, body]
            own[:PARAMETERS] = np.moveaxis(data.jacobian[:, body], 2, 0)
            own[PARAMETERS:] = lag_columns(data.t_s, rates)
        theirs = self.model.by_gyros(changes).reshape(-1, bodies, each)
        # The model's rows are of the fall: there errors of the whole drop and of the fall alone are one.
        errors, lag = theirs[..., :PARAMETERS], theirs[..., PARAMETERS:]
        parts = (errors, errors, lag)
        return ByGyros(*(np.concatenate(pair) for pair in zip(ours, parts, strict=True)))

    @cached_property
    def by_tilts(self) -> FloatArray:
        """(size, 6) by tilts of the joints' axes, rad, by which the gyros were calibrated, too."""
        # Exact axes have no tilt; the unit keeps the quotient finite.
        unit = axis_std_rad(self.data) or 1.0
        through_gyros = by_calibrated_axes(self.data, self.stated.by_gyros.parameters)
        of_sensors = self.data.tilt_jacobian + through_gyros / unit
        if self.model is None:
            return of_sensors
        prior = self.model.motion.fusion.prior
        has_tilt = prior.tilt > 0.0
        of_model = self.model.by_errors[:, prior.tilts] / np.where(has_tilt, prior.tilt, 1.0)
        return self.stack(of_sensors, has_tilt * of_model)

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


BLOCK_RATE_STD_RAD_S = np.deg2rad(0.005)
"""Of a mean over 0.1 s by all gyros: frames that ring after a stroke."""
_MOMENTUM_STD_RAD_S = np.deg2rad(100.0)


@dataclass(frozen=True, eq=False)
class ModelRows:
    """The base's rate that the robot model leaves unexplained, and how errors of sensors and model move it; all linear.

    What the fit of the model gave offsets, momentum and sensors' errors a share in is put back: the rows are those of
    the robot as its file has it and of the sensors as they are certified. 3 k rows: three axes in each of k blocks.

    Attributes:
        motion: Of the drop.
        fit: Of the model to it.
        flown: What drives it, the sensors' errors taken off as the fit found them.
    """

    motion: Motion
    fit: ModelFit
    flown: FallSamples

    @classmethod
    def of(cls, motion: Motion, fit: ModelFit) -> ModelRows:
        """Build the model's rows of one drop."""
        return cls(motion, fit, flown_of(motion).correct(fit.errors))

    @cached_property
    def t_s(self) -> FloatArray:
        """(k,) where each block begins."""
        return self.flown.t_s[self._blocks.edges]

    @cached_property
    def residual(self) -> FloatArray:
        """(3 k,) without offsets and without errors of the sensors."""
        fit, solved, root = self.fit, self.motion.solved, self._root
        # Put back what the fusion and the fit took off, both in the fit's independent errors.
        total_errors = np.linalg.solve(root, solved.errors) + fit.errors
        linearization = fit.derivatives
        return self._rows(
            linearization.residual_rad_s
            - linearization.by_errors @ total_errors
            - linearization.by_offsets @ fit.values
        )

    @cached_property
    def noise(self) -> FloatArray:
        """(3 k, 3 k)."""
        # A mean's noise falls with the number of samples; that of ringing frames does not.
        per_sample = self._blocks.mean(self.fit.derivatives.noise) / self._blocks.counts[:, None, None]
        each = per_sample + BLOCK_RATE_STD_RAD_S**2 * np.eye(3)
        # Block diagonal: (k, 3, k, 3) folded into (3 k, 3 k).
        return np.asarray(
            np.einsum("kij,kl->kilj", each, np.eye(len(each))).reshape(3 * len(each), 3 * len(each))
        )

    @cached_property
    def by_offsets(self) -> FloatArray:
        """(3 k, p) by the model's offsets in their prior's standard deviations."""
        return self._rows(self.fit.derivatives.by_offsets) * self.fit.offsets.prior_std

    @cached_property
    def by_momentum(self) -> FloatArray:
        """(k, 3, 3) by the momentum, whose unit turns the base by 100 deg/s at most."""
        by_momentum = self._blocks.mean(self.fit.derivatives.by_momentum)
        return np.asarray(_MOMENTUM_STD_RAD_S / np.abs(by_momentum).max() * by_momentum)

    @cached_property
    def by_errors(self) -> FloatArray:
        """(3 k, r) by the sensors' errors before the fusion, see `motion/error_model.py`."""
        return self._rows(self.fit.derivatives.by_errors) @ np.linalg.inv(self._root)

    def by_gyros(self, rates_rad_s: FloatArray) -> FloatArray:
        """(3 k, q) by what the gyros show more, (q, n, 4, 3) body axes, at the n samples of the fall."""
        fused, fall = self.motion.fused, self.motion.samples.fall
        n, q = len(rates_rad_s[0]), len(rates_rad_s)
        # What gyros show more moves base and joint rates through the fusion's gains, (n, 6, q).
        direct = fused.gains[fall] @ np.moveaxis(rates_rad_s, 0, -1).reshape(n, -1, q)
        by_angles, t = self._rates_by_angles[fall], self.motion.t_s[fall]
        # Joint angles follow the rates and change them: the same fixed point as in the fusion.
        angles = carry_angles(t, turned_from(t, direct[:, 3:]), by_angles)
        rates, settled = direct + by_angles @ angles, t >= SETTLED_S
        # The derivatives are linear in the errors' columns: put these in their place.
        kinematics = replace(
            self.flown,
            rate_errors=rates[settled],
            angle_errors=angles[settled],
            tilt_errors=np.zeros((*self.flown.tilt_rad.shape, q)),
        )
        fit = self.fit
        return self._rows(derivatives(fit.offsets, fit.values, kinematics, fit.momentum_kg_m2_s).by_errors)

    @cached_property
    def _rates_by_angles(self) -> FloatArray:
        solved, fusion = self.motion.solved, self.motion.fusion
        body = fusion.body.tilt_hinges(fusion.prior.tilt_of(solved.errors))
        return rates_by_angles(body, solved.angles_rad, solved.fused, self.motion.fusion.noise)[0]

    @cached_property
    def _root(self) -> FloatArray:
        return root_of(self.motion.solved.jacobians.covariance)

    @cached_property
    def _blocks(self) -> Blocks:
        return Blocks.of(self.flown.t_s, BLOCK_S)

    def _rows(self, values: FloatArray) -> FloatArray:
        """(3 k, ...) means over blocks of values (m, 3, ...)."""
        return np.asarray(self._blocks.mean(values).reshape(3 * len(self._blocks.edges), *values.shape[2:]))
