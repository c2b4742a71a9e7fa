"""`make release`: refuses what must not be flown as a release, then puts package and sequencer image into dist/.

The logger's image is made by the Arduino IDE: no package has the Teensy core.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

from tests.paths import REPOSITORY
from tests.validation.provenance import PROOFS, SEQUENCER_HEX
from tfsat_host import __version__

DIST = REPOSITORY / "dist"


def find_obstacles(root: Path = REPOSITORY) -> list[str]:
    """Return a sentence for each thing that stands in the way, with what to type."""
    stale = [proof.stale_sentence() for proof in PROOFS if proof.is_stale()]
    return [*find_uncommitted(root), *find_missing_entry((root / "CHANGELOG.md").read_text("utf-8")), *stale]


def find_uncommitted(root: Path) -> list[str]:
    """Return a sentence if the work tree has changes that no commit has."""
    changed = _git(root, "status", "--porcelain").splitlines()
    if not changed:
        return []
    return [f"{len(changed)} files are changed or new and in no commit. Run: git status"]


def find_missing_entry(changelog: str, version: str = __version__) -> list[str]:
    """Return a sentence if the changelog has no section for the version, or one that is not released."""
    headings = re.findall(r"^## (.+)$", changelog, re.MULTILINE)
    sentences = []
    # The heading of a version has its name, with or without brackets.
    if not any(heading.split(" ")[0].strip("[]") == version for heading in headings):
        sentences.append(
            f"CHANGELOG.md has no section for {version}, the version in host/tfsat_host/__init__.py. "
            f"Write: ## {version}"
        )
    if "Unreleased" in headings:
        sentences.append(
            f'CHANGELOG.md still has a section "Unreleased". Move its entries below: ## {version}'
        )
    return sentences


def build_release() -> list[Path]:
    """Build the wheel and copy the image; return what is in dist/."""
    shutil.rmtree(DIST, ignore_errors=True)
    DIST.mkdir()
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-qq", "--no-deps", "--no-build-isolation", "-w", DIST, "."],
        cwd=REPOSITORY,
        check=True,
    )
    shutil.copy(SEQUENCER_HEX, DIST)
    return sorted(DIST.iterdir())


def main() -> int:
    """Refuse (1) or build."""
    obstacles = find_obstacles()
    if obstacles:
        print(f"Error: this is no release {__version__} yet.", file=sys.stderr)
        for sentence in obstacles:
            print(f"  - {sentence}", file=sys.stderr)
        return 1
    for path in build_release():
        print(f"  {path.relative_to(REPOSITORY)}")
    print(f"Next: git tag v{__version__}")
    return 0


def _git(root: Path, *arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=True).stdout


if __name__ == "__main__":
    sys.exit(main())
