"""`make prove` begins with this: runs the campaign of each proof page whose image or code has changed."""

from __future__ import annotations

import subprocess
import sys

from tests.validation.provenance import PROOFS


def main() -> int:
    """Run the stale campaigns; 1 if one missed a target (its page says so) or failed (its page is unchanged)."""
    failed = 0
    for proof in PROOFS:
        # Nothing to do where the page's hash is that of the code and image of today.
        if not proof.is_stale():
            print(f"docs/{proof.name}.md was measured on what is here.", flush=True)
            continue
        print(proof.stale_sentence(), flush=True)
        # A failed campaign leaves its page unchanged; a missed target is said by the page itself.
        failed |= subprocess.run(proof.command.split(), check=False).returncode
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
