"""What commands print fits any terminal: no word, number with its ± or command to type is broken, no blanks trail."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.evaluation.run_folder import made_folder
from tfsat_host.present.wrapping import fill_lines, unbreakable_chunks, wrap_line

WIDTHS = (60, 80, 120)
WIDE = 1000
COMMANDS = (
    "--help",
    "design --help",
    "robot",
    "robot cubesat_3u",
    "robot nowhere.toml",
    "ports",
    "status --emulated",
    "upload-sequence 59 70 --emulated",
    "upload-sequence 59 --emulated",
    "upload-sequence 59 70 --speed 400 --dry-run",
    "upload-servos --neutral 1500 1500 1500 --emulated --yes",
    "logger-settings show --emulated",
    "logger-settings set --rate 200 --emulated --yes",
    "record start --emulated",
    "arm --emulated",
    "disarm --emulated",
    "jog --joint 1 --from 0 --to 5 --emulated --yes",
    "log list --emulated",
    "log",
    "calibrate show",
    "calibrate show --out run/calibration-emulated.toml",
    "calibrate show --full --out run/calibration-emulated.toml",
    "calibrate bias --emulated --yes --out other.toml",
    "preflight run --emulated --yes",
    "preflight next --emulated --yes",
    "envelope 59 70",
    "simulate 59 70",
    "design --time-limit 1.2 --particles 8 --iterations 4",
    "sensitivity 59 70 --samples 60 --workers 1",
    "plan --target z:20 --robot cubesat_3u --grid 30 --tolerance 5",
    "decode run/SD.bin --out decoded",
    "evaluate run",
    "evaluate run second",
    "evaluate nowhere",
    "report run",
    "bundle run --out drop.tfsat.zip",
    "reproduce drop.tfsat.zip",
    "campaign init camp",
    "campaign add camp run",
    "campaign list camp",
    "campaign report camp",
    "rehearse 59 70 --seed 3 --out rehearsed",
    "rehearse 59 70 --seed 3 --fault switch-stuck-closed --out faulted",
    "rehearse --list-faults",
    "flash --list",
    "rehaerse 59 70",
)


COSTLY = (
    "evaluate run second",
    "reproduce",
    "design --time",
    "rehearse 59",
    "bundle",
    "campaign report",
    "report",
)
"""These are run at the narrowest width only: what fits there fits elsewhere."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("widths")
    shutil.copytree(made_folder(), place / "run")
    shutil.copytree(made_folder(2), place / "second")
    (place / "next").mkdir()
    for name in ("maneuver.toml", "calibration-emulated.toml"):
        shutil.copy(made_folder() / name, place / "next")
    return place


OF_A_BUSY_CLOCK = {"off", "within", "of"}
"""A preflight says `within 0.1 s of it` or `+0.2 s off it`, by how long a busy computer took to ask."""


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_breaks_a_word(folder: Path, tmp_path: Path, command: str) -> None:
    shutil.copytree(folder, tmp_path / "copy")
    wide = _output_lines(tmp_path / "copy", command, WIDE)
    wide_words = set(_words(wide))
    commands = [
        chunk for line in wide for chunk in unbreakable_chunks(line.split()) if "tfsat-host " in chunk
    ]
    for columns in WIDTHS[:1] if command.startswith(COSTLY) else WIDTHS:
        again = tmp_path / f"{columns}"
        shutil.copytree(folder, again)
        narrow = _output_lines(again, command, columns)
        assert [line for line in narrow if line != line.rstrip()] == []
        assert [line for line in narrow if len(line) > columns and not _is_one_chunk(line)] == []
        assert sorted(set(_words(narrow)) - wide_words - OF_A_BUSY_CLOCK) == []
        text = "\n".join(narrow)
        assert [chunk for chunk in commands if chunk.rstrip(".,;:)") not in text] == []


@pytest.mark.parametrize("columns", WIDTHS)
def test_every_quantity_of_calibrate_has_its_text_in_one_column(tmp_path: Path, columns: int) -> None:
    """The longest one, misalignment, has it on its own line, beside the others."""
    for command, rows in (
        ("calibrate", r" +tfsat-host calibrate (?=[a-z])\S+ +"),
        ("calibrate --help", r"    (?=[a-z])\S+ +"),
    ):
        lines = _output_lines(tmp_path, command, columns)
        texts = {match[0].split()[-1]: match.end() for line in lines if (match := re.match(rows, line))}
        assert {"bias", "misalignment", "show"} <= set(texts)
        assert len(set(texts.values())) == 1, lines


def _output_lines(folder: Path, command: str, columns: int) -> list[str]:
    for earlier in _earlier(command):
        RunCli(folder)(*earlier.split(), expect=None)
    environ = {"COLUMNS": str(columns), "XDG_STATE_HOME": str(folder / "state")}
    process = RunCli(folder)(*command.split(), expect=None, environ=environ)
    return [*process.stdout.splitlines(), *process.stderr.splitlines()]


def _earlier(command: str) -> Iterator[str]:
    """Yield the commands that make the files which `command` needs."""
    if command.startswith("reproduce"):
        yield "bundle run --out drop.tfsat.zip"
    if command.startswith("campaign") and "init" not in command:
        yield "campaign init camp"
        if "add" not in command:
            yield "campaign add camp run"


def _words(lines: list[str]) -> Iterator[str]:
    """Yield all words except the numbers and names that differ from run to run."""
    for line in lines:
        for word in line.split():
            if not re.search(r"[\d─━╸█▏▎▍▌▋▊▉]", word):
                yield word


def _is_one_chunk(line: str) -> bool:
    return len(unbreakable_chunks(re.sub(r"^\s*(- |\S.{0,40}?\s{2,})?", "", line).split())) == 1


def test_a_command_to_type_stays_whole() -> None:
    text = "Look at it: tfsat-host evaluate run --maneuver maneuver.toml, then disarm and arm again."
    lines = fill_lines(text, 30)
    assert "tfsat-host evaluate run --maneuver maneuver.toml," in lines
    assert all(len(line) <= 30 for line in lines if "tfsat-host" not in line)


def test_a_label_indents_what_follows() -> None:
    assert wrap_line("Calibrated  a certificate of the drop tower robot, which holds", 40) == [
        "Calibrated  a certificate of the drop",
        "            tower robot, which holds",
    ]
