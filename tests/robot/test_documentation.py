"""docs/robot-files.md: every key that the loader knows, no other, and an example that loads."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.paths import DOCS
from tfsat_host.robot import RobotFileError, default_robot_path, load_robot

DOCUMENT = (DOCS / "robot-files.md").read_text(encoding="utf-8")
ROBOT = default_robot_path().read_text(encoding="utf-8")

# Where to write a key that is not known, to be told of the known ones: text before it, and after it.
PLACES = {
    "above all tables": ("format = 1\n", "\n"),
    "[[body]]": ("[[body]]\n", "\n"),
    "inertia_g_m2": ("inertia_g_m2 = { ", ", "),
    "[[joint]]": ("[[joint]]\n", "\n"),
    "[joint.servo]": ("[joint.servo]\n", "\n"),
    "reference": ("reference = { ", ", "),
    "[[imu]]": ("[[imu]]\n", "\n"),
    "[[angle_sensor]]": ("[[angle_sensor]]\n", "\n"),
    "[uncertainty]": ("[uncertainty]\n", "\n"),
}


def documented_keys() -> dict[str, set[str]]:
    """Parse the documented keys of each table from the table "Every key"."""
    keys: dict[str, set[str]] = {}
    table = ""
    for line in DOCUMENT.partition("| table | key |")[2].splitlines()[2:]:
        if not line.startswith("|"):
            break
        owner, names, _ = line.split("|")[1:4]
        table = owner.strip().strip("`") or table
        keys.setdefault(table, set()).update(re.findall(r"`(\w+)`", names))
    return keys


@pytest.mark.parametrize("table", PLACES)
def test_every_key_that_the_loader_knows_is_explained_and_no_other(tmp_path: Path, table: str) -> None:
    before, after = PLACES[table]
    file = tmp_path / "robot.toml"
    file.write_text(ROBOT.replace(before, f"{before}unheard_of = 1{after}", 1), encoding="utf-8")
    with pytest.raises(RobotFileError, match="unheard_of: is not known here") as caught:
        load_robot(file)
    known_keys = caught.value.next_step.partition("known are: ")[2].rstrip(".").split(", ")
    assert documented_keys()[table] == set(known_keys)


def test_no_other_table_is_explained() -> None:
    assert documented_keys().keys() == PLACES.keys()


def test_the_example_is_a_robot(tmp_path: Path) -> None:
    file = tmp_path / "flap.toml"
    (example,) = re.findall(r"```toml\n(.*?)```", DOCUMENT, flags=re.DOTALL)
    file.write_text(example, encoding="utf-8")
    assert load_robot(file).joint_names == ("hinge",)
