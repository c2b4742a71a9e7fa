"""Who may serve a folder, and what is cleared away."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from tfsat_host.cli.emulate import require_pseudo_terminals
from tfsat_host.emulated.real_time import ControlSocket
from tfsat_host.emulated.server import RobotServer
from tfsat_host.emulated.state import ServedFolder, being_started, served_by_dead_process
from tfsat_host.errors import TfsatError


def test_a_live_folder_is_refused_and_its_holder_named(tmp_path: Path) -> None:
    first = ServedFolder(tmp_path)
    with pytest.raises(TfsatError, match=f"by process {os.getpid()}"):
        ServedFolder(tmp_path)
    first.release()
    ServedFolder(tmp_path).release()
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_run_left_is_cleared_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # A process number that cannot exist any more.
    Path("emulate.pid").write_text("99999999\n")
    for name in ("sequencer", "logger"):
        Path(name).symlink_to("/dev/pts/none")
    # A socket without a listener, as a killed server leaves it.
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind("control")
    Path("sequencer.eeprom").write_bytes(b"kept")
    folder = ServedFolder(Path())
    assert sorted(path.name for path in Path().iterdir()) == ["emulate.pid", "sequencer.eeprom"]
    folder.release()


def test_a_link_is_dead_when_nobody_holds_its_folder(tmp_path: Path) -> None:
    folder = ServedFolder(tmp_path / "robot")
    folder.sequencer.symlink_to("/dev/null")
    assert not served_by_dead_process(folder.sequencer)
    # Which process held it, as the file says.
    holder = (folder.path / "emulate.pid").read_text()
    folder.release()
    (folder.path / "emulate.pid").write_text(holder)  # as a kill leaves it: the process number lives
    assert served_by_dead_process(folder.sequencer)
    ServedFolder(folder.path).release()


def test_other_ports_are_nobodys_dead_links(tmp_path: Path) -> None:
    (tmp_path / "mine").symlink_to("/dev/null")
    (tmp_path / "file").write_text("")
    (tmp_path / "emulate.pid").mkdir()
    for path in (Path("/dev/null"), tmp_path / "none", tmp_path / "file"):
        # No link, no file, no folder of a server.
        assert not served_by_dead_process(path)
    (tmp_path / "emulate.pid").rmdir()
    assert not served_by_dead_process(tmp_path / "mine")


def test_a_folder_that_was_made_for_nothing_goes(tmp_path: Path) -> None:
    ServedFolder(tmp_path / "new" / "robot").release()
    # A folder that the server made goes with it, one that was there stays.
    assert not (tmp_path / "new" / "robot").exists()
    (tmp_path / "old").mkdir()
    ServedFolder(tmp_path / "old").release()
    assert (tmp_path / "old").is_dir()


@pytest.mark.parametrize("name", ["sequencer", "logger", "control"])
def test_a_file_of_the_user_is_left_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(TfsatError, match=f"{name} is in the way"):
        ServedFolder(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


def test_a_path_too_long_for_a_socket_is_said(tmp_path: Path, server: RobotServer) -> None:
    with pytest.raises(TfsatError, match="too long") as caught:
        # A socket's path may have some hundred characters.
        ControlSocket(tmp_path / ("x" * 120), server)
    assert "--dir" in caught.value.next_step


def test_windows_is_told_what_to_use_instead() -> None:
    with pytest.raises(TfsatError, match="Windows") as caught:
        require_pseudo_terminals("win32")
    assert "--emulated" in caught.value.next_step
    require_pseudo_terminals("linux")


def test_a_folder_is_being_started_until_its_control_socket_is_there(tmp_path: Path) -> None:
    port = tmp_path / "robot" / "sequencer"
    assert not being_started(port)
    folder = ServedFolder(tmp_path / "robot")
    assert being_started(port)
    # The control socket is the last thing that a start makes.
    folder.control.touch()
    assert not being_started(port), "a missing port has its cable pulled now"
    folder.control.unlink()
    folder.release()
    assert not being_started(port)
