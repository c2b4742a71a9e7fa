"""Commands that are recommended: each can be typed, and has what the running command was given."""

from __future__ import annotations

import ast
import pickle
import shlex
from argparse import ArgumentParser, Namespace
from functools import partial
from pathlib import Path

import pytest

import tfsat_host
from tfsat_host.cli.calibrate.arguments import resume_command
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.next_steps import complete_command
from tfsat_host.cli.parser import parser_with
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.next_step import Advice, NextStep

SOURCES = sorted(Path(tfsat_host.__file__).parent.rglob("*.py"))


def recommended_commands() -> list[tuple[str, NextStep]]:
    """Return each `NextStep` of the sources whose command is a literal, with its place; what is computed is `x`."""
    steps = []
    for source in SOURCES:
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "NextStep":
                command, *rest = node.args
                words = rest[0].elts if rest and isinstance(rest[0], ast.Tuple) else []
                if isinstance(command, ast.Constant):
                    arguments = (str(word.value) if isinstance(word, ast.Constant) else "x" for word in words)
                    steps.append(
                        (f"{source.name}:{node.lineno}", NextStep(str(command.value), tuple(arguments)))
                    )
    return steps


def test_every_recommended_command_exists_with_its_options() -> None:
    steps = recommended_commands()
    assert len(steps) > 250
    assert [place for place, step in steps if step.command.split()[0] not in HELPS] == []
    parsers = {name: parser_with((name,))[0] for name in {step.command.split()[0] for _, step in steps}}
    for place, step in steps:
        words = step.command.split()
        options = {word for word in step.arguments if word.startswith("--")}
        assert options <= {*option_names(parsers[words[0]], words)}, f"{place}: {step}"


def option_names(parser: ArgumentParser, words: list[str]) -> list[str]:
    """Return the options of a command or of its action."""
    names: list[str] = []
    for action in parser._actions:
        names += action.option_strings
        if isinstance(action.choices, dict) and words and words[0] in action.choices:
            names += option_names(action.choices[words[0]], words[1:])
    return names


@pytest.mark.parametrize(
    ("options", "step", "command"),
    [
        ({"command": "jog", "port": "/dev/a b"}, "disarm", "tfsat-host disarm --port '/dev/a b'"),
        ({"command": "jog", "port": "/dev/a"}, "log fetch ram", "tfsat-host log fetch ram"),
        ({"command": "record", "port": "/dev/a"}, "status", "tfsat-host status --port /dev/a"),
        ({"command": "status", "port": "/dev/a"}, "log fetch ram", "tfsat-host log fetch ram --port /dev/a"),
        ({"command": "status", "emulated": True}, "log fetch ram", "tfsat-host log fetch ram --emulated"),
        ({"command": "status", "port": "/dev/a"}, "decode SD.bin", "tfsat-host decode SD.bin"),
        ({"command": "evaluate", "runs": [Path("SD.bin")]}, "decode", "tfsat-host decode SD.bin"),
        ({"command": "evaluate", "runs": [Path("A.bin"), Path("B.bin")]}, "decode", "tfsat-host decode"),
        (
            {"command": "decode", "file": Path("SD.bin")},
            "decode --format parquet",
            "tfsat-host decode SD.bin --format parquet",
        ),
        ({"command": "status", "port": "/dev/a"}, "jog --help", "tfsat-host jog --help"),
        ({"command": "jog", "port": "/dev/a"}, "arm --port /dev/b", "tfsat-host arm --port /dev/b"),
        (
            {"command": "flash", "board": "logger", "hex": Path("a.hex"), "port": "/dev/a"},
            "flash logger --force",
            "tfsat-host flash logger --force --hex a.hex --port /dev/a",
        ),
        (
            {
                "command": "calibrate",
                "port": "a",
                "sequencer_port": "b",
                "out": Path("c.toml"),
                "robot": None,
            },
            "calibrate servo --joint 2",
            "tfsat-host calibrate servo --joint 2 --out c.toml --port a --sequencer-port b",
        ),
        (
            {
                "command": "calibrate",
                "port": "a",
                "sequencer_port": "b",
                "out": None,
                "robot": Path("r.toml"),
            },
            "calibrate zero --joint 2",
            "tfsat-host calibrate zero --joint 2 --robot r.toml --port a",
        ),
        (
            {"command": "calibrate", "port": "a", "sequencer_port": "b", "out": None, "robot": None},
            "calibrate show",
            "tfsat-host calibrate show",
        ),
        (
            {"command": "preflight", "port": "a", "logger_port": "b"},
            "preflight run1",
            "tfsat-host preflight run1 --port a --logger-port b",
        ),
    ],
)
def test_a_command_gets_what_the_running_one_was_given(
    options: dict[str, object], step: str, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("SD.bin", "A.bin", "B.bin"):
        Path(name).touch()
    words = shlex.split(step)
    actions = 2 if words[0] in ("log", "flash", "calibrate") else 1
    advice = Advice("Then: ", NextStep(" ".join(words[:actions]), tuple(words[actions:])), ".")
    args = Namespace(**{"emulated": False, "port": None, **options})
    assert advice.with_commands(partial(complete_command, args=args)) == f"Then: {command}."


def test_a_calibration_goes_on_with_the_words_that_began_it() -> None:
    args = Namespace(quantity="servo", joint=2, no_upload=True, anew=True, jog=False, turn=None)
    assert str(resume_command(args)) == "tfsat-host calibrate servo --joint 2 --no-upload --resume"
    args = Namespace(quantity="zero", joint=None, all=True, anew=True)
    assert str(resume_command(args)) == "tfsat-host calibrate zero --all --anew --resume"


def test_advice_is_a_text_whose_commands_survive_joining_and_another_process() -> None:
    advice = Advice("First ", NextStep("disarm"), ".")
    joined = pickle.loads(pickle.dumps(Advice(advice, " Then again.")))
    assert joined == "First tfsat-host disarm. Then again."
    assert joined.parts == ("First ", NextStep("disarm"), ".", " Then again.")


def test_an_error_in_other_words_is_the_same_error_and_leaves_the_first_as_it_was() -> None:
    error = PortError(PortProblem.MISSING, what="No port.", next_step="Plug it in.")
    other = error.with_words(meaning="Nothing was sent.")
    assert (
        type(other) is PortError and other.code == PortProblem.MISSING and other.exit_code == error.exit_code
    )
    assert (other.what, other.meaning, other.next_step) == ("No port.", "Nothing was sent.", "Plug it in.")
    assert error.meaning != other.meaning
