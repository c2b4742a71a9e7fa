"""Where the repository and its parts are, for every test."""

from __future__ import annotations

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
HOST = REPOSITORY / "host" / "tfsat_host"
DOCS = REPOSITORY / "docs"
