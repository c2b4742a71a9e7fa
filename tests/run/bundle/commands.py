"""`tfsat-host` in this process, evaluations that are made once, and bundles that somebody has changed."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evaluation.commanded import Said
from tests.evaluation.drops import MORNING
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration
from tfsat_host.cli.main import main
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import jsonable
from tfsat_host.maneuver import Schedule
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import BLOCK_HEADER_DTYPE
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.replay import replay_of
from tfsat_host.robot import RobotModel
from tfsat_host.run import drop_evaluation
from tfsat_host.sdlog import DropLog

_KIND = int(np.dtype(BLOCK_HEADER_DTYPE).fields["kind"][1])  # type: ignore[index]
_EVALUATIONS: dict[str, Evaluation] = {}


def _once(
    function: Callable[[Any], Any], of: Callable[[Any], Any] = lambda value: value
) -> Callable[[Any], Any]:
    """Cache the function's result for each object, or for each object that `of` makes of it."""
    cache: dict[int, tuple[Any, Any]] = {}

    def keep_result(value: Any) -> Any:
        key = of(value)
        if id(key) not in cache:
            cache[id(key)] = key, function(value)  # the object stays, and with it its id
        return cache[id(key)][1]

    return keep_result


# Curves and replay follow from the motion alone: drawn once for each motion.
_BUILDER = "tfsat_host.report.contents.document_builder"
_CACHED_BUILDERS = {
    f"{_BUILDER}.charts_of": _once(charts_of, lambda evaluation: evaluation.motion),
    f"{_BUILDER}.replay_of": _once(replay_of, lambda evaluation: evaluation.motion),
}


def keep_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cache evaluations and drawings, which are not what is tested.

    Equal samples with equal files give equal results.
    """

    def keep_evaluation(
        log: DropLog,
        model: RobotModel,
        calibration: Calibration | None,
        schedule: Schedule | None,
        **others: Any,
    ) -> Evaluation:
        certificate = None if calibration is None else format_calibration(_of_no_robot(calibration))
        options = (others["recorded"], others["swarm"], others["witnesses"])
        # Board and image identify a robot, yet nothing is computed from them.
        header = replace(log.header, board_serial=bytes(8), image_crc=0)
        samples = _sha256_of_samples(log.path)
        key = repr((samples, header, log.session, sha256_of(model.path), certificate, schedule, options))
        if key not in _EVALUATIONS:
            _EVALUATIONS[key] = evaluate(log, model, calibration, schedule, **others)
        # The command's own log and model go into the copy, so that paths and identity stay its own.
        return replace(_EVALUATIONS[key], log=log, model=model)

    monkeypatch.setattr(drop_evaluation, "evaluate", keep_evaluation)
    for name, builder in _CACHED_BUILDERS.items():
        monkeypatch.setattr(name, builder)


def _of_no_robot(calibration: Calibration) -> Calibration:
    subject = replace(calibration.subject, logger_serial="", emulated=False)
    return replace(calibration, subject=subject, simulated_quantities=(), landings=(), written=MORNING)


def _sha256_of_samples(card: Path) -> str:
    """Hash all blocks except the header's, which also identifies the robot."""
    data = card.read_bytes()
    blocks = (data[at : at + BLOCK_BYTES] for at in range(0, len(data), BLOCK_BYTES))
    return hashlib.sha256(b"".join(block for block in blocks if block[_KIND] != BlockKind.HEADER)).hexdigest()


@dataclass(frozen=True)
class CommandOutput(Said):
    """What a command did, and the object that `--json` would print."""

    result: Any = None


def command(*args: object, expect: int = 0) -> CommandOutput:
    """Runs a command in the current folder."""
    out, err = io.StringIO(), io.StringIO()
    results: list[Any] = []
    show = Output.result

    def keep(self: Output, data: Mapping[str, Any], text: str | Callable[[], None] = "") -> None:
        # The object is kept before it is printed, so `--json` is not needed to see it.
        results.append(jsonable(data))
        show(self, data, text)

    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        patch.setattr(Output, "result", keep)
        code = main(list(map(str, args)))
    output = CommandOutput(code, out.getvalue(), err.getvalue(), results[0] if results else None)
    # An error of the person's is said in words, one of the program's never looks like it.
    assert "Traceback" not in output.err and "a bug of its own" not in output.out + output.err, output
    assert code == expect, (code, output.out[:3000], output.err)
    return output


def result(*args: object, expect: int = 0) -> Any:
    """Run the command with `--json` and return the object it prints."""
    return json.loads(command(*args, "--json", expect=expect).out)


def rewrite(archive: Path, change: Callable[[dict[str, bytes]], object], *, hashes: bool = True) -> None:
    """Lets `change` edit a bundle's files by name; `hashes`: then corrects the manifest."""
    with zipfile.ZipFile(archive) as opened:
        files = {name: opened.read(name) for name in opened.namelist()}
    change(files)
    # Forge the manifest too: only what the content itself tells can then be noticed.
    if hashes:
        manifest = json.loads(files["manifest.json"])
        manifest["files"] = {
            name: {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
            for name, data in files.items()
            if name != "manifest.json"
        }
        files["manifest.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(archive, "w") as opened:
        for name, data in files.items():
            opened.writestr(name, data)


def rewrite_json(archive: Path, name: str, change: Callable[[Any], object]) -> None:
    """Lets `change` edit the values of a JSON file in a bundle."""

    def edit(files: dict[str, bytes]) -> None:
        values = json.loads(files[name])
        change(values)
        files[name] = json.dumps(values).encode()

    rewrite(archive, edit)
