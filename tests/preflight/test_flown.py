"""The preflight of a drop that was flown is evidence: no later one takes its place."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.run.bundle.commands import command
from tfsat_host.protocol.limits import BLOCK_MAGIC
from tfsat_host.run.prepared_run import require_not_flown
from tfsat_host.run.signed_record import sign


@pytest.mark.parametrize("file_name", ["drop.json", "SD.bin", "DROP0003.BIN", "record.json"])
def test_a_folder_with_a_flown_drop_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file_name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    run = tmp_path / "run"
    run.mkdir()
    (run / "preflight.json").write_text("GO of that day")
    if file_name == "record.json":
        # An entry needs its file, so the recording is deleted only after it was signed.
        (run / "SD.bin").write_bytes(b"")
        sign(run, [run / "SD.bin"], "tfsat-host campaign add", datetime(2026, 1, 5, tzinfo=UTC))
        (run / "SD.bin").unlink()
    else:
        # The first four bytes suffice: a recording is known by its magic number, not by its name.
        (run / file_name).write_bytes(BLOCK_MAGIC.to_bytes(4, "little"))
    output = command("preflight", "--emulated", "run", expect=2)
    assert "drop that was flown" in output.err and "Make a folder for the next drop" in output.err
    assert (run / "preflight.json").read_text() == "GO of that day"


def test_a_binary_that_is_no_recording_is_in_nobody_s_way(tmp_path: Path) -> None:
    (tmp_path / "firmware.bin").write_bytes(bytes(4096))
    require_not_flown(tmp_path)
