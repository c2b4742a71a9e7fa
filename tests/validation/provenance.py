"""What each campaign was run with: version, date, duration, and the hash of the image or code that it measured."""

from __future__ import annotations

import csv
import hashlib
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.paths import DOCS, REPOSITORY
from tests.validation.logger_proof.building import core_sha256
from tests.validation.pages import fill_pages
from tests.validation.sources import code_sha256
from tests.validation.tables import csv_text
from tfsat_host import __version__

SEQUENCER_HEX = REPOSITORY / "build" / "sequencer" / "arduino_sequencer.hex"
SHA256_ROW = "SHA-256 of what was measured"
NOT_RECORDED = "not recorded"


@dataclass(frozen=True)
class Proof:
    """A campaign whose tables stand in a folder of docs/.

    Attributes:
        name: Of the folder, and of its page.
        command: It runs the campaign.
        subject: What is measured, in words.
        hash_subject: The SHA-256 of the subject as it is here.
        of_board: The subject is what a board is flashed with.
    """

    name: str
    command: str
    subject: str
    hash_subject: Callable[[], str]
    of_board: bool = False

    @property
    def folder(self) -> Path:
        """The campaign's tables."""
        return DOCS / self.name

    def is_stale(self) -> bool:
        """Tell whether the campaign was run with something else than what is here."""
        return read_provenance(self.folder)[SHA256_ROW] != self.hash_subject()

    def stale_sentence(self) -> str:
        """Say what is stale and what brings it up to date."""
        return f"docs/{self.name}.md was measured on another {self.subject}. Run: {self.command}"


def hash_image() -> str:
    """Return the SHA-256 of the sequencer's HEX as it is flashed."""
    # The HEX as it is flashed, not the sources: a compiler may change it.
    return hashlib.sha256(SEQUENCER_HEX.read_bytes()).hexdigest()


def _prove_code(name: str, command: str, module: str) -> Proof:
    return Proof(name, command, "version of the code", partial(code_sha256, f"tests.validation.{module}"))


PROOFS = (
    Proof("sequencer-proof", "make sequencer-report", "image of the sequencer", hash_image, of_board=True),
    Proof("logger-proof", "make logger-report", "core of the logger", core_sha256, of_board=True),
    _prove_code("calibration-proof", "make calibration-report", "calibration_proof.robots"),
    _prove_code("evaluation-proof", "make evaluation-report", "evaluation_proof.campaign"),
    _prove_code("simulation-based-calibration", "make sbc-report", "simulation_based_calibration.drops"),
    _prove_code("decode-report", "make decode-report", "decode_bench.scenarios"),
    _prove_code("joints-together", "make together-report", "joints_together.searches"),
    _prove_code("paper-numbers", "make paper-numbers", "paper_numbers.sections"),
)


def read_provenance(folder: Path) -> dict[str, str]:
    """Return what a folder of docs/ says of its campaign."""
    with (folder / "provenance.csv").open(newline="", encoding="utf-8") as file:
        _, *rows = csv.reader(file)
    return dict(rows)


class CampaignRun:
    """A campaign under way: what it measures is hashed before it begins and written when it has ended."""

    def __init__(self, name: str) -> None:
        (self.proof,) = (proof for proof in PROOFS if proof.name == name)
        # Hashed before the run: changes during the campaign must not count.
        self._sha256 = self.proof.hash_subject()
        self._begun_s = time.monotonic()

    def write(self, tables: Mapping[str, str], facts: Mapping[str, object], docs: Path = DOCS) -> None:
        """Write the campaign's files and fill the tables of all pages.

        Args:
            tables: Text by the file's name in the campaign's folder.
            facts: What else it was run with, such as the versions of tools.
            docs: The folder of the pages.
        """
        folder = docs / self.proof.name
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in tables.items():
            (folder / name).write_text(text, encoding="utf-8")
        minutes = (time.monotonic() - self._begun_s) / 60.0
        rows = {
            "version of tfsat": __version__,
            "date of the last commit": date_of_commit(),
            "duration": f"{minutes:.1f} min",
            **facts,
            SHA256_ROW: self._sha256,
        }
        (folder / "provenance.csv").write_text(
            csv_text(("the campaign's", "value"), list(rows.items())), encoding="utf-8"
        )
        # Tables of other pages may quote this campaign's numbers.
        fill_pages(docs)


def date_of_commit() -> str:
    """Return the date of the last commit, and whether there is more than it has."""
    date, changed = (
        subprocess.run(["git", *arguments], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout
        for arguments in (("log", "-1", "--format=%cs"), ("status", "--porcelain", "--", ":!docs"))
    )
    # Uncommitted changes beside docs/ make the date worth less.
    return date.strip() + (", with changes" if changed else "")
