"""The emulated robot's library in its cache: whole or built anew, and errors that say what to do."""

from __future__ import annotations

import ctypes
import os
import shutil
from pathlib import Path

import pytest

from tfsat_host.emulated.build import BuildError, ensure_built


class Compiler:
    """Stands in the compiler's place: counts its calls and makes any file it is asked for."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "c++"
        self._calls = folder / "calls"
        self._calls.write_text("")
        self.path.write_text(
            f'#!/bin/sh\necho x >> {self._calls}\nwhile [ "$1" != -o ]; do shift; done\necho library > "$2"\n'
        )
        self.path.chmod(0o755)

    @property
    def calls(self) -> int:
        return len(self._calls.read_text().split())


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Compiler:
    made = Compiler(tmp_path)
    monkeypatch.setenv("CXX", str(made.path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return made


def test_it_is_built_once_and_where_the_environment_says(compiler: Compiler, tmp_path: Path) -> None:
    library = ensure_built()
    assert library.parent == tmp_path / "cache" / "tfsat"
    calls = compiler.calls
    assert calls > 10
    assert ensure_built() == library
    assert compiler.calls == calls
    assert sorted(path.name for path in library.parent.iterdir()) == [library.name, f"{library.name}.sha256"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda library: os.truncate(library, 3),
        lambda library: library.write_bytes(b"lebrary\n"),
        lambda library: library.with_name(f"{library.name}.sha256").unlink(),
        lambda library: library.with_name(f"{library.name}.sha256").write_bytes(b"\xff"),
        lambda library: library.unlink(),
    ],
    ids=["truncated", "changed", "no stamp", "bad stamp", "gone"],
)
def test_a_damaged_library_is_built_anew(compiler: Compiler, damage: object) -> None:
    library = ensure_built()
    whole, calls = library.read_bytes(), compiler.calls
    assert callable(damage)
    damage(library)
    assert ensure_built() == library
    assert compiler.calls == 2 * calls
    assert library.read_bytes() == whole


def test_a_real_library_that_was_cut_short_is_mended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built = ensure_built()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    copy = tmp_path / "tfsat" / built.name
    copy.parent.mkdir()
    for name in (built.name, f"{built.name}.sha256"):
        shutil.copy(built.with_name(name), copy.with_name(name))
    os.truncate(copy, built.stat().st_size // 2)
    assert ensure_built() == copy
    assert ctypes.CDLL(str(copy)).tfsat_config_bytes() > 0


@pytest.mark.usefixtures("compiler")
def test_a_cache_that_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(BuildError) as caught:
        ensure_built()
    assert str(tmp_path / "file" / "tfsat") in caught.value.what
    assert "XDG_CACHE_HOME" in caught.value.next_step


def test_a_compiler_that_fails_is_shown_with_its_whole_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("CXX", "/bin/false")
    with pytest.raises(BuildError) as caught:
        ensure_built()
    assert "exit code 1: /bin/false -std=c++17" in caught.value.what
    assert " -c /" in caught.value.what
    assert "CXX" in caught.value.next_step
