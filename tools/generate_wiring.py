#!/usr/bin/env python3
"""Generate docs/wiring.svg and docs/wiring.md from docs/wiring.toml.

    python tools/generate_wiring.py           write the files
    python tools/generate_wiring.py --check   compare; exit 1 and name what differs

Needs only Python 3.11.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from wiring_generator import drawing, page
from wiring_generator.spec import WiringError, load_wiring

ROOT = Path(__file__).resolve().parent.parent


def outputs() -> dict[Path, str]:
    """Return the text of every generated file by its path. Raises WiringError."""
    wiring = load_wiring(ROOT / "docs" / "wiring.toml")
    return {
        ROOT / "docs" / "wiring.svg": drawing.draw(wiring),
        ROOT / "docs" / "wiring.md": page.generate(wiring),
    }


def main() -> int:
    """Write or compare the files; return the exit code."""
    parser = argparse.ArgumentParser(description="Generate what docs/wiring.toml defines.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is stale")
    arguments = parser.parse_args()
    try:
        files = outputs()
    except WiringError as error:
        print(f"docs/wiring.toml: {error}", file=sys.stderr)
        return 1
    stale = [path for path, text in files.items() if not path.exists() or path.read_text("utf-8") != text]
    for path in stale:
        name = path.relative_to(ROOT)
        if arguments.check:
            print(f"stale: {name} (run `make wiring` and commit the result)", file=sys.stderr)
        else:
            path.write_text(files[path], encoding="utf-8")
            print(f"wrote {name}")
    return 1 if arguments.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
