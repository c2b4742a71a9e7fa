"""From a robot file to a `RobotModel`: units converted, every entry checked.

The file's format is explained in `docs/robot-files.md`.
"""

from __future__ import annotations

import math
from pathlib import Path

from tfsat_host.config import Table, read_config
from tfsat_host.robot import joints, sensors
from tfsat_host.robot.bodies import BODY, inertia_kg_m2, shape_m
from tfsat_host.robot.model import RobotModel, Uncertainty, frozen, frozen_indices
from tfsat_host.robot.path import ROBOT_FILE, find_robot
from tfsat_host.robot.tree import check_tree, unique_names

_ROBOT = "format name source base inertia_off_diagonals uncertainty body joint imu angle_sensor"
_SHARES = ("mass_relative", "inertia_relative", "stroke_relative", "servo_speed_relative")
_ERRORS = ("com_mm", "joint_point_mm", "joint_axis_deg", "stroke_deg")
# Five standard deviations below the figure, something must be left of a mass, an inertia or a rate.
_GREATEST_SHARE = 0.2


def load_robot(name_or_path: Path | str | None = None) -> RobotModel:
    """Read and check a robot file, named as `find_robot` takes it; None is the drop tower robot.

    Raises:
        RobotFileError: the file cannot be read, is not TOML or does not describe a robot. The message
            names file, line and entry, and how to correct it.
    """
    file = find_robot(name_or_path)
    return _robot(file, read_config(file, ROBOT_FILE))


def _robot(file: Path, top: Table) -> RobotModel:
    top.only(_ROBOT)
    body, joint = top.tables("body", BODY), top.tables("joint", joints.JOINT)
    if not body:
        top.fail("body", "there is no body", "Describe each body below its own line `[[body]]`.")
    negated = top.choice("inertia_off_diagonals", ("products", "tensor")) == "products"
    body_names = unique_names(body)
    joint_names = unique_names(joint)
    inner = frozen_indices([body_names.index(j.choice("inner", body_names)) for j in joint])
    outer = frozen_indices([body_names.index(j.choice("outer", body_names)) for j in joint])
    limits = [joints.limits_rad(j) for j in joint]
    robot = RobotModel(
        path=file,
        name=top.text("name"),
        source=top.text("source", ""),
        base=body_names.index(top.choice("base", body_names)),
        body_names=body_names,
        mass_kg=frozen([b.number("mass_kg", above=0) for b in body], -1),
        origin_m=frozen([b.array("origin_mm", 3) * 1e-3 for b in body], -1, 3),
        com_m=frozen([b.array("com_mm", 3) * 1e-3 for b in body], -1, 3),
        inertia_kg_m2=frozen([inertia_kg_m2(b, negated=negated) for b in body], -1, 3, 3),
        shape_m=tuple(shape_m(b) for b in body),
        joint_names=joint_names,
        joint_inner=inner,
        joint_outer=outer,
        joint_axis=frozen([joints.axis(j) for j in joint], -1, 3),
        joint_point_m=frozen([j.array("point_mm", 3) * 1e-3 for j in joint], -1, 3),
        joint_limits_rad=frozen(limits, -1, 2),
        servos=tuple(joints.servo(j, pair) for j, pair in zip(joint, limits, strict=True)),
        imus=sensors.imus(top, body_names),
        angle_sensors=sensors.angle_sensors(top, joint_names),
        uncertainty=_uncertainty(top),
    )
    check_tree(body, joint, inner, outer, body_names)
    return robot


def _uncertainty(top: Table) -> Uncertainty | None:
    """The figures of `[uncertainty]`, 0 for one that is left out; None without the table."""
    if not top.has("uncertainty"):
        return None
    table = top.table("uncertainty", " ".join((*_SHARES, *_ERRORS)))
    shares = {key: table.number(key, 0.0, least=0, most=_GREATEST_SHARE) for key in _SHARES}
    errors = {key: table.number(key, 0.0, least=0) for key in _ERRORS}
    return Uncertainty(
        com_m=1e-3 * errors["com_mm"],
        joint_point_m=1e-3 * errors["joint_point_mm"],
        joint_axis_rad=math.radians(errors["joint_axis_deg"]),
        stroke_rad=math.radians(errors["stroke_deg"]),
        **shares,
    )
