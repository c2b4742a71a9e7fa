"""The sequencer's image as it would be flashed, built for the emulated ATmega32U4."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from tfsat_host.emulated.build import BuildError, Progress, native_root

_MAKEFILE = Path("tools", "firmware", "sequencer.mk")
_BUILD = Path("build", "sequencer")
_HEX = "arduino_sequencer.hex"
_MEANING = "The sequencer's real image cannot be run; its core on this computer can (--sequencer native)."


def sequencer_hex(progress: Progress = lambda _: None) -> Path:
    """The HEX of this checkout's sketch, built now where it is older than its sources.

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
    command = [
        make,
        "--no-print-directory",
        "-f",
        str(_MAKEFILE),
        f"BUILD={_BUILD}",
        f"PYTHON={sys.executable}",
    ]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise _refused(done.stderr)
    return hex_path


def _refused(said: str) -> BuildError:
    if "install-toolchain.sh" in said:
        missing = said.partition("***")[2].partition(":")[0].removesuffix(" is missing").strip()
        return _toolchain_missing(missing or "a part of the toolchain")
    return BuildError(
        what=f"The sequencer's firmware does not compile:\n{said.strip()[-2000:]}",
        meaning=_MEANING,
        next_step="Correct the sketch, then: make firmware",
    )


def _toolchain_missing(part: str) -> BuildError:
    return BuildError(
        what=f"{part} is missing: the sequencer's firmware cannot be built.",
        meaning=_MEANING,
        next_step="tools/install-toolchain.sh, or leave out --sequencer avr.",
    )
