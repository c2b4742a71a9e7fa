#!/usr/bin/env python3
"""Generate everything that is derived from protocol/tfsat.toml.

    python tools/generate_protocol.py           write the files
    python tools/generate_protocol.py --check   compare; exit 1 and name what differs

Needs only Python 3.11.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from protocol_generator import cpp, golden, kaitai, log_format, markdown, python
from protocol_generator.spec import Spec, SpecError, load_spec

ROOT = Path(__file__).resolve().parent.parent
SKETCHES = ("arduino_sequencer", "teensy_logger")
RELEASE_RULE = ("ticks.h", "switch_edge.h", "release_detector.h", "release_detector.cpp")
"""Files of the sequencer's core that the logger follows a drop with: both must mean the same release."""


def outputs(spec: Spec) -> dict[Path, str]:
    """Return the text of every generated file by its path."""
    package = ROOT / "host" / "tfsat_host" / "protocol"
    files: dict[Path, str] = {package / f"{name}.py": text for name, text in python.generate(spec).items()}
    headers = {"messages.h": cpp.generate(spec)}
    for source in sorted((ROOT / "protocol" / "cpp").glob("*.h")):
        origin = source.relative_to(ROOT).as_posix()
        headers[source.name] = f"// Copied from {origin} by tools/generate_protocol.py.\n{source.read_text()}"
    for sketch in SKETCHES:
        folder = ROOT / "firmware" / sketch / "src" / "protocol"
        files.update({folder / name: text for name, text in headers.items()})
    core = ROOT / "firmware" / "arduino_sequencer" / "src" / "core"
    for name in RELEASE_RULE:
        note = f"// Copied from {(core / name).relative_to(ROOT).as_posix()} by tools/generate_protocol.py.\n"
        files[ROOT / "firmware" / "teensy_logger" / "src" / "release" / name] = (
            note + (core / name).read_text()
        )
    files[ROOT / "protocol" / "reference.md"] = markdown.generate(spec)
    files[ROOT / "docs" / "log-format.md"] = log_format.generate(spec)
    files[ROOT / "protocol" / "tfsat_log.ksy"] = kaitai.generate(spec)
    files[ROOT / "protocol" / "golden_vectors.json"] = golden.generate_json(spec)
    files[ROOT / "protocol" / "golden_vectors.h"] = golden.generate_cpp(spec)
    return files


def main() -> int:
    """Write or compare the files; return the exit code."""
    parser = argparse.ArgumentParser(description="Generate what protocol/tfsat.toml defines.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is stale")
    arguments = parser.parse_args()
    try:
        files = outputs(load_spec(ROOT / "protocol" / "tfsat.toml"))
    except SpecError as error:
        print(f"protocol/tfsat.toml: {error}", file=sys.stderr)
        return 1
    stale = [path for path, text in files.items() if not path.exists() or path.read_text() != text]
    for path in stale:
        name = path.relative_to(ROOT)
        if arguments.check:
            print(f"stale: {name} (run `make protocol` and commit the result)", file=sys.stderr)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(files[path])
            print(f"wrote {name}")
    return 1 if arguments.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
