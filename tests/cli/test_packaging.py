"""What is installed: the lock, and a wheel that can serve the emulated robot alone."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.cli.process import clean_environment
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
    for name, extra in project["optional-dependencies"].items():
        # A compiler for machines that have none: those that make and test tfsat have one.
        requirements += [] if name == "compiler" else [entry for entry in extra if "tfsat-host" not in entry]
    locked = set(re.findall(r"^(\S+)==", LOCK, re.MULTILINE))
    assert {re.split(r"[<>=]", entry)[0] for entry in requirements} <= locked
    assert "crcmod" not in locked


def test_the_runtime_is_a_part_of_the_lock() -> None:
    pins = re.compile(r"^\S+==\S+", re.MULTILINE)
    runtime = pins.findall((REPOSITORY / "requirements-runtime.lock").read_text())
    assert set(runtime) <= set(pins.findall(LOCK))
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert {re.split(r"[<>=]", entry)[0] for entry in project["dependencies"]} <= {
        pin.partition("==")[0] for pin in runtime
    }


@pytest.fixture(scope="module")
def wheel_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder],
        cwd=REPOSITORY,
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def wheel(wheel_file: Path) -> set[str]:
    with ZipFile(wheel_file) as archive:
        return set(archive.namelist())


@pytest.fixture(scope="module")
def installed(wheel_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel into an environment of its own, whose dependencies are those of this one; its `bin`."""
    environment = tmp_path_factory.mktemp("installed") / "venv"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    (packages,) = environment.glob("lib/python*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    pip: list[str | Path] = [
        environment / "bin/python",
        "-m",
        "pip",
        "install",
        "-q",
        "--no-deps",
        "--no-index",
        wheel_file,
    ]
    subprocess.run(pip, check=True)
    return environment / "bin"


def run_installed(
    installed: Path, folder: Path, *arguments: str, **environ: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [installed / "tfsat-host", *arguments],
        cwd=folder,
        env=clean_environment(folder / "home") | environ,
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_wheel_rehearses_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    done = run_installed(installed, tmp_path, "rehearse", "59", "70", PATH=os.environ["PATH"])
    assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip().splitlines()[-1].startswith("GOOD: ")
    assert (tmp_path / "run" / "report.html").is_file()


@pytest.mark.parametrize("options", [(), ("--sequencer", "avr")])
def test_a_machine_without_a_compiler_says_what_to_install(
    installed: Path, tmp_path: Path, options: tuple[str, ...]
) -> None:
    """Without a compiler in PATH, and with an empty cache."""
    done = run_installed(
        installed,
        tmp_path,
        "rehearse",
        "59",
        "70",
        *options,
        PATH=str(installed),
        XDG_CACHE_HOME=str(tmp_path),
    )
    assert done.returncode == 1
    if not options:
        assert "No C++ compiler was found." in done.stderr
        assert "python -m pip install 'tfsat-host[compiler]'" in done.stderr
    else:
        assert "no sources of the sequencer's sketch" in done.stderr
        assert "from a checkout" in done.stderr
    assert "Traceback" not in done.stderr


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
