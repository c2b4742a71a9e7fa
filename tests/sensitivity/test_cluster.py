"""The same study on a Dask cluster: the same numbers, and words where there is none or it fails."""

from __future__ import annotations

import importlib.util
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.sensitivity.cluster_process import cluster
from tests.sensitivity.studies import EXACT, study_of
from tfsat_host.plan import cluster as on_cluster
from tfsat_host.robot import RobotModel

_STUDY = ("sensitivity", 59, 70, "--samples", 1100, "--seed", 4)

_OTHER_VERSION = """
import sys, tfsat_host
tfsat_host.__version__ = "0.0.other"
from tfsat_host.cli.main import main
sys.exit(main())
"""
_FAILING_WORKER = """
import sys
from tfsat_host.cli.main import main
from tfsat_host.plan import cluster
def fail(study, chunk):
    raise MemoryError("no room for robots")
cluster._answer = fail
sys.exit(main())
"""


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(on_cluster.run_on_cluster.__kwdefaults__ or {}, "answer_s", 1.0)


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with cluster(2, tmp_path_factory.mktemp("dask")) as address:
        yield address


def _timeless(result: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in result.items() if key not in ("seconds", "files")}


def test_two_workers_give_the_same_numbers_as_this_computer(
    tfsat_host: RunCli, tmp_path: Path, two_workers: str
) -> None:
    here, there = tmp_path / "here.csv", tmp_path / "there.csv"
    local = tfsat_host.json(*_STUDY, "--workers", 1, "--out", here)
    distributed = tfsat_host.json(*_STUDY, "--dask", two_workers, "--out", there)
    assert _timeless(distributed) == _timeless(local)
    assert there.read_bytes() == here.read_bytes()


@pytest.mark.parametrize(
    ("program", "words"),
    [(_OTHER_VERSION, "this computer 0.0.other"), (_FAILING_WORKER, "no room for robots")],
    ids=["another version", "a failing worker"],
)
def test_a_cluster_that_cannot_do_it_says_why(two_workers: str, program: str, words: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", program, *map(str, _STUDY), "--dask", two_workers],
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    assert words in done.stderr and "leave out --dask" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("hasty")
def test_a_scheduler_without_workers_is_not_waited_for(tfsat_host: RunCli, tmp_path: Path) -> None:
    with cluster(0, tmp_path) as address:
        refused = tfsat_host(*_STUDY, "--dask", address, expect=1).stderr
    assert "no worker" in refused and f"dask worker {address}" in refused


@pytest.mark.usefixtures("hasty")
def test_a_scheduler_that_is_not_there_is_not_waited_for(tfsat_host: RunCli) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # not listening: nobody answers, and nobody else gets the port
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        error = tfsat_host.json(*_STUDY, "--dask", address, expect=1)["error"]
    assert address in error["what"]
    assert "dask scheduler" in error["next_step"] and "leave out --dask" in error["next_step"]


def test_without_the_extra_it_says_what_to_install(
    robot: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(on_cluster, "find_spec", lambda _name: None)
    with pytest.raises(on_cluster.ClusterError) as caught:
        on_cluster.run_on_cluster(study_of(robot, EXACT, samples=2), "tcp://127.0.0.1:8786")
    assert "python -m pip install '.[dask]'" in caught.value.next_step


def test_the_command_loads_dask_only_when_asked(tfsat_host: RunCli) -> None:
    assert importlib.util.find_spec("distributed") is not None
    blocked = tfsat_host.folder / "distributed.py"
    blocked.write_text("raise SystemExit('distributed was imported')\n", encoding="utf-8")
    path = {"PYTHONPATH": str(tfsat_host.folder)}
    tfsat_host("sensitivity", 59, 70, "--samples", 2, environ=path, process=True)
