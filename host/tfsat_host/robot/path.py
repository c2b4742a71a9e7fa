"""Where the default robot file is."""

from __future__ import annotations

from pathlib import Path

_FILE_NAME = "drop_tower.toml"


def default_robot_path() -> Path:
    """`robots/drop_tower.toml` of the installed package, or of the checkout it runs from."""
    package = Path(__file__).resolve().parents[1]
    packaged = package / "data" / "robots" / _FILE_NAME
    return packaged if packaged.is_file() else package.parents[1] / "robots" / _FILE_NAME
