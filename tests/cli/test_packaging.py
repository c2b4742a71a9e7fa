"""What is installed: the lock, and a wheel that can serve the emulated robot alone."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from zipfile import ZipFile

import pytest

from tests.paths import REPOSITORY

LOCK = (REPOSITORY / "requirements.lock").read_text()
SOURCES = ("tools/emulator/src", "firmware/arduino_sequencer/src", "firmware/teensy_logger/src")


def test_the_lock_names_no_host_and_hashes_everything() -> None:
    assert "://" not in LOCK
    assert "--index-url" not in LOCK
    pins = re.findall(r"^\S+==\S+.*(?:\n +.*)*", LOCK, re.MULTILINE)
    assert len(pins) == len(re.findall(r"^[a-z0-9]", LOCK, re.MULTILINE))
    assert all("--hash=sha256:" in pin for pin in pins)


def test_every_dependency_is_locked() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    requirements = list(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        requirements += extra
    locked = set(re.findall(r"^(\S+)==", LOCK, re.MULTILINE))
    assert {re.split(r"[<>=]", entry)[0] for entry in requirements} <= locked
    assert "crcmod" not in locked


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder],
        cwd=REPOSITORY,
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("*.whl")
    with ZipFile(path) as archive:
        return set(archive.namelist())


def test_a_wheel_carries_the_package(wheel: set[str]) -> None:
    assert {"tfsat_host/py.typed", "tfsat_host/cli/main.py", "tfsat_host/protocol/limits.py"} <= wheel
    assert not [name for name in wheel if name.startswith(("tests/", "host/")) or "__pycache__" in name]


def test_a_wheel_carries_what_builds_the_emulated_robot(wheel: set[str]) -> None:
    for folder in SOURCES:
        files = [path for path in (REPOSITORY / folder).rglob("*") if path.suffix in (".h", ".cpp")]
        assert files
        assert {
            f"tfsat_host/data/native/{path.relative_to(REPOSITORY).as_posix()}" for path in files
        } <= wheel


def test_a_wheel_carries_the_robot(wheel: set[str]) -> None:
    assert "tfsat_host/data/robots/drop_tower.toml" in wheel
