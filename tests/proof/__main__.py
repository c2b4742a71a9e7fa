"""`make prove` begins with this: runs the campaign of each proof page that is of something else than what is here."""

from __future__ import annotations

import subprocess
import sys

from tests.proof.pages import PROVED, stale


def main() -> int:
    """1 if a campaign missed a target, and its page says so, or failed, and its page is as it was."""
    failed = 0
    for page in PROVED:
        if not stale(page):
            print(f"docs/{page}.md is of what is here.", flush=True)
            continue
        print(f"docs/{page}.md is of something else: its campaign runs.", flush=True)
        campaign = f"tests.{page.replace('-', '_')}"
        failed |= subprocess.run([sys.executable, "-m", campaign], check=False).returncode
    return failed


if __name__ == "__main__":
    sys.exit(main())
