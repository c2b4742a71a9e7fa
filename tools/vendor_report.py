#!/usr/bin/env python3
"""Fetch what the report page is drawn with, and put it under host/tfsat_host/report/vendor.

    python tools/vendor_report.py

The report inlines these files, so they stand in the repository, beside their licences and `SOURCES.json`, which
says of each where it came from and its SHA-256; the tests compare. Needs Node.js and npm; what
`tools/report_vendor/package-lock.json` names is checked against its hashes and goes into build/report-vendor.

uPlot comes minified. twgl.js (with its matrices) comes as 440 kB of commented source, which terser, pinned
in the same lock, shrinks.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENDOR = ROOT / "host" / "tfsat_host" / "report" / "vendor"
_PACKAGES = ROOT / "tools" / "report_vendor"
_WORK = ROOT / "build" / "report-vendor"
_NPM_FILES = ("package.json", "package-lock.json")


@dataclasses.dataclass(frozen=True)
class Wanted:
    """One file of a package, and whether it has yet to be shrunk."""

    package: str
    path: str
    name: str
    minify: bool = False


WANTED = (
    Wanted("uplot", "dist/uPlot.iife.min.js", "uplot.min.js"),
    Wanted("uplot", "dist/uPlot.min.css", "uplot.min.css"),
    Wanted("uplot", "LICENSE", "uplot.LICENSE"),
    Wanted("twgl.js", "dist/7.x/twgl-full.js", "twgl.min.js", minify=True),
    Wanted("twgl.js", "LICENSE.md", "twgl.LICENSE"),
)


def main() -> int:
    """Installs the packages, copies or shrinks their files, writes SOURCES.json; the exit code."""
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        print(
            "Error: Node.js and npm are not installed, and the packages come through npm.\n"
            "  Only who changes what the report is drawn with needs them (Debian, Ubuntu: apt install nodejs npm).",
            file=sys.stderr,
        )
        return 1
    _WORK.mkdir(parents=True, exist_ok=True)
    VENDOR.mkdir(parents=True, exist_ok=True)
    for name in _NPM_FILES:
        shutil.copyfile(_PACKAGES / name, _WORK / name)
    try:
        subprocess.run(
            [npm, "ci", "--silent", "--no-audit", "--no-fund", "--ignore-scripts"], cwd=_WORK, check=True
        )
        for vendor_file in WANTED:
            (VENDOR / vendor_file.name).write_bytes(_content(node, vendor_file))
    except subprocess.CalledProcessError as error:
        print(f"Error: {Path(error.cmd[0]).name} ended with {error.returncode}.", file=sys.stderr)
        return 1
    (VENDOR / "SOURCES.json").write_text(json.dumps(_sources(), indent=2) + "\n")
    print(f"wrote {VENDOR.relative_to(ROOT)}")
    return 0


def _content(node: str, vendor_file: Wanted) -> bytes:
    """Return the file as the page will carry it: without the source map's address, which nothing could reach."""
    source = _WORK / "node_modules" / vendor_file.package / vendor_file.path
    if not vendor_file.minify:
        return source.read_bytes()
    terser = _WORK / "node_modules" / "terser" / "bin" / "terser"
    command = [node, str(terser), str(source), "--compress", "--mangle", "--comments", "/@license/"]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout


def _sources() -> dict[str, dict[str, str]]:
    """List of each file: package, version, licence, npm's integrity hash of the package, and its own SHA-256."""
    locked = json.loads((_PACKAGES / "package-lock.json").read_text())["packages"]
    minifier = f"terser {locked['node_modules/terser']['version']}"
    return {
        vendor_file.name: {
            "package": vendor_file.package,
            "version": locked[f"node_modules/{vendor_file.package}"]["version"],
            "license": locked[f"node_modules/{vendor_file.package}"]["license"],
            "integrity": locked[f"node_modules/{vendor_file.package}"]["integrity"],
            "path": vendor_file.path,
            "changed": f"minified by {minifier}" if vendor_file.minify else "no",
            "sha256": hashlib.sha256((VENDOR / vendor_file.name).read_bytes()).hexdigest(),
        }
        for vendor_file in WANTED
    }


if __name__ == "__main__":
    sys.exit(main())
