"""A file is what it was or what it is now, whatever happens while it is written."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path
from typing import NoReturn

import pytest

from tfsat_host.whole_file import fill_whole, write_whole


def half_written(beside: Path) -> None:
    beside.write_bytes(b"half")
    raise OSError(28, "No space left on device")


def interrupt_writing(beside: Path) -> None:
    beside.write_bytes(b"half")
    raise KeyboardInterrupt


def test_it_holds_what_was_written_and_nothing_lies_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "new" / "deeper" / "record.json"
    for data in (b"first", b"", b"second" * 100_000):
        write_whole(path, data)
        assert path.read_bytes() == data
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize(("end", "raised"), [(half_written, OSError), (interrupt_writing, KeyboardInterrupt)])
def test_what_ends_the_writing_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, end: object, raised: type[BaseException]
) -> None:
    assert callable(end)
    path = tmp_path / "record.json"
    path.write_bytes(b"old")
    with pytest.raises(raised):
        fill_whole(path, end)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_old_file_is_there_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    path.write_bytes(b"old")

    def look(beside: Path) -> None:
        beside.write_bytes(b"new")
        assert path.read_bytes() == b"old"

    fill_whole(path, look)
    assert path.read_bytes() == b"new"


def test_it_is_on_the_disk_before_it_takes_the_old_ones_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "record.json"
    path.write_bytes(b"old")
    on_disk = []

    def fsync(descriptor: int) -> None:
        with os.fdopen(os.dup(descriptor), "rb") as file:
            file.seek(0)
            on_disk.append((file.read(), path.read_bytes()))

    monkeypatch.setattr(os, "fsync", fsync)
    write_whole(path, b"new")
    assert on_disk == [(b"new", b"old")]


def test_a_folder_in_the_way_is_named_and_nothing_lies_beside_it(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError) as caught:
        write_whole(tmp_path / "taken", b"new")
    assert caught.value.filename == str(tmp_path / "taken")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_a_failure_names_the_file_and_not_the_one_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def mkstemp(*, prefix: str, dir: Path) -> NoReturn:
        raise PermissionError(13, "Permission denied", str(dir / f"{prefix}qikvmmzu"))

    monkeypatch.setattr(tempfile, "mkstemp", mkstemp)
    with pytest.raises(PermissionError) as caught:
        write_whole(tmp_path / "x.csv", b"new")
    assert caught.value.filename == str(tmp_path / "x.csv")


def test_a_link_stays_one_and_the_file_behind_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "shared").mkdir()
    behind, link = tmp_path / "shared" / "calibration.toml", tmp_path / "calibration.toml"
    behind.write_bytes(b"old")
    link.symlink_to(Path("shared") / "calibration.toml")
    write_whole(link, b"new")
    assert link.is_symlink()
    assert behind.read_bytes() == b"new"
    assert list(behind.parent.iterdir()) == [behind]


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_who_may_read_it_is_up_to_the_persons_umask(tmp_path: Path, umask: int) -> None:
    before = os.umask(umask)
    try:
        write_whole(tmp_path / "record.json", b"new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "record.json").stat().st_mode) == 0o666 & ~umask
