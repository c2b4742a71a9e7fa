"""`tfsat-host` in this process, evaluations that are made once, and bundles that somebody has changed."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.commanded import Said
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration
from tfsat_host.cli.main import main
from tfsat_host.evaluation.evaluation import Evaluation, evaluate
from tfsat_host.file_hash import sha256_of
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel
from tfsat_host.run import drop_evaluation
from tfsat_host.sdlog import DropLog

_MADE: dict[str, Evaluation] = {}


def keep_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same recording with the same files gives what it gave: evaluating it is not what is tested."""

    def kept(
        log: DropLog,
        model: RobotModel,
        calibration: Calibration | None,
        schedule: Schedule | None,
        **others: Any,
    ) -> Evaluation:
        certificate = None if calibration is None else format_calibration(calibration)
        options = (others["recorded"], others["offsets"].names, others["swarm"], others["witnesses"])
        key = repr((sha256_of(log.path), log.session, sha256_of(model.path), certificate, schedule, options))
        if key not in _MADE:
            _MADE[key] = evaluate(log, model, calibration, schedule, **others)
        return replace(_MADE[key], log=log, model=model)

    monkeypatch.setattr(drop_evaluation, "evaluate", kept)


def command(*args: object, expect: int = 0) -> Said:
    """Runs a command in the current folder."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(map(str, args)))
    said = Said(code, out.getvalue(), err.getvalue())
    assert "Traceback" not in said.err and "a bug of its own" not in said.out + said.err, said
    assert code == expect, (code, said.out[:3000], said.err)
    return said


def result(*args: object, expect: int = 0) -> Any:
    """The object that it prints."""
    return json.loads(command(*args, "--json", expect=expect).out)


def rewrite(archive: Path, change: Callable[[dict[str, bytes]], object], *, hashes: bool = True) -> None:
    """Lets `change` edit a bundle's files by name; `hashes`: then corrects the manifest."""
    with zipfile.ZipFile(archive) as opened:
        files = {name: opened.read(name) for name in opened.namelist()}
    change(files)
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
