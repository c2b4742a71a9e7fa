"""From a robot file to a `RobotModel`: units converted, every entry checked.

The file's format is explained in `docs/robot-files.md`.
"""

from __future__ import annotations

from pathlib import Path

from tfsat_host.robot import bodies, joints, sensors
from tfsat_host.robot.arrays import frozen, frozen_indices
from tfsat_host.robot.checks import check_tree, index_of, unique_names
from tfsat_host.robot.entries import Entry
from tfsat_host.robot.errors import RobotFileError
from tfsat_host.robot.model import RobotModel
from tfsat_host.robot.path import find_robot
from tfsat_host.robot.uncertainty import uncertainty
from tfsat_host.toml_reading import TomlError, read_toml


def load_robot(name_or_path: Path | str | None = None) -> RobotModel:
    """Read and check a robot file, named as `find_robot` takes it; None is the drop tower robot.

    Raises:
        RobotFileError: the file cannot be read, is not TOML or does not describe a robot. The message
            names file, line and entry, and how to correct it.
    """
    file = find_robot(name_or_path)
    try:
        text, values = read_toml(file)
    except OSError as error:
        raise RobotFileError(
            what=f"The robot file {file} cannot be read: {error.strerror}.",
            meaning="The robot's masses and joints are unknown.",
            next_step="Name a robot file that exists, or name none to use the drop tower robot.",
        ) from error
    except TomlError as error:
        raise RobotFileError(
            what=f"{file}: {error}.",
            meaning="The robot's masses and joints are unknown.",
            next_step="Correct that; docs/robot-files.md and robots/drop_tower.toml show the format.",
        ) from error
    return _robot(file, Entry(file, text, "", 0, values))


def _robot(file: Path, top: Entry) -> RobotModel:
    top.integer("format", (1,))
    body, joint = top.tables("body"), top.tables("joint")
    if not body:
        top.fail("body", "there is no body", "Describe each body below its own line `[[body]]`.")
    negated = bodies.products_are_negated(top)
    body_names = unique_names(body)
    joint_names = unique_names(joint)
    inner = frozen_indices([index_of(j, "inner", body_names, "body") for j in joint])
    outer = frozen_indices([index_of(j, "outer", body_names, "body") for j in joint])
    limits = [joints.limits_rad(j) for j in joint]
    robot = RobotModel(
        path=file,
        name=top.text("name"),
        source=top.text("source") if top.has("source") else "",
        base=index_of(top, "base", body_names, "body"),
        body_names=body_names,
        mass_kg=frozen([b.positive("mass_kg") for b in body], (-1,)),
        origin_m=frozen([b.vector("origin_mm") * 1e-3 for b in body], (-1, 3)),
        com_m=frozen([b.vector("com_mm") * 1e-3 for b in body], (-1, 3)),
        inertia_kg_m2=frozen([bodies.inertia_kg_m2(b, negated=negated) for b in body], (-1, 3, 3)),
        shape_m=tuple(bodies.shape_m(b) for b in body),
        joint_names=joint_names,
        joint_inner=inner,
        joint_outer=outer,
        joint_axis=frozen([joints.axis(j) for j in joint], (-1, 3)),
        joint_point_m=frozen([j.vector("point_mm") * 1e-3 for j in joint], (-1, 3)),
        joint_limits_rad=frozen(limits, (-1, 2)),
        servos=tuple(joints.servo(j.table("servo"), pair) for j, pair in zip(joint, limits, strict=True)),
        imus=sensors.imus(top.tables("imu"), body_names),
        angle_sensors=tuple(sensors.angle_sensor(s, joint_names) for s in top.tables("angle_sensor")),
        uncertainty=uncertainty(top),
    )
    check_tree(body, joint, inner, outer, body_names)
    for entry in (top, *body, *joint):
        entry.done()
    return robot
