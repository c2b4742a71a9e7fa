"""The wiring of docs/wiring.toml, as it stands and spoiled."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from shutil import copy, copytree, ignore_patterns

from tests.paths import REPOSITORY
from wiring_generator.spec import Wiring, load_wiring


def load_committed() -> Wiring:
    return load_wiring(REPOSITORY / "docs" / "wiring.toml")


@dataclass(frozen=True)
class Tree:
    """A copy of what the generator reads and writes."""

    folder: Path

    def spoil(self, old: str, new: str) -> None:
        path = self.folder / "docs" / "wiring.toml"
        text = path.read_text(encoding="utf-8")
        # An edit that hits nothing would leave a sound wiring, and the test would pass for nothing.
        assert old in text, old
        path.write_text(text.replace(old, new), encoding="utf-8")

    def generate(self, *options: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(self.folder / "tools" / "generate_wiring.py"), *options]
        return subprocess.run(command, capture_output=True, text=True, check=False)


def copy_generator(folder: Path) -> Tree:
    (folder / "tools").mkdir()
    (folder / "docs").mkdir()
    copy(REPOSITORY / "tools" / "generate_wiring.py", folder / "tools")
    copytree(
        REPOSITORY / "tools" / "wiring_generator",
        folder / "tools" / "wiring_generator",
        ignore=ignore_patterns("__pycache__"),
    )
    for name in ("wiring.toml", "wiring.md", "wiring.svg"):
        copy(REPOSITORY / "docs" / name, folder / "docs")
    return Tree(folder)
