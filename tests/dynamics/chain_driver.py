"""Talks to the chain probe: a robot, a list of commands, the motion that comes back."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel


@dataclass(frozen=True)
class Robot:
    """The numbers that the chain takes, as arrays over bodies and joints (SI)."""

    base: int
    mass: FloatArray
    com: FloatArray
    inertia: FloatArray
    origin: FloatArray
    inner: Sequence[int]
    outer: Sequence[int]
    axis: FloatArray
    point: FloatArray

    @classmethod
    def of(cls, model: RobotModel) -> Robot:
        return cls(
            base=model.base,
            mass=model.mass_kg,
            com=model.com_m,
            inertia=model.inertia_kg_m2,
            origin=model.origin_m,
            inner=model.joint_inner.tolist(),
            outer=model.joint_outer.tolist(),
            axis=model.joint_axis,
            point=model.joint_point_m,
        )


@dataclass(frozen=True)
class Shown:
    """One line of the probe."""

    quaternion: FloatArray
    rate: FloatArray
    angular_acceleration: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    specific_force: FloatArray
    momentum: FloatArray
    energy: float
    angles: FloatArray


def _numbers(values: ArrayLike) -> str:
    return " ".join(repr(float(v)) for v in np.ravel(values))


@dataclass
class Script:
    """Commands for the probe, in order."""

    robot: Robot
    lines: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        r = self.robot
        self.lines.append(f"robot {len(r.mass)} {r.base}")
        for i in range(len(r.mass)):
            # Bodies first, joints second: the probe reads them in this order.
            self.lines.append(_numbers([r.mass[i], *r.com[i], *r.inertia[i].ravel(), *r.origin[i]]))
        for j in range(len(r.inner)):
            self.lines.append(f"{r.inner[j]} {r.outer[j]} {_numbers([*r.axis[j], *r.point[j]])}")

    def say(self, word: str, *values: ArrayLike) -> None:
        self.lines.append(f"{word} {' '.join(map(_numbers, values))}")

    def hold(self, *bodies: int) -> None:
        # A bit for each body: the probe takes a mask.
        self.lines.append(f"hold {sum(1 << body for body in bodies)}")

    def release(self, rate: ArrayLike = (0, 0, 0), velocity: ArrayLike = (0, 0, 0)) -> None:
        self.say("release", rate, velocity)

    def step(self, dt_s: float, angle: ArrayLike, rate: ArrayLike, acceleration: ArrayLike) -> None:
        self.say("step", dt_s, np.column_stack([angle, rate, acceleration]))

    def show(self, body: int, position: ArrayLike = (0, 0, 0)) -> None:
        self.lines.append(f"show {body} {_numbers(position)}")

    def run(self, probe: Path) -> list[Shown]:
        process = subprocess.run(
            [probe], input="\n".join(self.lines), capture_output=True, text=True, check=False
        )
        assert process.returncode == 0, process.stderr
        return [_parse_line(line) for line in process.stdout.splitlines()]


def _parse_line(line: str) -> Shown:
    v = np.array(line.split(), dtype=np.float64)
    return Shown(
        v[0:4], v[4:7], v[7:10], v[10:13], v[13:16], v[16:19], v[19:22], v[22:25], float(v[25]), v[26:]
    )
