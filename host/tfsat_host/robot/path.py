"""Where robot files are: the ones that tfsat brings along, and the one that a person names."""

from __future__ import annotations

import re
from pathlib import Path

from tfsat_host.config import ConfigKind
from tfsat_host.errors import TfsatError

_DEFAULT = "drop_tower"


class RobotFileError(TfsatError):
    """The robot file cannot be read or does not describe a robot (exit code 1)."""


ROBOT_FILE = ConfigKind(
    name="robot file",
    error=RobotFileError,
    meaning="Without a valid robot model no maneuver can be designed, flown or judged.",
    cure="Correct the file, or name another (none: the drop tower robot); docs/robot-files.md shows the format.",
)


def default_robot_path() -> Path:
    """`robots/drop_tower.toml` of the installed package, or of the checkout it runs from."""
    return _shipped_folder() / f"{_DEFAULT}.toml"


def shipped_robots() -> tuple[str, ...]:
    """Names of the robots that tfsat brings along, in alphabetical order."""
    files = _shipped_folder().glob("*.toml")
    return tuple(sorted(file.stem for file in files if _has_bodies(file)))


def find_robot(name_or_path: str | Path | None = None) -> Path:
    """Find a robot file by its path or by the name of a shipped robot; None is the default robot.

    Only a word without a folder is looked for among the shipped robots, with or without `.toml`.

    Raises:
        RobotFileError: there is neither such a file nor such a robot.
    """
    if name_or_path is None:
        return default_robot_path()
    path = Path(name_or_path)
    # A file comes first: a shipped robot of that name must not hide it.
    if path.is_file():
        return path
    if len(path.parts) == 1 and path.name.removesuffix(".toml") in shipped_robots():
        return _shipped_folder() / f"{path.name.removesuffix('.toml')}.toml"
    if path.exists():
        problem = "is no file"
    else:
        problem = "is not there" if len(path.parts) > 1 else "is neither a file here nor the name of a robot"
    raise RobotFileError(
        what=f"The robot file {path} cannot be read: it {problem}.",
        meaning="The robot's masses and joints are unknown; nothing was done.",
        next_step=f"Name a robot file that exists, or a robot that tfsat knows: {', '.join(shipped_robots())}.",
    )


def _shipped_folder() -> Path:
    package = Path(__file__).resolve().parents[1]
    # Installed, robots are data of the package; in a checkout they lie beside the host's folder.
    packaged = package / "data" / "robots"
    return packaged if packaged.is_dir() else package.parents[1] / "robots"


def _has_bodies(file: Path) -> bool:
    """Other data files lie in the same folder; only a robot's has bodies."""
    return re.search(r"^\s*\[\[\s*body\s*\]\]", file.read_text(encoding="utf-8"), re.MULTILINE) is not None
