"""Types a scenario's commands in this process and collects what they left."""

from __future__ import annotations

import contextlib
import io
import json
import lzma
import shlex
import shutil
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.contract.outline import file_outline, outline, without_moments, without_numbers
from tests.contract.scenarios import MOMENTARY, SCENARIOS, SERVED
from tests.emulated.served import Served
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.main import main
from tfsat_host.cli.parser import parser_with
from tfsat_host.report import figures

HERE = Path(__file__).parent
BUNDLE = HERE / "today/drop.tfsat.zip.xz"
EXPECTED = HERE / "expected"


def unpack_drop(folder: Path) -> None:
    """Puts `drop.tfsat.zip`, and its `run/`, into a folder."""
    bundle = folder / "drop.tfsat.zip"
    bundle.write_bytes(lzma.decompress(BUNDLE.read_bytes()))
    with zipfile.ZipFile(bundle) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("run/")])


def results_of(scenario: str, folder: Path) -> list[dict[str, Any]]:
    """The outline of each command's result, and of the files that it wrote or changed.

    Args:
        scenario: Its name in `SCENARIOS`.
        folder: An empty folder.
    """
    unpack_drop(folder)
    (folder / "next").mkdir()
    for name in ("maneuver.toml", "robot.toml", "calibration-emulated.toml"):
        shutil.copy(folder / "run" / name, folder / "next")
    outlined: dict[str, str] = {}
    with (
        contextlib.chdir(folder),
        pytest.MonkeyPatch.context() as patch,
        Served() if scenario in SERVED else contextlib.nullcontext(),
    ):
        # What figures show is proved by tests/report/test_figures.py; here only where they lie.
        patch.setattr(figures, "_save", lambda _figure, _kind, path: path.write_bytes(figures.MARKER))
        results = [_result_of(line, folder, outlined) for line in SCENARIOS[scenario]]
    if scenario in MOMENTARY:
        return [{**without_numbers(result), "exit": result["exit"]} for result in results]
    return results


def _result_of(line: str, folder: Path, outlined: dict[str, str]) -> dict[str, Any]:
    """A command's result; of two files that say the same the second is only named."""
    before = _stamps(folder)
    code, printed = _typed([*shlex.split(line), "--json"])
    files: dict[str, Any] = {}
    for name, stamp in _stamps(folder).items():
        if before.get(name) != stamp:
            content = file_outline(folder / name, folder)
            first = outlined.setdefault(json.dumps(content), without_moments(name))
            files[without_moments(name)] = content if first == without_moments(name) else f"as {first}"
    document = outline(_document(printed), folder)
    return {"typed": line, "exit": code, "document": document, "files": dict(sorted(files.items()))}


def options_of_all_commands() -> dict[str, Any]:
    """Each command's arguments: their names, defaults and choices."""
    parser, _ = parser_with(HELPS)
    return _options(parser)


def _options(parser: Any) -> dict[str, Any]:
    listed: dict[str, Any] = {}
    for action in parser._actions:
        if action.choices and hasattr(action, "add_parser"):
            listed |= {f"{name} …": _options(child) for name, child in action.choices.items()}
            continue
        name = " ".join(action.option_strings) or action.dest
        listed[name] = {
            "nargs": action.nargs,
            "required": action.required,
            "default": str(action.default),
            "choices": [str(choice) for choice in action.choices or ()],
        }
    return listed


def _typed(argv: list[str]) -> tuple[int, str]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(argv)
    assert "Traceback" not in err.getvalue() and "a bug of its own" not in out.getvalue(), (argv, out, err)
    return code, out.getvalue()


def _document(printed: str) -> Any:
    """The one object, or the objects of a stream."""
    objects = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    return objects[0] if len(objects) == 1 else objects


def _stamps(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_size)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "robot" and not path.name.startswith(".")
    }
