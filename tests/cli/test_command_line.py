"""What every command shares: help, exit codes, streams, and what happens when something breaks."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pty
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

import pytest

from tests.cli.process import RunCli
from tests.paths import REPOSITORY
from tfsat_host.cli import envelope, ports, upload_sequence
from tfsat_host.cli.commands import EXAMPLES, GROUPS, HELPS
from tfsat_host.cli.main import main
from tfsat_host.cli.parser import module_of, parser_with
from tfsat_host.errors import RefusedError, TfsatError, UsageError
from tfsat_host.robot import default_robot_path

# What takes longest to import, and what not every computer has.
HEAVY = ("numpy", "scipy", "rich", "serial", "matplotlib", "hypothesis")
_HELP_THEN_MODULES = """
import sys
from tfsat_host.cli.main import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
print(" ".join(sorted(sys.modules)), file=sys.stderr)
"""


def _modules_after(*args: str) -> set[str]:
    process = subprocess.run(
        [sys.executable, "-c", _HELP_THEN_MODULES, *args], capture_output=True, text=True, check=True
    )
    # The help was really printed.
    assert "usage: tfsat-host" in process.stdout
    return set(process.stderr.split())


def test_help_imports_nothing_heavy() -> None:
    modules = _modules_after("--help")
    assert modules.isdisjoint(HEAVY)
    assert modules.isdisjoint(map(module_of, HELPS))


@pytest.mark.parametrize("said", [None, "2"])
def test_linear_algebra_has_one_thread_unless_the_user_says_otherwise(said: str | None) -> None:
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_THREADS")}
    if said is not None:
        environment["OPENBLAS_NUM_THREADS"] = said
    # After the console script's module was imported, as the script does.
    program = "import tfsat_host.cli.start, os; print(os.environ['OPENBLAS_NUM_THREADS'])"
    answer = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment
    )
    assert answer.stdout.strip() == (said or "1")


def test_help_on_a_terminal_does_not_wait_for_rich() -> None:
    master, slave = pty.openpty()
    process = subprocess.run(
        [sys.executable, "-c", _HELP_THEN_MODULES, "--help"], stdout=slave, stderr=subprocess.PIPE, check=True
    )
    os.close(slave)
    terminal_output = os.read(master, 4096)
    os.close(master)
    assert b"usage: tfsat-host" in terminal_output
    assert set(process.stderr.decode().split()).isdisjoint(HEAVY)


def test_the_help_of_a_command_on_a_terminal_is_coloured() -> None:
    # A terminal of its own: colours are for people.
    master, slave = pty.openpty()
    environ = {name: value for name, value in os.environ.items() if name != "NO_COLOR"} | {"TERM": "xterm"}
    subprocess.run(
        [sys.executable, "-m", "tfsat_host", "ports", "--help"], stdout=slave, env=environ, check=True
    )
    os.close(slave)
    terminal_output = os.read(master, 4096)
    os.close(master)
    assert b"\x1b[" in terminal_output


def test_the_help_of_a_command_imports_nothing_heavy() -> None:
    """Import nothing heavy for a command's help.

    One process runs all commands: the first that imports something heavy is named.
    """
    code = f"""
import sys
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.main import main
for command in HELPS:
    try:
        main([command, "--help"])
    except SystemExit:
        heavy = sys.modules.keys() & set({HEAVY})
        if heavy:
            sys.exit(f"{{command}} --help imports {{heavy}}")
"""
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert process.stdout.count("usage: tfsat-host ") == len(HELPS)
    assert process.stderr == ""


def test_help_names_every_command_and_every_exit_code(tfsat_host: RunCli) -> None:
    text = tfsat_host("--help").stdout
    for command in HELPS:
        assert command in text
    text = " ".join(text.split())
    for words in ("0 done", "1 failed", "2 usage", "3 done but", "4 refused", "130 interrupted"):
        assert words in text


def test_the_helps_groups_are_the_readmes() -> None:
    readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (the \w+) \| (`.+`) \|$", readme, re.MULTILINE)
    assert {group: [*commands] for group, commands in GROUPS.items()} == {
        group: re.findall(r"`([\w-]+)`", words) for group, words in rows
    }


@pytest.mark.parametrize("command", HELPS)
def test_a_commands_help_ends_with_an_example_that_can_be_typed(command: str, tfsat_host: RunCli) -> None:
    words = shlex.split(EXAMPLES[command])
    # The example is parsed by the parser that the command has.
    assert parser_with((command,))[0].parse_args(words).command == command
    assert tfsat_host(command, "--help").stdout.endswith(f"Example: tfsat-host {EXAMPLES[command]}\n")


def test_no_arguments_show_the_help(tfsat_host: RunCli) -> None:
    assert tfsat_host().stdout == tfsat_host("--help").stdout


def test_the_console_script_is_the_module(tfsat_host: RunCli) -> None:
    script = Path(sys.executable).with_name("tfsat-host")
    process = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert process.stdout == tfsat_host("--version").stdout
    assert process.stdout.startswith("tfsat-host ")


@pytest.mark.parametrize(
    "args",
    [
        ("fly",),
        ("--nonsense",),
        ("ports", "--nonsense"),
        ("ports", "extra"),
        ("upload-sequence",),
        ("upload-sequence", "59"),
        ("upload-sequence", "59", "seventy"),
        ("upload-sequence", "59", "70,5"),
        ("upload-sequence", "5_9", "70"),
        ("upload-sequence", "59", "70", "59"),
        ("upload-sequence", "59", "70", "--port", "x", "--emulated"),
        ("upload-sequence", "59", "70", "--file", "x.toml"),
        ("upload-sequence", "--speed", "170", "--file", "x.toml"),
        ("upload-sequence", "59", "70", "--dry"),
    ],
)
def test_usage_errors(tfsat_host: RunCli, args: tuple[str, ...]) -> None:
    plain = tfsat_host(*args, expect=2)
    assert plain.stdout == ""
    assert plain.stderr.startswith("Error: ")
    error = tfsat_host.json(*args, expect=2)["error"]
    # The plain text and the JSON say the same.
    assert error["what"].replace(" --json", "") in plain.stderr
    assert "tfsat-host" in error["next_step"]


def test_exit_codes_of_the_errors() -> None:
    codes = {kind.__name__: kind.exit_code for kind in (TfsatError, UsageError, RefusedError)}
    assert codes == {"TfsatError": 1, "UsageError": 2, "RefusedError": 4}
    error = RefusedError(what="Switch 1 is open.", meaning="It would start.", next_step="Close it.")
    assert str(error) == "Switch 1 is open.\nIt would start.\nClose it."


def _ports_raise(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def fail() -> NoReturn:
        raise error

    monkeypatch.setattr(ports, "system_ports", fail)


@pytest.mark.parametrize(("kind", "code"), [(TfsatError, 1), (UsageError, 2), (RefusedError, 4)])
def test_an_error_of_a_command_ends_with_its_code_and_its_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kind: type[TfsatError], code: int
) -> None:
    _ports_raise(monkeypatch, kind(what="A.", meaning="B.", next_step="C."))
    assert main(["ports"]) == code
    # Three lines: what happened, what it means, what to do.
    assert capsys.readouterr() == ("", "Error: A.\n  B.\n  C.\n")
    assert main(["ports", "--json"]) == code
    output = capsys.readouterr()
    assert json.loads(output.out) == {"error": {"what": "A.", "meaning": "B.", "next_step": "C."}}
    assert output.err == ""


def test_interrupted(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    _ports_raise(monkeypatch, KeyboardInterrupt())
    assert main(["ports"]) == 130
    assert capsys.readouterr().err.startswith("Error: Interrupted.")


def test_a_bug_is_kept_in_a_file_and_shown_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _ports_raise(monkeypatch, ZeroDivisionError("by zero\nsecond line"))
    assert main(["ports"]) == 1
    error_text = capsys.readouterr().err
    assert "Traceback" not in error_text
    assert "ZeroDivisionError: by zero\n" in error_text
    path = Path(error_text.strip().rpartition("the file ")[2])
    # Below the user's home, where a report is looked for.
    assert path.is_relative_to(os.environ["HOME"])
    text = path.read_text()
    assert "Traceback" in text
    assert "arguments: ['ports']" in text


def test_a_bug_is_kept_elsewhere_when_the_state_folder_cannot_be_made(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    # Neither state folder nor home can be made: the temporary folder is left.
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    _ports_raise(monkeypatch, ZeroDivisionError())
    assert main(["ports"]) == 1
    assert Path(capsys.readouterr().err.strip().rpartition("the file ")[2]).parent == tmp_path


def test_an_error_of_the_system_is_no_bug(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _ports_raise(monkeypatch, OSError(28, "No space left on device", "SD.csv"))
    assert main(["ports"]) == 1
    assert capsys.readouterr().err.startswith("Error: SD.csv: No space left on device.\n")


def test_a_terminal_without_unicode_is_served(tfsat_host: RunCli) -> None:
    ascii_only = {"PYTHONIOENCODING": "ascii"}
    process = tfsat_host("upload-sequence", 59, 70, "--dry-run", environ=ascii_only, process=True)
    assert "Ends 2.23 s" in process.stdout
    refused = tfsat_host(
        "upload-sequence", 59, 70, "--file", "é.toml", expect=2, environ=ascii_only, process=True
    )
    assert refused.stderr.startswith("Error: ")


def test_a_reader_that_has_gone_is_no_error_message() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    process = subprocess.run(
        [sys.executable, "-m", "tfsat_host", "ports", "--json"],
        stdout=writing,
        stderr=subprocess.PIPE,
        check=False,
    )
    os.close(writing)
    assert (process.returncode, process.stderr) == (1, b"")


@pytest.mark.parametrize(
    ("args", "closed"),
    [
        ("--help", ">&-"),
        ("ports", "<&-"),
        ("ports --json", ">&-"),
        ("ports --help", ">&-"),
        # All three streams closed: nothing can be said, and nothing may break.
        ("upload-sequence 59 70 --emulated", "<&- >&- 2>&-"),
        ("fly", "2>&-"),
    ],
)
def test_closed_streams_are_no_bug(args: str, closed: str, tmp_path: Path) -> None:
    process = subprocess.run(
        ["sh", "-c", f'exec "$0" -m tfsat_host {args} {closed}', sys.executable],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == (2 if args == "fly" else 0), process.stderr
    assert "bug" not in process.stderr
    assert "Traceback" not in process.stderr


def test_help_takes_little_more_than_an_interpreter() -> None:
    """Less than four times the processor time of a Python that does nothing: 0.06 s where that takes 0.026 s."""
    script = str(Path(sys.executable).with_name("tfsat-host"))
    # The best of five, in turns: what else the computer does only makes them slower.
    helps, empty = zip(
        *(
            (_processor_seconds(script, "--help"), _processor_seconds(sys.executable, "-c", ""))
            for _ in range(5)
        ),
        strict=True,
    )
    assert min(helps) < 4.0 * min(empty)


def _processor_seconds(program: str, *args: str) -> float:
    """User and system time of one process."""
    null = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    process = os.posix_spawn(program, [program, *args], os.environ, file_actions=null)
    _, status, usage = os.wait4(process, 0)
    assert status == 0
    return usage.ru_utime + usage.ru_stime


def test_interrupted_where_no_board_could_be(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_args: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr(envelope, "run", interrupt)
    assert main(["envelope", "59", "70"]) == 130
    assert "board" not in capsys.readouterr().err
    monkeypatch.setattr(upload_sequence, "run", interrupt)
    assert main(["upload-sequence", "59", "70"]) == 130
    assert "No board was connected: run" in capsys.readouterr().err


@pytest.mark.parametrize("command", HELPS)
def test_every_command_takes_a_negative_number_for_a_value(
    command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """argparse itself takes -5 for a value, but -5,60,20 and -1e3 for unknown options."""
    parsed_arguments: list[list[str]] = []
    module = importlib.import_module(module_of(command))

    def configure(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--many", nargs=2)

    def run(args: argparse.Namespace, _out: object) -> int:
        parsed_arguments.append(args.many)
        return 0

    monkeypatch.setattr(module, "configure", configure)
    monkeypatch.setattr(module, "run", run)
    assert main([command, "--many", "-5,60,20", "-1e3"]) == 0
    assert parsed_arguments == [["-5,60,20", "-1e3"]]


@pytest.mark.parametrize(
    "module", ["tfsat_host.cli.commands", "tfsat_host.errors", "argparse", "tfsat_host.cli.robot"]
)
def test_ctrl_c_while_a_module_is_imported_shows_no_traceback(module: str) -> None:
    script = f"""
import sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            raise KeyboardInterrupt

sys.modules.pop({module!r}, None)
sys.meta_path.insert(0, Interrupting())
from tfsat_host.cli.main import main
sys.exit(main(["robot"]))
"""
    process = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60
    )
    assert process.stdout == "" and "Interrupted." in process.stderr and "Traceback" not in process.stderr
    assert process.returncode in (130, -signal.SIGINT)


def test_names_in_files_and_of_files_do_not_steer_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evil = "\x1b]0;owned\x07\u202e"
    text = default_robot_path().read_text(encoding="utf-8")
    file = tmp_path / f"robot{evil}.toml"
    # The name in the file, and the file's own name.
    named = re.sub("^name = .*$", r'name = "\\u001b[31mred\\u202e"', text, count=1, flags=re.MULTILINE)
    file.write_text(named, encoding="utf-8")
    for argv in (
        ["robot", str(file)],
        ["simulate", "59", "70", "--robot", str(file)],
        ["sensitivity", "59", "70", "--samples", "10", "--robot", str(file)],
        ["evaluate", f"nothing{evil}"],
        ["decode", f"nothing{evil}.bin"],
        [f"no-command{evil}"],
        ["report", f"nothing{evil}"],
        ["simulate", "--file", f"nothing{evil}.toml"],
    ):
        main(argv)
        output = "".join(capsys.readouterr())
        assert "\\x1b" in output, argv
        # Everything that reaches the terminal can be seen.
        assert all(map(str.isprintable, output.split("\n"))), argv
