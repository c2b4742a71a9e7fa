"""Where a command may write, found out before it has computed anything."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import NoReturn

import pytest

from tfsat_host.errors import TfsatError
from tfsat_host.output_files import check_may_write


def _no_file_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def mkstemp(*, prefix: str, dir: Path) -> NoReturn:
        raise PermissionError(13, "Permission denied", str(dir / f"{prefix}qikvmmzu"))

    monkeypatch.setattr(tempfile, "mkstemp", mkstemp)


def test_a_folder_that_takes_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _no_file_can_be_made(monkeypatch)
    for path in (tmp_path / "x.csv", tmp_path / "new" / "deeper" / "x.csv"):
        with pytest.raises(TfsatError) as caught:
            check_may_write(path, marker=b"", force=True)
        assert caught.value.what == f"{path} cannot be written: Permission denied."


def test_what_is_tried_leaves_nothing(tmp_path: Path) -> None:
    check_may_write(tmp_path / "x.csv", marker=b"", force=False)
    check_may_write(tmp_path / "new" / "x.csv", marker=b"", force=False)
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(TfsatError, match="file is a file, not a folder"):
        check_may_write(tmp_path / "file" / "new" / "x.csv", marker=b"", force=True)


def test_the_cure_fits_files_and_folders(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_bytes(b"mine")
    with pytest.raises(TfsatError) as caught:
        check_may_write(tmp_path / "mine.csv", marker=b"theirs", force=False)
    assert "another place with --out" in caught.value.next_step


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (b"TFS1\x02\x01", "a recording of the logger"),
        (b"\0" * 512 + b"TFS1\x02\x01", "a recording of the logger"),
        (b"# tfsat calibration: values with their uncertainty", "a calibration certificate"),
    ],
)
def test_what_nothing_can_make_again_is_not_overwritten_even_with_force(
    tmp_path: Path, content: bytes, named: str
) -> None:
    path = tmp_path / "SD.bin"
    path.write_bytes(content)
    with pytest.raises(TfsatError, match=f"is {named}"):
        check_may_write(path, marker=b"<!doctype html>", force=True)
    assert path.read_bytes() == content
