"""Building the emulated robot: a C++ compiler is all it takes; and the sequencer's image, which takes the toolchain.

    python -m tfsat_host.emulated.build [--avr]

The library is kept in the user's cache under a name made from the sources' hash, so that it is never
older than what it was built from. A stamp keeps its hash: a library that was cut short (a
full disk, a copied cache) would end the process without a message when it is loaded, so it is built again.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shlex
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import install_extra
from tfsat_host.user_folders import cache_folder

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
    """Return the folder that holds `tools/emulator/src` and `firmware/`: the checkout or the wheel's copy.

    Raises:
        BuildError: neither is there.
    """
    package = Path(__file__).resolve().parents[1]
    # A checkout goes before the wheel's copy: its sources are those that are being worked on.
    for root in (package.parents[1], package / "data" / "native"):
        if (root / "tools" / "emulator" / "src" / "api.cpp").is_file():
            return root
    raise BuildError(
        what="The sources of the emulated robot are not installed.",
        meaning="--emulated, rehearse and emulate cannot run; commands for real boards can.",
        next_step="Install tfsat-host from its repository or from a complete wheel.",
    )


def ensure_built(variant: Variant | None = None, progress: Progress = lambda _: None) -> Path:
    """Return the path of the library for these sources, building it if it is not in the cache.

    Raises:
        BuildError: no compiler, or the compiler refused; says what to install.
    """
    chosen = variant or Variant()
    root = native_root()
    sources = _sources(root, chosen)
    compiler = _compiler()
    # The digest is a part of the name: a change of sources, flags or compiler never finds an older library.
    suffix = {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")
    library = cache_folder() / f"libtfsat-emulator-{_digest(root, chosen, compiler)}{suffix}"
    if not _is_whole(library):
        progress(f"building the emulated robot ({len(sources)} files, once)")
        try:
            _build(compiler, chosen, sources, library)
        except OSError as error:
            raise _unwritable(library.parent, error) from None
    return library


def _stamp(library: Path) -> Path:
    return library.with_name(f"{library.name}.sha256")


def _is_whole(library: Path) -> bool:
    """Return whether the library matches the hash recorded when it was built."""
    try:
        return _stamp(library).read_text(encoding="ascii") == _hash_of(library)
    except (OSError, UnicodeDecodeError):
        return False


def _hash_of(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest() + "\n"


def _unwritable(folder: Path, error: OSError) -> BuildError:
    return BuildError(
        what=f"The emulated robot cannot be kept in {folder}: {error.strerror or error}.",
        meaning="It was not built; nothing was run. Commands for real boards work without it.",
        next_step="Make that folder writable, or set XDG_CACHE_HOME to a folder that is.",
    )


def _sources(root: Path, variant: Variant) -> list[Path]:
    emulator = root / "tools" / "emulator" / "src"
    # Files avr_*.cpp need simavr; a native build works without it.
    paths = [path for path in emulator.rglob("*.cpp") if variant.avr or not path.name.startswith("avr_")]
    # Both boards' cores are the firmware's own sources, compiled for this computer.
    for sketch in ("arduino_sequencer", "teensy_logger"):
        paths += (root / "firmware" / sketch / "src" / "core").rglob("*.cpp")
    return sorted(paths)


def _digest(root: Path, variant: Variant, compiler: Sequence[str]) -> str:
    digest = hashlib.sha256(repr((variant, compiler, _FLAGS, sys.platform)).encode())
    folders = [root / "tools" / "emulator" / "src"]
    folders += [root / "firmware" / sketch / "src" for sketch in ("arduino_sequencer", "teensy_logger")]
    # Headers count as well, and each file with its name, in an order that is the same on every disk.
    for path in sorted(
        path for folder in folders for path in folder.rglob("*") if path.suffix in (".h", ".cpp")
    ):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _compiler() -> tuple[str, ...]:
    """Return the command of a C++ compiler: the system's, else that of the extra `compiler`. Raises BuildError."""
    for name in (os.environ.get("CXX"), "c++", "g++", "clang++"):
        if name and shutil.which(name):
            return (name,)
    if find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "c++")
    raise BuildError(
        what="No C++ compiler was found.",
        meaning="The emulated robot cannot be built; commands for real boards work without it.",
        next_step=f"{install_extra('compiler')}\n"
        "Or install the system's (Debian: apt install g++; macOS: xcode-select --install), or set CXX.",
    )


def _build(compiler: Sequence[str], variant: Variant, sources: Iterable[Path], library: Path) -> None:
    """Compiles and links in a scratch folder, then moves the library into place, its stamp last."""
    import tempfile
    from concurrent.futures import ThreadPoolExecutor  # all that a library in the cache need not wait for

    library.parent.mkdir(parents=True, exist_ok=True)
    defines = ("-DTFSAT_WITH_SIMAVR",) if variant.avr else ()
    # Scratch beside the target, hence on the same file system: only there is the final rename atomic.
    with tempfile.TemporaryDirectory(dir=library.parent) as scratch:

        def compile_one(numbered: tuple[int, Path]) -> Path:
            number, source = numbered
            target = Path(scratch) / f"{number}.o"
            _run(
                [*compiler, *_FLAGS, *variant.flags, *defines, "-c", str(source), "-o", str(target)], variant
            )
            return target

        # Threads suffice: each only waits for a compiler's process.
        with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            objects = list(pool.map(compile_one, enumerate(sources)))
        linked = Path(scratch) / library.name
        libraries = ("-lsimavr", "-lelf") if variant.avr else ()
        _run(
            [*compiler, "-shared", *variant.flags, *map(str, objects), "-o", str(linked), *libraries], variant
        )
        stamp = Path(scratch) / _stamp(library).name
        stamp.write_text(_hash_of(linked), encoding="ascii")
        # The stamp last: if this ends in between, the library does not match it and is built again.
        linked.replace(library)
        stamp.replace(_stamp(library))


def _run(command: list[str], variant: Variant) -> None:
    import subprocess

    process = subprocess.run(command, capture_output=True, text=True, check=False)
    if process.returncode == 0:
        return
    # A missing libsimavr is the usual cause, and has a cure: say so instead of showing compiler output.
    if variant.avr and "simavr" in process.stderr:
        raise BuildError(
            what="libsimavr is not installed.",
            meaning="The sequencer's real image cannot be run on this computer; the native core can.",
            next_step="tools/install-toolchain.sh, or leave out --sequencer avr.",
        )
    raise BuildError(
        what=f"The compiler failed with exit code {process.returncode}: {shlex.join(command)}\n"
        + (process.stderr.strip()[-2000:] or "Without a message."),
        meaning="The emulated robot cannot run; commands for real boards can.",
        next_step=f"Set CXX to a working C++17 compiler (now {command[0]}), or report this text.",
    )


_MAKEFILE = Path("tools", "firmware", "sequencer.mk")
_BUILD = Path("build", "sequencer")
_HEX = "arduino_sequencer.hex"
_MEANING = "The sequencer's real image cannot be run; its core on this computer can (--sequencer native)."


def sequencer_hex(progress: Progress = lambda _: None) -> Path:
    """Return the HEX of this checkout's sketch, rebuilding it if it is older than its sources.

    Raises:
        BuildError: there is no checkout or no toolchain, or the sketch does not compile.
    """
    root = native_root()
    if not (root / _MAKEFILE).is_file():
        raise BuildError(
            what="This installation has no sources of the sequencer's sketch.",
            meaning=_MEANING,
            next_step="Run it from a checkout of the repository.",
        )
    make = shutil.which("make")
    if make is None:
        raise _toolchain_missing("make")
    hex_path = root / _BUILD / _HEX
    if not hex_path.exists():
        progress("building the sequencer's firmware")
    # Always run make: it knows what is out of date, and does nothing when nothing is.
    command = [
        make,
        "--no-print-directory",
        "-f",
        str(_MAKEFILE),
        f"BUILD={_BUILD}",
        f"PYTHON={sys.executable}",
    ]
    import subprocess

    process = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    if process.returncode != 0:
        raise _build_refusal(process.stderr)
    return hex_path


def _build_refusal(printed: str) -> BuildError:
    # The makefile names a missing tool between *** and a colon.
    if "install-toolchain.sh" in printed:
        missing = printed.partition("***")[2].partition(":")[0].removesuffix(" is missing").strip()
        return _toolchain_missing(missing or "a part of the toolchain")
    return BuildError(
        what=f"The sequencer's firmware does not compile:\n{printed.strip()[-2000:]}",
        meaning=_MEANING,
        next_step="Correct the sketch, then: make firmware",
    )


def _toolchain_missing(part: str) -> BuildError:
    return BuildError(
        what=f"{part} is missing: the sequencer's firmware cannot be built.",
        meaning=_MEANING,
        next_step="tools/install-toolchain.sh, or leave out --sequencer avr.",
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
