"""The computer that a user has: no home folder, file systems without permissions or locks, odd places for output."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import Served
from tests.evaluation.run_folder import made_folder
from tfsat_host.whole_file import write_whole


@pytest.fixture
def without_home(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither HOME nor an entry in the password file, as in many containers."""
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path("~/.cache").expanduser())
    monkeypatch.setenv("XDG_CACHE_HOME", cache)
    for name in ("HOME", "XDG_STATE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)

    def nobody(_uid: int) -> Any:
        raise KeyError("uid not found")

    monkeypatch.setattr("pwd.getpwuid", nobody)


@pytest.mark.parametrize("command", ["log list --emulated", "log fetch all --emulated", "status --emulated"])
def test_what_needs_a_home_folder_names_the_variable(
    without_home: None, tfsat_host: RunCli, command: str
) -> None:
    error_text = tfsat_host(*command.split(), expect=1).stderr
    assert "this user has no home folder" in error_text
    assert "export XDG_STATE_HOME=" in error_text


def test_recordings_are_listed_and_fetched_without_a_home_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tfsat_host: RunCli, request: pytest.FixtureRequest
) -> None:
    monkeypatch.chdir(tmp_path)
    with Served() as robot:
        port = ("--port", robot.announced["logger"])
        # The IMUs wake in a tenth of a second after power-up: a recording from then on lacks none of their values.
        robot.control("wait 500ms")
        tfsat_host("record", "start", *port)
        robot.control("wait 500ms")
        tfsat_host("record", "stop", *port)
        request.getfixturevalue("without_home")
        listed = tfsat_host.json("log", "list", *port)
        fetched = tfsat_host("log", "fetch", 1, *port)
        refused = tfsat_host("log", "erase", 1, "--yes", *port, expect=4)
    assert listed["logs"][0]["fetched_to"] is None
    assert (tmp_path / "DROP0001.BIN").is_file()
    assert "is whole, but this computer will not remember it" in fetched.stderr
    assert "XDG_STATE_HOME" in fetched.stderr
    assert "has no copy" in refused.stderr


def test_a_bug_is_kept_without_a_home_folder(
    without_home: None, tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tfsat_host.cli.robot.run", lambda *_: 1 / 0)
    error_text = tfsat_host("robot", expect=1).stderr
    assert "met a bug of its own: ZeroDivisionError" in error_text
    assert "with the file /" in " ".join(error_text.split())


@pytest.mark.parametrize("refusal", ["chmod", "fsync"])
def test_a_file_system_without_permissions_or_flushing_is_written_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusal: str
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))

    monkeypatch.setattr(os, refusal, refuse)
    monkeypatch.setattr(Path, "chmod", refuse) if refusal == "chmod" else None
    write_whole(tmp_path / "file", b"whole")
    assert (tmp_path / "file").read_bytes() == b"whole"


def test_a_disk_that_fails_is_not_taken_for_one_that_cannot_flush(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(tmp_path / "file", b"whole")
    assert list(tmp_path.iterdir()) == []


def test_a_refused_lock_is_found_out_before_anything_is_measured(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    refused = tfsat_host("calibrate", "bias", "--emulated", "--yes", expect=1)
    error_text = " ".join(refused.stderr.split())
    assert ".calibration-emulated.toml.lock cannot be locked: No locks available." in error_text
    assert "Work in a folder on a disk of this computer" in error_text
    assert "recording" not in error_text.lower(), "nothing was measured"


@pytest.mark.parametrize("place", ["/dev/null", "/dev/stdout", "fifo"])
@pytest.mark.parametrize("force", [(), ("--force",)])
def test_what_is_no_file_is_refused_as_a_place_for_output(
    tfsat_host: RunCli, place: str, force: tuple[str, ...]
) -> None:
    os.mkfifo(tfsat_host.folder / "fifo")
    before = Path("/dev/null").stat().st_rdev
    for command in (["design"], ["upload-sequence", "59", "70", "--dry-run"]):
        process = subprocess.run(
            [sys.executable, "-m", "tfsat_host", *command, "--out", place, *force],
            cwd=tfsat_host.folder,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert process.returncode in (1, 2), process
        assert "is a device, pipe or socket, not a file" in process.stderr
        assert "--force" not in process.stderr
    assert Path("/dev/null").stat().st_rdev == before


@pytest.mark.parametrize("command", ["robot", "robot --json", "--help", "decode SD.bin"])
def test_a_full_disk_behind_stdout_is_one_sentence(tfsat_host: RunCli, command: str) -> None:
    shutil.copy(made_folder() / "SD.bin", tfsat_host.folder / "SD.bin")
    process = _with_streams(tfsat_host.folder, command.split(), stdout="/dev/full", stderr=subprocess.PIPE)
    assert process.returncode == 1
    assert process.stderr.count("Error:") == 1
    assert "No space left on device" in process.stderr
    assert "Traceback" not in process.stderr
    assert (tfsat_host.folder / "SD.csv").is_file() == command.startswith("decode"), "the work was done"


def test_a_full_disk_behind_stderr_does_not_stop_the_work(tfsat_host: RunCli) -> None:
    shutil.copy(made_folder() / "SD.bin", tfsat_host.folder / "SD.bin")
    process = _with_streams(
        tfsat_host.folder, ["decode", "SD.bin"], stdout=subprocess.PIPE, stderr="/dev/full"
    )
    assert process.returncode == 1
    assert "SD.csv" in process.stdout
    assert (tfsat_host.folder / "SD.csv").is_file()


def _with_streams(
    folder: Path, command: list[str], *, stdout: int | str, stderr: int | str
) -> subprocess.CompletedProcess[str]:
    with ExitStack() as stack:
        streams = [
            stack.enter_context(Path(to).open("w")) if isinstance(to, str) else to for to in (stdout, stderr)
        ]
        return subprocess.run(
            [sys.executable, "-m", "tfsat_host", *command],
            cwd=folder,
            stdout=streams[0],
            stderr=streams[1],
            text=True,
            timeout=60,
            check=False,
        )


def test_figures_do_not_need_the_backend_of_a_notebook(tfsat_host: RunCli) -> None:
    notebook = {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}
    tfsat_host("design", "--grid", "30", "--figure", "grid.png", environ=notebook, process=True, expect=None)
    assert (tfsat_host.folder / "grid.png").is_file()


STUDY = ("sensitivity", 59, 70, "--samples", 6000, "--workers", 2, "--json")


def test_processes_do_not_import_what_lies_in_the_folder(tfsat_host: RunCli) -> None:
    """Many a lab has a signal.py of its own."""
    (tfsat_host.folder / "signal.py").write_text("raise SystemExit('not this one')\n")
    script = Path(sys.executable).with_name("tfsat-host")
    process = subprocess.run(
        [script, *map(str, STUDY)],
        cwd=tfsat_host.folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert process.returncode == 0, process.stderr


def test_without_shared_memory_one_process_computes_the_same(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared = tfsat_host.json(*STUDY[:-1])
    del shared["seconds"]

    def none(*_: object, **__: object) -> None:
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), "/dev/shm")

    monkeypatch.setattr("tfsat_host.worker_processes.ProcessPoolExecutor", none)
    alone = tfsat_host.json(*STUDY[:-1])
    del alone["seconds"]
    assert alone == shared


NOT_UTF_8 = os.fsdecode(b"DROP-\xfc.BIN")


@pytest.mark.parametrize("kind", ["csv", "npz", "mat", "parquet", "mcap"])
def test_a_name_that_is_not_utf_8_is_exported(tfsat_host: RunCli, kind: str) -> None:
    shutil.copy(made_folder() / "SD.bin", tfsat_host.folder / NOT_UTF_8)
    tfsat_host("decode", NOT_UTF_8, "--format", kind)
    assert (tfsat_host.folder / NOT_UTF_8).with_suffix(f".{kind}").is_file()


def test_a_drop_with_a_name_that_is_not_utf_8_comes_into_a_campaign(tfsat_host: RunCli) -> None:
    run = os.fsdecode(b"run-\xfc")
    shutil.copytree(made_folder(), tfsat_host.folder / run)
    (tfsat_host.folder / run / "SD.bin").rename(tfsat_host.folder / run / NOT_UTF_8)
    tfsat_host("campaign", "init", "camp")
    refused = tfsat_host("campaign", "add", "camp", run, expect=1).stderr
    assert "DROP-\\udcfc.BIN is not UTF-8 text" in refused and "Rename it to SD.bin" in refused
    (tfsat_host.folder / run / NOT_UTF_8).rename(tfsat_host.folder / run / "SD.bin")
    tfsat_host("campaign", "add", "camp", run, expect=None)
    (drop,) = tfsat_host.json("campaign", "list", "camp")["drops"]
    assert drop["number"] == 1


def test_the_card_s_last_number_is_refused_in_words(tfsat_host: RunCli) -> None:
    card = Path(os.environ["XDG_STATE_HOME"]) / "tfsat" / "emulated" / "card"
    card.mkdir(parents=True)
    shutil.copy(made_folder() / "SD.bin", card / "DROP9999.BIN")
    listed = tfsat_host.json("log", "list", "--emulated")
    assert [log["number"] for log in listed["logs"]] == [9999]
