"""Building the emulated robot: a C++ compiler is all it takes.

    python -m tfsat_host.emulated.build [--avr]

The library is kept in the user's cache under a name made from the sources' hash, so that it is never
older than what it was built from.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import TfsatError

Progress = Callable[[str], None]

_FLAGS = ("-std=c++17", "-O2", "-fPIC", "-Wall", "-Wextra", "-Wpedantic", "-Werror")


class BuildError(TfsatError):
    """The emulated robot could not be built."""


@dataclass(frozen=True)
class Variant:
    """Which library to build.

    Attributes:
        avr: With the emulated ATmega32U4 (needs libsimavr).
        flags: Further compiler flags, such as sanitizers.
    """

    avr: bool = False
    flags: tuple[str, ...] = ()


def native_root() -> Path:
    """The folder that holds `tools/emulator/src` and `firmware/`: the checkout, or the wheel's copy.

    Raises:
        BuildError: neither is there.
    """
    package = Path(__file__).resolve().parents[1]
    for root in (package.parents[1], package / "data" / "native"):
        if (root / "tools" / "emulator" / "src" / "api.cpp").is_file():
            return root
    raise BuildError(
        what="The sources of the emulated robot are not installed.",
        meaning="--emulated, rehearse and emulate cannot run; commands for real boards can.",
        next_step="Install tfsat-host from its repository or from a complete wheel.",
    )


def ensure_built(variant: Variant | None = None, progress: Progress = lambda _: None) -> Path:
    """The library for these sources, built now if it is not in the cache.

    Raises:
        BuildError: no compiler, or the compiler refused; says what to install.
    """
    chosen = variant or Variant()
    root = native_root()
    sources = _sources(root, chosen)
    compiler = _compiler()
    library = _cache() / f"libtfsat-emulator-{_digest(root, chosen, compiler)}{_suffix()}"
    if not library.exists():
        progress(f"building the emulated robot ({len(sources)} files, once)")
        _build(compiler, chosen, sources, library)
    return library


def _sources(root: Path, variant: Variant) -> list[Path]:
    emulator = root / "tools" / "emulator" / "src"
    found = [path for path in emulator.rglob("*.cpp") if variant.avr or not path.name.startswith("avr_")]
    for sketch in ("arduino_sequencer", "teensy_logger"):
        found += (root / "firmware" / sketch / "src" / "core").rglob("*.cpp")
    return sorted(found)


def _digest(root: Path, variant: Variant, compiler: str) -> str:
    digest = hashlib.sha256(repr((variant, compiler, _FLAGS, sys.platform)).encode())
    folders = [root / "tools" / "emulator" / "src"]
    folders += [root / "firmware" / sketch / "src" for sketch in ("arduino_sequencer", "teensy_logger")]
    for path in sorted(
        path for folder in folders for path in folder.rglob("*") if path.suffix in (".h", ".cpp")
    ):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _cache() -> Path:
    import platformdirs

    path = Path(platformdirs.user_cache_dir("tfsat"))
    path.mkdir(parents=True, exist_ok=True)
    return path


def _suffix() -> str:
    return {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")


def _compiler() -> str:
    for name in (os.environ.get("CXX"), "c++", "g++", "clang++"):
        if name and shutil.which(name):
            return name
    raise BuildError(
        what="No C++ compiler was found.",
        meaning="The emulated robot cannot be built; commands for real boards work without it.",
        next_step="Install g++ (Debian: apt install g++; macOS: xcode-select --install), or set CXX.",
    )


def _build(compiler: str, variant: Variant, sources: Iterable[Path], library: Path) -> None:
    """Compiles and links in a scratch folder, then moves the library into place at once."""
    defines = ("-DTFSAT_WITH_SIMAVR",) if variant.avr else ()
    with tempfile.TemporaryDirectory(dir=library.parent) as scratch:

        def compile_one(numbered: tuple[int, Path]) -> Path:
            number, source = numbered
            target = Path(scratch) / f"{number}.o"
            _run([compiler, *_FLAGS, *variant.flags, *defines, "-c", str(source), "-o", str(target)], variant)
            return target

        with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            objects = list(pool.map(compile_one, enumerate(sources)))
        linked = Path(scratch) / library.name
        libraries = ("-lsimavr", "-lelf") if variant.avr else ()
        _run(
            [compiler, "-shared", *variant.flags, *map(str, objects), "-o", str(linked), *libraries], variant
        )
        linked.replace(library)


def _run(command: list[str], variant: Variant) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return
    if variant.avr and "simavr" in done.stderr:
        raise BuildError(
            what="libsimavr is not installed.",
            meaning="The sequencer's real image cannot be run on this computer; the native core can.",
            next_step="tools/install-toolchain.sh, or leave out --sequencer avr.",
        )
    raise BuildError(
        what=f"The compiler refused: {' '.join(command[-4:])}\n{done.stderr.strip()[-2000:]}",
        meaning="The emulated robot cannot run.",
        next_step="Try another compiler (CXX=clang++), or report this text.",
    )


def main() -> int:
    """Builds from the command line; says where the library is."""
    parser = argparse.ArgumentParser(prog="python -m tfsat_host.emulated.build", description=main.__doc__)
    parser.add_argument("--avr", action="store_true", help="with the emulated ATmega32U4 (needs libsimavr)")
    arguments = parser.parse_args()
    try:
        print(ensure_built(Variant(avr=arguments.avr), lambda text: print(text, file=sys.stderr)))
    except BuildError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
