"""The emulated robot's library in its cache: whole or built again, and errors that say what to do."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tfsat_host.emulated.build import BuildError, ensure_built


class Compiler:
    """A compiler that counts its calls and links the library that the tests have."""

    def __init__(self, folder: Path, linked: Path) -> None:
        self.path = folder / "c++"
        self._calls = folder / "calls"
        self._calls.write_text("")
        self.path.write_text(
            f'#!/bin/sh\necho x >> {self._calls}\nfrom=/dev/null\n[ "$1" = -shared ] && from={linked}\n'
            'while [ "$1" != -o ]; do shift; done\ncp $from "$2"\n'
        )
        self.path.chmod(0o755)

    @property
    def calls(self) -> int:
        return len(self._calls.read_text().split())


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Compiler:
    fake_compiler = Compiler(tmp_path, ensure_built())
    monkeypatch.setenv("CXX", str(fake_compiler.path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return fake_compiler


def test_it_is_built_once_where_the_environment_says_and_again_where_it_is_damaged(
    compiler: Compiler, tmp_path: Path
) -> None:
    library = ensure_built()
    assert library.parent == tmp_path / "cache" / "tfsat"
    stamp = library.with_name(f"{library.name}.sha256")
    library_bytes, calls = library.read_bytes(), compiler.calls
    assert calls > 10
    assert ensure_built() == library
    assert compiler.calls == calls
    assert sorted(path.name for path in library.parent.iterdir()) == [library.name, stamp.name]
    # Each damage must be noticed and built again, the untouched case must not.
    damages: list[Callable[[], object]] = [
        lambda: os.truncate(library, len(library_bytes) // 2),
        lambda: library.write_bytes(b"lebrary\n"),
        stamp.unlink,
        lambda: stamp.write_bytes(b"\xff"),
        library.unlink,
    ]
    for number, damage in enumerate(damages):
        damage()
        assert ensure_built() == library
        assert compiler.calls == (2 + number) * calls
        assert library.read_bytes() == library_bytes
    assert ctypes.CDLL(str(library)).tfsat_config_bytes() > 0


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
