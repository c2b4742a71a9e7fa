"""The proof pages of docs/, each with the hash of what it proves: only a finished campaign writes it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import partial

from tests.logger_proof.building import core_sha256
from tests.proof.sources import REPOSITORY, code_sha256

SEQUENCER_HEX = REPOSITORY / "build" / "sequencer" / "arduino_sequencer.hex"


def _hex_sha256() -> str:
    return hashlib.sha256(SEQUENCER_HEX.read_bytes()).hexdigest()


PROVED: dict[str, Callable[[], str]] = {
    "sequencer-proof": _hex_sha256,
    "logger-proof": core_sha256,
    "calibration-proof": partial(code_sha256, "tests.calibration_proof.robots"),
    "evaluation-proof": partial(code_sha256, "tests.evaluation_proof.campaign"),
    "paper-setting": partial(code_sha256, "tests.evaluation_proof.campaign"),
    "causes": partial(code_sha256, "tests.evaluation_proof.campaign"),
    "simulation-based-calibration": partial(code_sha256, "tests.simulation_based_calibration.drops"),
    "paper-numbers": partial(code_sha256, "tests.paper_numbers.__main__"),
}
"""By page: the hash of the flashed HEX, of the logger's core, or of all code that the numbers come from.

The campaign is `python -m tests.PAGE`, with underscores.
"""


def seal(page: str) -> str:
    """The line of a page whose proof is of code; taken before the campaign, written after it."""
    return f"\nProves the code with SHA-256 `{PROVED[page]()}`, comments and docstrings aside.\n"


def stale(page: str) -> bool:
    """Whether a page of docs/ proves something else than what is here."""
    return f"`{PROVED[page]()}`" not in (REPOSITORY / "docs" / f"{page}.md").read_text(encoding="utf-8")
