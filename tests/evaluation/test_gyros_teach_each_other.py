"""Four gyros on one robot: what they teach each other, and what is said when they contradict each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation import drops
from tests.evaluation.corrupted import failed, gyro_plus
from tests.evaluation.drops import STDS, assert_angle_holds, certificate, flown, moved, turn_off
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.checks import checks_of
from tfsat_host.evaluation.motion import sensor_fusion
from tfsat_host.evaluation.motion.motion import Motion, notes_of

UNKNOWN = 0.03
"""Scale factors of a chip that nobody calibrated (PS-MPU-6000A rev. 3.4, section 6.1)."""
DROPS = pytest.mark.parametrize(("seed", "body"), [(1, 1), (1, 2), (2, 3)])


def with_unknown_scale(calibration: Calibration, body: int) -> Calibration:
    """The gyro of one body has its scale factors as far off as such a chip's are, and says so."""
    gyro = calibration.gyros[body - 1]
    covariance = gyro.covariance.copy()
    covariance[6:, 6:] = UNKNOWN**2 * np.eye(3)
    off = UNKNOWN * np.random.default_rng(body).choice([-1.0, 1.0], 3)
    unknown = replace(gyro, scale=gyro.scale + off, covariance=covariance)
    gyros = tuple(unknown if one.body == body else one for one in calibration.gyros)
    return replace(calibration, gyros=gyros)


def gyro_learnt(found: Motion, body: int) -> tuple[FloatArray, FloatArray]:
    """(9,) what was taken off the parameters of a gyro, and (9,) how far they may still be off."""
    spread, solved = found.fusion.spread, found.solved
    root = spread.gyro_root[9 * (body - 1) : 9 * body]
    covariance = root @ solved.slow.covariance[spread.gyro, spread.gyro] @ root.T
    return spread.parameters_of(solved.errors)[body - 1], np.sqrt(np.diag(covariance))


@DROPS
def test_neighbours_teach_a_gyro_the_scale_factors_that_nobody_knows(
    seed: int, body: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = flown(seed)
    used = with_unknown_scale(certificate(one, seed), body)
    believed, true = used.gyros[body - 1].scale, one.imperfections.gyro_scale[body - 1]

    def left(found: Motion) -> tuple[FloatArray, FloatArray]:
        learnt, std = gyro_learnt(found, body)
        return believed + learnt[6:] - true, std[6:]

    found = moved(one.log, used, one.model)
    with monkeypatch.context() as patched:
        patched.setattr(
            sensor_fusion,
            "information_by_neighbours",
            lambda _t, _f, _l, _v, errors, _k: (np.zeros((len(errors), len(errors))), np.zeros(len(errors))),
        )
        by_angles = moved(one.log, used, one.model)
    assert not found.contradicted
    error, std = left(found)
    assert (np.abs(error) < STDS * std).all()
    assert std.max() < 1e-3, "of three per cent"
    error_by_angles, std_by_angles = left(by_angles)
    assert (np.abs(error_by_angles) < STDS * std_by_angles).all()
    assert np.linalg.norm(error) < 0.5 * np.linalg.norm(error_by_angles)
    assert np.linalg.norm(std) < 0.5 * np.linalg.norm(std_by_angles)
    turned, turned_by_angles = (turn_off(one, motion, body) for motion in (found, by_angles))
    assert turned.stds < STDS
    assert turned.std_deg < min(turned_by_angles.std_deg, 0.1)
    for joint in (1, 2, 3):
        assert_angle_holds(one, found, joint, widest_deg=0.05)


@DROPS
def test_gyros_that_contradict_each_other_are_named_and_none_corrects_another(seed: int, body: int) -> None:
    """From the release on one shows 2 deg/s too much about each axis: far more than losing its weight does."""
    one = flown(seed)
    used = certificate(one, seed)
    log = gyro_plus(one.log, body, np.outer(one.log.t_s > 0.0, (2.0, 2.0, 2.0)))
    found = moved(log, used, one.model)
    assert found.contradicted
    assert any(note.startswith("The sensors would have the gyros farther off") for note in notes_of(found))
    for other in (1, 2, 3, 4):
        learnt, std = gyro_learnt(found, other)
        assert not learnt.any()
        assert std == pytest.approx(np.sqrt(np.diag(found.samples.parameter_covariance[other - 1])))
        if other != body:
            off = turn_off(one, found, other)
            assert off.stds < STDS
            assert off.std_deg < 0.4
    checks = failed(checks_of(found, None, log, used, one.model))
    pairs = {f"gyros of bodies {inner} and {inner + 1}" for inner in (body - 1, body) if 1 <= inner <= 3}
    assert pairs <= checks.keys()
    assert all(
        (checks[pair].cause or "").startswith(f"gyro of body {body}: its bias jumped") for pair in pairs
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_healthy_gyros_do_not(seed: int) -> None:
    found = drops.motion(seed)
    assert not found.contradicted
    assert notes_of(found) == []
