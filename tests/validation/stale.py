"""`make test` ends with this: names the proof pages of another board image than the one that was built."""

from __future__ import annotations

from tests.validation.provenance import PROOFS


def main() -> None:
    """Print a line a page. A stale page is no failure here: `make release` refuses it."""
    for proof in PROOFS:
        if proof.of_board and proof.is_stale():
            print(f"Note: {proof.stale_sentence()} (before a release)")


if __name__ == "__main__":
    main()
