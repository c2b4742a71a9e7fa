#!/usr/bin/env python3
"""Compile protocol/tfsat_log.ksy into tests/sdlog/kaitai/tfsat_log.py, with Kaitai Struct's own compiler.

    python tools/compile_kaitai.py

The tests decode the reference log with it: a decoder that nobody here wrote. It stands in the repository so
that the tests need no Node.js; the module bears the hash of its grammar, and a test says when it is stale.
Needs Node.js and npm; what `tools/kaitai/package-lock.json` names goes into build/kaitai.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
GRAMMAR = ROOT / "protocol" / "tfsat_log.ksy"
MODULE = ROOT / "tests" / "sdlog" / "kaitai" / "tfsat_log.py"
_PACKAGES = ROOT / "tools" / "kaitai"
_WORK = ROOT / "build" / "kaitai"
_HASH_LINE = "# sha256 of protocol/tfsat_log.ksy: "
_UNTOUCHED = "# ruff: noqa\n# fmt: off\n# mypy: ignore-errors\n"
"""The compiler's style is its own. Its `# type: ignore` would hide the class too, not only what is wrong."""


def grammar_hash() -> str:
    """Return the SHA-256 of the grammar, hexadecimal."""
    return hashlib.sha256(GRAMMAR.read_bytes()).hexdigest()


def compiled_hash() -> str:
    """Return the hash of the grammar that the module in the repository was compiled from; empty if it bears none."""
    lines = MODULE.read_text().splitlines()
    return next((line.removeprefix(_HASH_LINE) for line in lines if line.startswith(_HASH_LINE)), "")


def main() -> int:
    """Install the compiler if it is missing, run it and return the exit code."""
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        print(
            "Error: the grammar's compiler needs Node.js and npm, which are not installed.\n"
            "  Only who changes the log's layout needs them (Debian, Ubuntu: apt install nodejs npm).",
            file=sys.stderr,
        )
        return 1
    _WORK.mkdir(parents=True, exist_ok=True)
    stale = [name for name in ("package.json", "package-lock.json") if _copy_package_file(name)]
    try:
        if stale or not (_WORK / "node_modules").is_dir():
            subprocess.run([npm, "ci", "--silent", "--no-audit", "--no-fund"], cwd=_WORK, check=True)
        command = [node, str(_PACKAGES / "compile.mjs"), str(GRAMMAR)]
        source = subprocess.run(command, cwd=_WORK, check=True, stdout=subprocess.PIPE, text=True).stdout
    except subprocess.CalledProcessError as error:
        print(f"Error: {Path(error.cmd[0]).name} ended with {error.returncode}.", file=sys.stderr)
        return 1
    MODULE.parent.mkdir(parents=True, exist_ok=True)
    source = source.replace("# type: ignore\n", "").rstrip()
    MODULE.write_text(f"{_HASH_LINE}{grammar_hash()}\n{_UNTOUCHED}{source}\n")
    print(f"wrote {MODULE.relative_to(ROOT)}")
    return 0


def _copy_package_file(name: str) -> bool:
    """Copy one file of the package list to where npm works; return whether it differed from the one there."""
    source, there = _PACKAGES / name, _WORK / name
    if there.exists() and there.read_bytes() == source.read_bytes():
        return False
    shutil.copyfile(source, there)
    return True


if __name__ == "__main__":
    sys.exit(main())
