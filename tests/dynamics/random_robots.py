"""Random trees of bodies and hinges, as arrays and as the robot files that a user would write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel, load_robot

_SERVO = """
[joint.servo]
average_rate_deg_s = 170.0
max_rate_deg_s = 200.0
acceleration_deg_s2 = 4000.0
start_deg = 0.0
pulse_range_us = [500.0, 2500.0]
reference = { pulse_us = 1500.0, angle_deg = 0.0 }
pulse_us_per_deg = 10.0
"""


def random_tree(rng: np.random.Generator, n: int, *, chain: bool = False) -> Robot:
    """n bodies; a hinge counts in either direction, and any body may be the base."""
    # Half extents of a box, so that its inertia is that of a real body.
    half = rng.uniform(0.02, 0.1, (n, 3))
    mass = rng.uniform(0.2, 1.5, n)
    inertia = np.empty((n, 3, 3))
    for i in range(n):
        box = mass[i] / 3 * np.diag(half[i] @ half[i] - half[i] ** 2)
        turn = Rotation.random(random_state=rng).as_matrix()
        inertia[i] = turn @ box @ turn.T
    axis = rng.normal(size=(n - 1, 3))
    parent = [int(rng.integers(0, j + 1)) for j in range(n - 1)]
    # A chain in place of a random tree.
    if chain:
        parent = list(range(n - 1))
    flipped = rng.random(n - 1) < 0.5
    return Robot(
        base=int(rng.integers(0, n)),
        mass=mass,
        com=rng.uniform(-0.05, 0.05, (n, 3)),
        inertia=inertia,
        origin=rng.uniform(-0.2, 0.2, (n, 3)),
        inner=[j + 1 if f else parent[j] for j, f in enumerate(flipped)],
        outer=[parent[j] if f else j + 1 for j, f in enumerate(flipped)],
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        point=rng.uniform(-0.2, 0.2, (n - 1, 3)),
    )


def random_robot(folder: Path, seed: int, n: int, *, chain: bool = False) -> RobotModel:
    """Draw the first random tree of a seed and load it as a robot through a file."""
    tree = random_tree(np.random.default_rng(seed), n, chain=chain)
    return load_robot(write_robot_file(tree, folder / f"robot_{seed}_{n}.toml"))


def write_robot_file(robot: Robot, path: Path) -> Path:
    """`robot` in the format of robots/drop_tower.toml; every hinge from -90 to 90 deg."""
    parts = [
        f'format = 1\nname = "random robot"\nbase = "body {robot.base}"\ninertia_off_diagonals = "tensor"'
    ]
    parts += [_body(robot, i) for i in range(len(robot.mass))]
    parts += [_joint(robot, j) for j in range(len(robot.inner))]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    return path


def _body(robot: Robot, i: int) -> str:
    g_m2 = (1e3 * robot.inertia[i]).tolist()
    # The upper triangle of the inertia tensor, as the file has it.
    entries = ", ".join(f"{'xyz'[a]}{'xyz'[b]} = {g_m2[a][b]!r}" for a in range(3) for b in range(a, 3))
    return (
        f'[[body]]\nname = "body {i}"\nmass_kg = {float(robot.mass[i])!r}\n'
        f"origin_mm = {_list(1e3 * robot.origin[i])}\ncom_mm = {_list(1e3 * robot.com[i])}\n"
        f"inertia_g_m2 = {{ {entries} }}"
    )


def _joint(robot: Robot, j: int) -> str:
    return (
        f'[[joint]]\nname = "joint {j}"\ninner = "body {robot.inner[j]}"\nouter = "body {robot.outer[j]}"\n'
        f"axis = {_list(robot.axis[j])}\npoint_mm = {_list(1e3 * robot.point[j])}\n"
        f"limits_deg = [-90.0, 90.0]\n{_SERVO}"
    )


def _list(values: FloatArray) -> str:
    return str(values.tolist())
