"""Misalignment and scale against imucal, an independent implementation of the Ferraris calibration, on its own data.

imucal (MaD Lab, Erlangen; MIT) solves for nine numbers from three integrals; ours fits a rotation, three scale factors
and three skews to directions and lengths. The same raw arrays go into both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from imucal import FerrarisCalibration, FerrarisSignalRegions
from scipy.spatial.transform import Rotation

from tests.calibration.ferraris_bench import GRAVITY_M_S2, ROUNDS, TURN_RAD, Ferraris, Imu
from tests.calibration.synthetic_gyro import RATE_HZ
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.misalignment import solve_misalignment, wahba
from tfsat_host.calibration.response import Response, direction, length_between_rests, with_length
from tfsat_host.calibration.sensors.gyro import response_matrix
from tfsat_host.calibration.statistics import mean_and_covariance

# Four seeds in `make test`, twenty in `make prove`.
SEEDS = [*range(4), *(pytest.param(seed, marks=pytest.mark.prove) for seed in range(4, 20))]
# Asked of ours against imucal, of ours against the truth and of imucal against it.
ROTATION_DEG = 0.02
SCALE = 0.0005


@dataclass(frozen=True, eq=False)
class Found:
    """What a calibration says of a gyro; `matrix` (3, 3) leads from readings free of bias to body rates."""

    bias_rad_s: FloatArray
    scale: FloatArray
    rotation: FloatArray
    matrix: FloatArray

    def rates(self, reads_rad_s: FloatArray) -> FloatArray:
        """(n, 3) body rates from readings (n, 3)."""
        return np.asarray((reads_rad_s - self.bias_rad_s) @ self.matrix.T)


def by_imucal(data: Ferraris) -> Found:
    regions: dict[str, FloatArray] = {}
    for name, up, down, turns in zip("xyz", data.up, data.down, data.turns, strict=True):
        regions |= {f"gyr_{name}_p": np.degrees(up[0]), f"acc_{name}_p": up[1]}
        regions |= {f"gyr_{name}_a": np.degrees(down[0]), f"acc_{name}_a": down[1]}
        regions[f"gyr_{name}_rot"] = np.degrees(turns.forward(turns.rate_rad_s))
        regions[f"acc_{name}_rot"] = turns.forward(turns.accel_m_s2)
    # imucal wants the whole angle of the positive turns.
    method = FerrarisCalibration(grav=GRAVITY_M_S2, expected_angle=ROUNDS * np.degrees(TURN_RAD))
    info = method.compute(FerrarisSignalRegions(**regions), RATE_HZ, "m/s^2", "deg/s")
    # The nearest rotation to its matrix, by SVD.
    left_vectors, _, right = np.linalg.svd(info.R_g)  # its rows are of length 1 but not quite orthogonal
    return Found(
        np.radians(info.b_g), np.diag(info.K_g), (left_vectors @ right).T, np.linalg.inv(info.K_g @ info.R_g)
    )


def by_ours(data: Ferraris, *, from_one_turn: bool = False) -> Found:
    # The rests of all six sides: bias from a minute of data.
    still = np.concatenate([rates for rates, _ in (*data.up, *data.down)])
    bias, covariance = mean_and_covariance(still)
    responses = []
    for axis, turns in zip(np.eye(3), data.turns, strict=True):
        rates = turns.rate_rad_s - bias
        rate = np.gradient(turns.angle_rad, 1.0 / RATE_HZ)
        response = direction(rates, axis, rate)
        t_s = np.arange(len(rates)) / RATE_HZ
        if from_one_turn:
            responses.append(one_turn(response, t_s, rates, turns.rests, covariance))
            continue
        angles = np.array([turns.angle_rad[rest].mean() for rest in turns.rests])
        length, std = length_between_rests(t_s, rates @ response.reading, turns.rests, angles)
        # Direction and length are fitted apart: the direction from all motion, the length between rests.
        responses.append(with_length(response, length, std))
    mounting = solve_misalignment(responses, wahba(responses))
    to_body = mounting.rotation @ np.linalg.inv(response_matrix(mounting.scale, mounting.skew))
    return Found(bias, mounting.scale, mounting.rotation, to_body)


def one_turn(
    response: Response, t_s: FloatArray, rates: FloatArray, rests: list[slice], bias_covariance: FloatArray
) -> Response:
    """Measure the response by its definition: the integral of the reading over one turn, per radian."""
    # One turn by definition: no fit between reading and angle.
    first, last = (rest.start for rest in rests[:2])
    turned = np.asarray(np.trapezoid(rates[first:last], t_s[first:last], axis=0))
    # The bias's uncertainty over the turn's duration goes into the length.
    spread = (t_s[last] - t_s[first]) / TURN_RAD
    return Response(
        response.axis_body, turned / TURN_RAD, response.covariance + spread**2 * bias_covariance, True
    )


@cache
def case(seed: int) -> tuple[Imu, Ferraris]:
    rng = np.random.default_rng(seed)
    imu = Imu.draw_random(rng)
    return imu, imu.calibration_data(rng)


def apart_deg(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees(Rotation.from_matrix(a.T @ b).magnitude()))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("from_one_turn", [False, True], ids=["three_turns_and_back", "one_turn"])
def test_rotation_and_scale_agree_with_imucal_and_with_the_truth(seed: int, from_one_turn: bool) -> None:
    imu, data = case(seed)
    theirs, ours = by_imucal(data), by_ours(data, from_one_turn=from_one_turn)
    for rotation, other in ((ours.rotation, theirs.rotation), (ours.rotation, imu.gyro.mounting)):
        assert apart_deg(rotation, other) < ROTATION_DEG
    assert ours.scale == pytest.approx(theirs.scale, rel=SCALE)
    assert ours.scale == pytest.approx(imu.gyro.scale, rel=SCALE)
    assert np.degrees(ours.bias_rad_s) == pytest.approx(np.degrees(theirs.bias_rad_s), abs=0.001)
    # Truth only to 0.02 deg/s: white noise over a minute of rest.
    assert np.degrees(ours.bias_rad_s) == pytest.approx(np.degrees(imu.gyro.bias_rad_s), abs=0.02)
    # imucal, too, is right: an agreement of two that are wrong would say nothing.
    assert apart_deg(theirs.rotation, imu.gyro.mounting) < ROTATION_DEG
    assert theirs.scale == pytest.approx(imu.gyro.scale, rel=SCALE)


@pytest.mark.parametrize("seed", SEEDS)
def test_both_make_the_same_body_rates_of_another_motion(seed: int) -> None:
    imu, data = case(seed)
    t_s = np.arange(int(4 * RATE_HZ)) / RATE_HZ
    frequencies_hz = np.array([0.3, 0.7, 0.5])
    true = np.radians([150.0, 90.0, 60.0]) * np.sin(2.0 * np.pi * frequencies_hz * t_s[:, None])
    reads = imu.gyro.bias_rad_s + (true @ imu.gyro.mounting) @ imu.gyro.response
    ours, theirs = by_ours(data).rates(reads), by_imucal(data).rates(reads)
    # What SCALE and ROTATION_DEG allow at the fastest rate.
    allowed_rad_s = (SCALE + np.radians(ROTATION_DEG)) * np.abs(true).max()
    assert np.abs(ours - theirs).max() < allowed_rad_s
    assert np.abs(ours - true).max() < allowed_rad_s + np.radians(0.02)


def test_an_axis_that_is_askew_or_turned_too_far_parts_the_two() -> None:
    imu, data = case(0)
    x, y, z = data.turns
    theirs, bias = by_imucal(data), imu.gyro.bias_rad_s
    # The gyro's z turns were recorded about a tilted axis: one tenth of a degree shows.
    tilt = Rotation.from_rotvec(np.radians(0.1) * imu.gyro.mounting[0])  # about the body's x
    askew = replace(z, rate_rad_s=bias + tilt.apply(z.rate_rad_s - bias))
    # The box turned 0.2 % farther than it was told.
    farther = replace(z, angle_rad=1.002 * z.angle_rad)
    tilted, shortened = (by_ours(replace(data, turns=(x, y, wrong))) for wrong in (askew, farther))
    assert apart_deg(tilted.rotation, theirs.rotation) > ROTATION_DEG
    assert shortened.scale != pytest.approx(theirs.scale, rel=SCALE)
