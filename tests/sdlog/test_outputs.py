"""Files of a command: whole or not at all, and never over somebody's work."""

from __future__ import annotations

from pathlib import Path

import pytest

from tfsat_host.errors import TfsatError
from tfsat_host.output_files import OutputFile, write_all

MARKER = b"<!-- made by a test -->"


def output(path: Path, text: bytes = MARKER) -> OutputFile:
    def write(target: Path) -> None:
        target.write_bytes(text)

    return OutputFile(path, MARKER, write)


def test_folders_are_made_and_own_files_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "report.html"
    write_all([output(path)], force=False)
    # A file of the command itself is replaced, whatever it holds.
    write_all([output(path, b"new" * 4000 + MARKER)], force=False)
    write_all([output(path, MARKER + b"newer")], force=False)
    assert path.read_bytes() == MARKER + b"newer"


def test_one_foreign_file_stops_all(tmp_path: Path) -> None:
    (tmp_path / "two").write_bytes(b"notes")
    with pytest.raises(TfsatError, match="not made by this command"):
        write_all([output(tmp_path / "one"), output(tmp_path / "two")], force=False)
    assert [path.name for path in tmp_path.iterdir()] == ["two"]
    # With --force the foreign file goes, too.
    write_all([output(tmp_path / "one"), output(tmp_path / "two")], force=True)
    assert (tmp_path / "two").read_bytes() == MARKER


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "SD.csv"
    path.write_bytes(b"old")

    # Half a file was written when the disk was full.
    def fail(target: Path) -> None:
        target.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        write_all([OutputFile(path, b"old", fail)], force=False)
    # The old file stays until the new one is whole.
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["SD.csv"]


def test_directories_in_the_way_are_named(tmp_path: Path) -> None:
    (tmp_path / "SD.csv").mkdir()
    with pytest.raises(TfsatError, match="is a directory"):
        write_all([output(tmp_path / "SD.csv")], force=True)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(TfsatError, match="not a folder"):
        write_all([output(tmp_path / "file" / "SD.csv")], force=True)
