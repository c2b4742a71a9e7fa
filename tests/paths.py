"""Where the repository and its parts are, for every test."""

from __future__ import annotations

from pathlib import Path

import tfsat_host

REPOSITORY = Path(__file__).resolve().parents[1]
DOCS = REPOSITORY / "docs"
HOST = Path(tfsat_host.__file__).parent
"""The package that is tested: of the repository, or a copy with a planted defect."""
