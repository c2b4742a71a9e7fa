"""Files of robots that have fewer parts than the boards have places for."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from tfsat_host.robot import RobotModel, default_robot_path, load_robot


def robot_text(*, bodies: int = 4, without_imu: Collection[int] = ()) -> str:
    """The drop tower's first bodies, with the joints between them, and IMUs on all but some of them."""
    gone = {
        "body": [f'name = "body {body}"' for body in range(bodies + 1, 5)],
        "joint": [f'name = "joint {joint}"' for joint in range(bodies, 4)],
        "imu": [f'body = "body {body}"' for body in (*without_imu, *range(bodies + 1, 5))],
        "angle_sensor": [f'joint = "joint {joint}"' for joint in range(bodies, 4)],
    }
    parts = re.split(r"(?m)^(?=\[\[)", default_robot_path().read_text(encoding="utf-8"))
    kept = [
        part
        for part in parts
        if not any(
            part.startswith(f"[[{kind}]]") and any(line in part for line in gone[kind]) for kind in gone
        )
    ]
    return (
        "".join(kept)
        .replace('name = "drop tower robot"', 'name = "smaller robot"')
        .replace('base = "body 3"', f'base = "body {min(3, bodies)}"')
    )


def smaller_robot(folder: Path, *, bodies: int = 4, without_imu: Collection[int] = ()) -> RobotModel:
    file = folder / "smaller.toml"
    file.write_text(robot_text(bodies=bodies, without_imu=without_imu), encoding="utf-8")
    return load_robot(file)
