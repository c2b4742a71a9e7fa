"""The base's rate that the robot model leaves unexplained, and how errors of sensors and model move it; all linear.

What the fit of the model gave offsets, momentum and sensors' errors a share in is put back: the rows are those of the
robot as its file has it and of the sensors as they are certified.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples, derivatives, flown_of
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S
from tfsat_host.evaluation.motion.motion import SETTLED_S, Motion
from tfsat_host.evaluation.motion.rate_fusion import rates_by_angles
from tfsat_host.evaluation.motion.samples import Blocks, turned_from

BLOCK_RATE_STD_RAD_S = np.deg2rad(0.005)
"""Of a mean over 0.1 s by all gyros: frames that ring after a stroke."""
_MOMENTUM_STD_RAD_S = np.deg2rad(100.0)
_CARRIED = 3
"""Rounds for the errors that wrong angles make in rates, and these in angles; as in `motion/error_model.py`."""


@dataclass(frozen=True, eq=False)
class ModelRows:
    """3 k rows: three axes in each of k blocks.

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
        own = turned_from(t, direct[:, 3:])
        angles = own
        # Joint angles follow the rates and change them: the same fixed point as in the fusion.
        for _ in range(_CARRIED):
            angles = own + turned_from(t, by_angles[:, 3:] @ angles)
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
