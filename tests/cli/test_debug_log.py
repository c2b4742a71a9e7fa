"""`--debug`: what a command sends, reads, writes and decides; the end of it stands in a crash report."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.debug_log import MAX_RECENT_LINES
from tfsat_host.present.output import Output


def test_frames_files_and_decisions_are_lines_on_stderr(tfsat_host: RunCli) -> None:
    upload = tfsat_host("upload-sequence", 59, 70, "--emulated", "--out", "maneuver.toml", "--debug")
    for words in (
        "devices.client: emulated sequencer > HelloRequest, number 1, attempt 1",
        "devices.client: emulated sequencer < HelloReply, number 1, ",
        "config.toml: read ",
        "whole_file: wrote ",
    ):
        assert words in upload.stderr
    assert "attempt" not in upload.stdout


@pytest.mark.parametrize("environ", [{}, {"TFSAT_DEBUG": "0"}])
def test_without_it_there_are_none(tfsat_host: RunCli, environ: dict[str, str]) -> None:
    assert " attempt " not in tfsat_host("status", "--emulated", environ=environ).stderr


def test_the_environment_switches_it_on_and_json_stays_one_object(tfsat_host: RunCli) -> None:
    status = tfsat_host("status", "--emulated", "--json", environ={"TFSAT_DEBUG": "1"})
    assert json.loads(status.stdout)["sequencer"]["state"] == "safe"
    assert " ms tfsat_host.devices.client: emulated logger > " in status.stderr


def test_a_crash_report_has_the_last_lines(tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch) -> None:
    def break_down(*_: object) -> None:
        # More lines than a report keeps.
        for number in range(MAX_RECENT_LINES + 50):
            logging.getLogger("tfsat_host.test").debug("line %d", number)
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(Output, "result", break_down)
    error = tfsat_host("status", "--emulated", expect=1).stderr
    report = Path(error.rpartition("with the file ")[2].strip()).read_text(encoding="utf-8")
    assert "met a bug of its own: ZeroDivisionError: a bug" in error and "Traceback" in report
    lines = [line for line in report.splitlines() if "tfsat_host.test: line " in line]
    # The newest lines are kept, not the first ones.
    assert len(lines) == MAX_RECENT_LINES and lines[-1].endswith(f"line {MAX_RECENT_LINES + 49}")
