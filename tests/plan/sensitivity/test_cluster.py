"""The same study on a Dask cluster: the same numbers, and words where there is none or it fails."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.plan.sensitivity.cluster_process import cluster
from tests.plan.sensitivity.studies import EXACT, stated_by, study_of
from tfsat_host.plan import cluster as on_cluster
from tfsat_host.plan.study import run_locally
from tfsat_host.robot import RobotModel

_STUDY = ("sensitivity", 59, 70, "--samples", 501, "--seed", 4)


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_cluster, "ANSWER_S", 1.0)


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


def test_a_study_survives_a_restart_of_the_workers(robot: RobotModel, tmp_path: Path) -> None:
    """What had been given to the workers is asked for once more; the numbers are the same."""
    study = study_of(robot, stated_by(robot), samples=1501, seed=4)
    restarts = 0

    with cluster(1, tmp_path) as address:

        def restart_once(_samples: float) -> None:
            nonlocal restarts
            restarts += 1
            if restarts == 1:
                from distributed import Client

                with Client(address, set_as_default=False) as somebody:  # type: ignore[no-untyped-call]
                    somebody.restart()

        outcomes = on_cluster.run_on_cluster(study, address, progress=restart_once)
    assert restarts > 1
    here = run_locally(study, workers=1)
    assert np.array_equal(outcomes.quaternion_xyzw, here.quaternion_xyzw)


def test_a_cluster_that_cannot_do_it_says_why(
    tfsat_host: RunCli, two_workers: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_study: object, _chunk: int) -> None:
        raise MemoryError("no room for robots")

    for name, value, words in (
        ("__version__", "0.0.other", "this computer 0.0.other"),
        ("_answer", fail, "no room for robots"),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(on_cluster, name, value)
            error = tfsat_host.json(*_STUDY, "--dask", two_workers, expect=1)["error"]
        assert words in error["what"] and "leave out --dask" in error["next_step"]


@pytest.mark.usefixtures("hasty")
def test_a_scheduler_without_workers_is_not_waited_for(tfsat_host: RunCli, tmp_path: Path) -> None:
    with cluster(0, tmp_path) as address:
        refused = tfsat_host(*_STUDY, "--dask", address, expect=1).stderr
    assert "no worker" in refused and f"dask worker {address}" in refused


@pytest.mark.usefixtures("hasty")
def test_a_scheduler_that_is_not_there_is_not_waited_for(tfsat_host: RunCli) -> None:
    with socket.socket() as silent_socket:
        silent_socket.bind(("127.0.0.1", 0))  # not listening: nobody answers, and nobody else gets the port
        address = f"tcp://127.0.0.1:{silent_socket.getsockname()[1]}"
        error = tfsat_host.json(*_STUDY, "--dask", address, expect=1)["error"]
    assert address in error["what"]
    assert "dask scheduler" in error["next_step"] and "leave out --dask" in error["next_step"]


def test_without_the_extra_it_says_what_to_install(
    robot: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(on_cluster, "find_spec", lambda _name: None)
    with pytest.raises(on_cluster.ClusterError) as caught:
        on_cluster.run_on_cluster(study_of(robot, EXACT, samples=2), "tcp://127.0.0.1:8786")
    assert "python -m pip install 'tfsat-host[dask]'" in caught.value.next_step


def test_the_command_loads_dask_only_when_asked(tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)  # then to import it is an error
    tfsat_host("sensitivity", 59, 70, "--samples", 2)
