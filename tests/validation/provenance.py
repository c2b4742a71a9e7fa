"""What each proof page of docs/ was measured on, by its hash, and the command that measures again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from tests.paths import REPOSITORY
from tests.validation.logger_proof.building import core_sha256
from tests.validation.sources import code_sha256

SEQUENCER_HEX = REPOSITORY / "build" / "sequencer" / "arduino_sequencer.hex"


@dataclass(frozen=True)
class Proof:
    """A campaign and the pages that it writes.

    Attributes:
        name: Of its page and folder in docs/.
        command: It runs the campaign.
        subject: What was measured, in words.
        hash_subject: The SHA-256 of the subject as it is here.
        more_pages: Other pages of docs/ with the same campaign's figures.
        of_board: The subject is what a board is flashed with.
    """

    name: str
    command: str
    subject: str
    hash_subject: Callable[[], str]
    more_pages: tuple[str, ...] = ()
    of_board: bool = False

    def is_stale(self) -> bool:
        """Tell whether a page of the campaign is of something else than what is here."""
        seal = f"`{self.hash_subject()}`"
        pages = [REPOSITORY / "docs" / f"{page}.md" for page in (self.name, *self.more_pages)]
        return not all(seal in page.read_text(encoding="utf-8") for page in pages)

    def stale_sentence(self) -> str:
        """Say what is stale and what brings it up to date."""
        return f"docs/{self.name}.md was measured on another {self.subject}. Run: {self.command}"


def hash_image() -> str:
    """Hash the sequencer's HEX as it is flashed."""
    return hashlib.sha256(SEQUENCER_HEX.read_bytes()).hexdigest()


def _prove_code(name: str, command: str, module: str, more_pages: tuple[str, ...] = ()) -> Proof:
    return Proof(name, command, "version of the code", partial(code_sha256, module), more_pages)


PROOFS = (
    Proof("sequencer-proof", "make sequencer-report", "image of the sequencer", hash_image, of_board=True),
    Proof("logger-proof", "make logger-report", "core of the logger", core_sha256, of_board=True),
    _prove_code("calibration-proof", "make calibration-report", "tests.validation.calibration_proof.robots"),
    _prove_code(
        "evaluation-proof",
        "make evaluation-report",
        "tests.validation.evaluation_proof.campaign",
        ("paper-setting", "causes"),
    ),
    _prove_code(
        "simulation-based-calibration",
        "make sbc-report",
        "tests.validation.simulation_based_calibration.drops",
    ),
    _prove_code("paper-numbers", "make paper-numbers", "tests.validation.paper_numbers.__main__"),
)


def seal(name: str) -> str:
    """Return the line that a campaign of code writes below its page; take it before the campaign begins."""
    (proof,) = (one for one in PROOFS if one.name == name)
    return f"\nProves the code with SHA-256 `{proof.hash_subject()}`, comments and docstrings aside.\n"
