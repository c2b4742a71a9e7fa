"""The completion scripts, completing in the shells themselves."""

from __future__ import annotations

import json
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.completion import SHELLS, completion_script
from tfsat_host.rehearsal.faults.fault_catalog import FAULTS

Complete = Callable[..., set[str]]

# What readline does on Tab, without its terminal: the words, the place in them, and the registered function.
_TAB = """
source {script}
compopt() {{ :; }}  # there is no line to set options of
COMP_WORDS=({words})
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
_shtab_tfsat_host
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def _shell(*args: str, folder: Path | None = None) -> str:
    process = subprocess.run(args, cwd=folder, capture_output=True, text=True, timeout=60, check=True)
    # An error inside a completion would appear in the middle of what the user types.
    assert process.stderr == ""
    return process.stdout


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("completion")
    for shell in SHELLS:
        (folder / shell).write_text(completion_script(shell) + "\n", encoding="utf-8")
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Create the files and the folder among which names are completed."""
    (tmp_path / "maneuver.toml").touch()
    (tmp_path / "SD.bin").touch()
    (tmp_path / "run").mkdir()
    return tmp_path


def _in_bash(scripts: Path, folder: Path, *words: str) -> set[str]:
    command_line = " ".join(shlex.quote(word) for word in ("tfsat-host", *words))
    code = _TAB.format(script=shlex.quote(str(scripts / "bash")), words=command_line)
    # --norc: the completion must work without this computer's own settings.
    return set(_shell("bash", "--norc", "-c", code, folder=folder).split())


def _in_fish(scripts: Path, folder: Path, *words: str) -> set[str]:
    line = shlex.quote(" ".join(("tfsat-host", *words)))
    code = f"source {shlex.quote(str(scripts / 'fish'))}; complete -C {line}"
    return {row.split("\t")[0] for row in _shell("fish", "-N", "-c", code, folder=folder).splitlines()}


# Every script is written and read as text; only the installed shells can run theirs.
INSTALLED = [shell for shell in SHELLS if shutil.which(shell)]
COMPLETING = [complete for complete in (_in_bash, _in_fish) if complete.__name__.split("_")[-1] in INSTALLED]


@pytest.mark.parametrize("shell", INSTALLED)
def test_the_shell_can_read_its_script(scripts: Path, shell: str) -> None:
    _shell(shell, "-n", str(scripts / shell))


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_is_in_the_script(scripts: Path, shell: str) -> None:
    script = (scripts / shell).read_text(encoding="utf-8")
    for command in HELPS:
        assert command in script


@pytest.mark.parametrize("complete", COMPLETING)
class TestCompletion:
    def test_commands(self, complete: Complete, scripts: Path, folder: Path) -> None:
        assert complete(scripts, folder, "") >= HELPS.keys()
        assert complete(scripts, folder, "upload-s") == {"upload-sequence", "upload-servos"}

    def test_actions_and_choices(self, complete: Complete, scripts: Path, folder: Path) -> None:
        assert complete(scripts, folder, "log", "") >= {"list", "fetch", "erase"}
        assert complete(scripts, folder, "completion", "") >= set(SHELLS)
        assert complete(scripts, folder, "rehearse", "--sequencer", "") == {"native", "avr"}

    def test_faults_of_a_rehearsal(self, complete: Complete, scripts: Path, folder: Path) -> None:
        assert complete(scripts, folder, "rehearse", "--fault", "gyro-") >= {"gyro-dead", "gyro-frozen"}
        assert complete(scripts, folder, "rehearse", "59", "70", "--fault", "card-") == {
            fault.name for fault in FAULTS if fault.name.startswith("card-")
        }

    def test_options_of_the_command(self, complete: Complete, scripts: Path, folder: Path) -> None:
        assert complete(scripts, folder, "upload-sequence", "--em") == {"--emulated"}
        # Options of one command must not be offered at another.
        assert "--unrecorded" in complete(scripts, folder, "arm", "--")
        assert "--unrecorded" not in complete(scripts, folder, "disarm", "--")

    def test_files_folders_and_ports(self, complete: Complete, scripts: Path, folder: Path) -> None:
        assert {name.rstrip("/") for name in complete(scripts, folder, "decode", "")} >= {"SD.bin", "run"}
        assert complete(scripts, folder, "upload-sequence", "--file", "man") == {"maneuver.toml"}
        out = complete(scripts, folder, "decode", "SD.bin", "--out", "")
        assert {name.rstrip("/") for name in out} == {"run"}
        port = complete(scripts, folder, "status", "--port", "ru")
        assert "run" in {name.rstrip("/") for name in port}


def test_the_command_prints_the_script(tfsat_host: RunCli, scripts: Path) -> None:
    process = tfsat_host("completion", "zsh")
    assert process.stdout == (scripts / "zsh").read_text(encoding="utf-8")
    assert process.stderr == ""
    answer = json.loads(tfsat_host("completion", "fish", "--json").stdout)
    assert answer["shell"] == "fish"
    assert answer["script"].startswith("#")


def test_an_unknown_shell_is_named(tfsat_host: RunCli) -> None:
    assert "tcsh" in tfsat_host("completion", "tcsh", expect=2).stderr
