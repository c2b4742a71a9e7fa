"""Types a scenario's commands in this process and collects what they printed and left."""

from __future__ import annotations

import contextlib
import io
import json
import lzma
import re
import shlex
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.contract.outline import outline, without_moments, without_numbers
from tests.contract.outline_file import outline_file
from tests.contract.scenarios import SCENARIOS, SERVED
from tests.emulated.served import Served
from tfsat_host import __version__
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.main import main
from tfsat_host.cli.parser import parser_with
from tfsat_host.report import figures
from tfsat_host.run import drop_report

BUNDLE = Path(__file__).parent / "0.2.0/drop.tfsat.zip.xz"
FOLDER = "/tmp/contract-"
"""Of the same length everywhere, as lines are filled with it."""
_DRAWN = "x" * 8
_HEXADECIMAL = re.compile(r"\b([0-9a-f]{64}|[0-9a-f]{16}|[0-9a-f]{12}|[0-9a-f]{8})\b")
_AGE_OR_MOMENT = re.compile(r"\b\d+(?= days\b)|\b20\d\d-?\d\d-?\d\d(T\d{6}(\.\d+|Z)?)?|\b\d\d:\d\d(:\d\d)?\b")

Result = dict[str, Any]
"""Of one line: `typed`; and `exit`, `document` and `files`, or the `text` that says all of them."""


class Terminal(io.StringIO):
    """A terminal of 80 columns that cannot move its cursor: bars and live views show their last state alone."""

    def isatty(self) -> bool:
        return True


def unpack_drop(folder: Path) -> None:
    """Put `drop.tfsat.zip`, and its `run/`, into a folder."""
    bundle = folder / "drop.tfsat.zip"
    bundle.write_bytes(lzma.decompress(BUNDLE.read_bytes()))
    with zipfile.ZipFile(bundle) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("run/")])


def run_scenario(scenario: str) -> list[Result]:
    """Type all lines of a scenario in a folder of its own and return the result of each."""
    with _folder() as folder, contextlib.chdir(folder), pytest.MonkeyPatch.context() as patch:
        unpack_drop(folder)
        (folder / "next").mkdir()
        for name in ("maneuver.toml", "robot.toml", "calibration-emulated.toml"):
            shutil.copy(folder / "run" / name, folder / "next")
        # What figures show is proved by tests/report/test_figures.py; here only where they lie.
        patch.setattr(
            drop_report,
            "write_figure",
            lambda _name, _content, _format, path: path.write_bytes(figures.MARKER),
        )
        # 80 columns and no cursor: the terminal that a screen must fit.
        patch.setenv("COLUMNS", "80")
        patch.setenv("TERM", "dumb")
        # No port of this computer may reach a recorded result.
        patch.setattr("serial.tools.list_ports.comports", lambda *_args, **_options: [])
        # How fast a computer answers that runs other tests meanwhile is nobody's contract.
        patch.setattr("tfsat_host.preflight.checks.timing._off", lambda _pace: (0.0, 0.0))
        outlined: dict[str, str] = {}
        with Served() if scenario in SERVED else contextlib.nullcontext():
            results = [_type_line(line, folder, outlined) for line in SCENARIOS[scenario]]
    if scenario in SERVED:
        return [_without_sizes(result) for result in results]
    return results


def _without_sizes(result: Result) -> Result:
    """Remove the numbers and file sizes from a served board's result: they change from run to run."""
    if "text" in result:
        return result
    files = {
        name: "(a file)" if isinstance(content, dict) and set(content) == {"bytes"} else content
        for name, content in result["files"].items()
    }
    return {**result, "document": without_numbers(result["document"]), "files": files}


@contextlib.contextmanager
def _folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix=Path(FOLDER).name, dir=Path(FOLDER).parent) as folder_name:
        yield Path(folder_name)


def _type_line(line: str, folder: Path, outlined: dict[str, str]) -> Result:
    """Run a line and return its result.

    Of two files with the same keys and columns, the second is only named.
    """
    before = _stamps(folder)
    argv = shlex.split(line)
    code, printed, transcript = _run(argv)
    files: dict[str, Any] = {}
    for name, stamp in _stamps(folder).items():
        # Written by this line: new, or with another time or size.
        if before.get(name) != stamp:
            content, alias = outline_file(folder / name, str(folder)), without_moments(name)
            # A file like an earlier one is recorded by reference: one change shows in one place.
            first = outlined.setdefault(json.dumps(without_numbers(content)), alias)
            files[alias] = content if first == alias else f"like {first}"
    files = dict(sorted(files.items()))
    if "--json" in argv:
        document = outline(_document(printed), str(folder))
        # A file with the document of --json needs no second copy.
        same = without_numbers(document)
        files = {name: "the document" if content == same else content for name, content in files.items()}
        return {"typed": line, "exit": code, "document": document, "files": files}
    written = "".join(f"wrote {name}\n" for name in files)
    return {
        "typed": line,
        "text": f"$ tfsat-host {line}\n{_without_moments(transcript, folder)}exit {code}\n{written}",
    }


def _run(argv: list[str]) -> tuple[int, str, str]:
    """Exit code, what was printed to stdout, and both streams as a terminal shows them."""
    if "--json" in argv:
        out, err = io.StringIO(), io.StringIO()
    else:
        # One stream, as a terminal shows both in the order of writing.
        out = err = Terminal()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(argv)
    transcript = out.getvalue() if out is err else out.getvalue() + err.getvalue()
    assert "Traceback" not in transcript and "a bug of its own" not in transcript, (argv, transcript)
    return code, out.getvalue(), transcript


def _document(printed: str) -> Any:
    """Parse the one object, or the objects of a stream."""
    objects = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    return objects[0] if len(objects) == 1 else objects


def _without_moments(transcript: str, folder: Path) -> str:
    """Replace the run-dependent parts of a text by as many characters, as lines are filled with it."""
    transcript = transcript.replace(str(folder), FOLDER + _DRAWN).replace(__version__, "VERSION")
    transcript = re.sub(r"/\S*/robots/", "ROBOTS/", transcript)
    transcript = _HEXADECIMAL.sub(lambda id_: "x" * len(id_[0]), transcript)
    transcript = _AGE_OR_MOMENT.sub(lambda moment: re.sub(r"\d", "0", moment[0]), transcript)
    return "".join(f"{line.rstrip()}\n" for line in transcript.splitlines())


def _stamps(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_size)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "robot" and not path.name.startswith(".")
    }


def options_of_all_commands() -> dict[str, dict[str, str]]:
    """Return each command's arguments: by its name a line of what each takes."""
    parser, _ = parser_with(HELPS)
    return dict(_options("tfsat-host", parser))


def _options(command: str, parser: Any) -> Iterator[tuple[str, dict[str, str]]]:
    options: dict[str, str] = {}
    for action in parser._actions:
        if action.choices and hasattr(action, "add_parser"):
            for name, child in action.choices.items():
                yield from _options(f"{command} {name}".removeprefix("tfsat-host "), child)
            continue
        name = " ".join(action.option_strings) or action.dest
        properties = {
            "takes": action.nargs,
            "default": action.default,
            "one of": list(map(str, action.choices or ())),
        }
        descriptions = [
            f"{key} {value}" for key, value in properties.items() if value not in (None, [], "==SUPPRESS==")
        ]
        options[name] = ", ".join([*(["required"] if action.required else []), *descriptions])
    yield command, options
