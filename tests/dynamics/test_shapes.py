"""Every public function takes any batch shapes that broadcast, and gives what a loop over single samples gives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dynamics.random_robots import random_tree, write_robot_file
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import (
    Multibody,
    connection,
    joint_momentum,
    kinetic_energy_j,
    locked_inertia,
    path_rotation,
    poses,
    stroke_rotation,
)
from tfsat_host.dynamics.spatial_momentum import angular_momentum, inertia_and_joint_momentum
from tfsat_host.robot import load_robot

Shape = tuple[int, ...]
ARRAYS = ("mass_kg", "com_m", "inertia_kg_m2", "joint_axis", "joint_point_m")
PATH = [2, 0, 1, 0]


@pytest.fixture(scope="module")
def trees(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Multibody]:
    folder, rng = tmp_path_factory.mktemp("trees"), np.random.default_rng(3)
    return {
        n: Multibody.of(load_robot(write_robot_file(random_tree(rng, n), folder / f"{n}.toml")))
        for n in (1, 4)
    }


@st.composite
def broadcastable(draw: st.DrawFn, count: int) -> list[Shape]:
    full_shape = draw(st.lists(st.integers(0, 3), max_size=3))
    shapes = []
    for _ in range(count):
        suffix = full_shape[draw(st.integers(0, len(full_shape))) :]
        shapes.append(tuple(1 if draw(st.booleans()) else length for length in suffix))
    return shapes


def vary_body(body: Multibody, shapes: list[Shape], rng: np.random.Generator) -> Multibody:
    """Return the tree with arrays of these batch shapes, varied slightly from sample to sample."""
    arrays = {}
    for name, shape in zip(ARRAYS, shapes, strict=True):
        values = getattr(body, name)
        scale = 1.0 + 0.1 * rng.random(shape + (1,) * values.ndim)
        arrays[name] = np.broadcast_to(values, shape + values.shape) * (
            1.0 if name == "joint_axis" else scale
        )
    return body.replace(**arrays)


def single(body: Multibody, index: Shape, shape: Shape) -> Multibody:
    arrays = {}
    for name in ARRAYS:
        values, core = getattr(body, name), {"mass_kg": 1, "inertia_kg_m2": 3}.get(name, 2)
        arrays[name] = np.broadcast_to(values, shape + values.shape[values.ndim - core :])[index]
    return body.replace(**arrays)


def compare(
    function: Callable[..., FloatArray], body: Multibody, values: list[FloatArray], cores: list[int]
) -> None:
    batches = [v.shape[: v.ndim - core] for v, core in zip(values, cores, strict=True)]
    shape = np.broadcast_shapes(body.batch_shape, *batches)
    broadcast_values = [
        np.broadcast_to(v, shape + v.shape[v.ndim - core :]) for v, core in zip(values, cores, strict=True)
    ]
    batch_result = function(body, *values)
    assert batch_result.shape[: len(shape)] == shape
    for index in np.ndindex(*shape):
        alone = function(single(body, index, shape), *(v[index] for v in broadcast_values))
        assert batch_result[index].shape == alone.shape
        assert batch_result[index] == pytest.approx(alone, abs=1e-12)


@pytest.mark.parametrize("n", [1, 4])
@settings(max_examples=10, deadline=None, derandomize=True)
@given(shapes=broadcastable(8), seed=st.integers(0, 99))
def test_shapes_of_what_depends_on_the_pose(
    trees: dict[int, Multibody], n: int, shapes: list[Shape], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    body = vary_body(trees[n], shapes[:5], rng)
    angles, rates = (rng.normal(size=(*shape, n - 1)) for shape in shapes[5:7])
    for function in (locked_inertia, joint_momentum, connection):
        compare(function, body, [angles], [1])
    for part in (0, 1):
        compare(lambda b, a, part=part: poses(b, a)[part], body, [angles], [1])
    base_rate = rng.normal(size=(*shapes[7], 3))
    compare(kinetic_energy_j, body, [angles, rates, base_rate], [1, 1, 1])
    compare(angular_momentum, body, [angles, base_rate, rates], [1, 1, 1])
    inertia, of_joints = inertia_and_joint_momentum(body, angles)
    parts = (inertia @ base_rate[..., None])[..., 0] + (of_joints @ rates[..., None])[..., 0]
    assert angular_momentum(body, angles, base_rate, rates) == pytest.approx(parts, abs=1e-12)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(shapes=broadcastable(7), seed=st.integers(0, 99))
def test_shapes_of_strokes_and_paths(trees: dict[int, Multibody], shapes: list[Shape], seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = vary_body(trees[4], shapes[:5], rng)
    start, delta = rng.normal(size=(*shapes[5], 3)), rng.normal(size=shapes[6])
    deltas = rng.normal(size=(*shapes[6], len(PATH)))
    compare(lambda b, a, d: stroke_rotation(b, 1, a, d, steps=2), body, [start, np.asarray(delta)], [1, 0])
    compare(lambda b, s, d: path_rotation(b, PATH, d, start_rad=s, steps=2), body, [start, deltas], [1, 1])
    compare(lambda b, d: path_rotation(b, PATH, d, steps=2), body, [deltas], [1])
    compare(lambda b, d: path_rotation(b, [], d), body, [deltas[..., :0]], [1])
    batch_shape = np.broadcast_shapes(body.batch_shape, *shapes[5:])
    assert path_rotation(body, PATH, deltas, start_rad=start).shape == (*batch_shape, 4)


def test_what_fits_no_robot_is_refused(trees: dict[int, Multibody]) -> None:
    for joint in (-1, 3):
        with pytest.raises(ValueError, match="no joint"):
            stroke_rotation(trees[4], joint, np.zeros(3), np.array(1.0))
    with pytest.raises(ValueError, match="do not fit 2 strokes"):
        path_rotation(trees[4], [0, 1], np.zeros(3))
    with pytest.raises(ValueError, match="finite"):
        stroke_rotation(trees[4], 0, np.zeros(3), np.array(np.nan))
    with pytest.raises(ValueError, match="steps"):
        stroke_rotation(trees[4], 0, np.zeros(3), np.array(1e9))
