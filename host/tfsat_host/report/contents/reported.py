"""One drop as a report has it: its evaluation, and where that came from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.file_hash import sha256_of


@dataclass(frozen=True, slots=True)
class Source:
    """A file that the evaluation took something from, as it was then.

    Attributes:
        what: Such as `calibration`.
        path: Where it lay.
        sha256: Of its bytes, hexadecimal.
    """

    what: str
    path: Path
    sha256: str

    @classmethod
    def of(cls, what: str, path: Path) -> Source:
        """A file as it is now."""
        return cls(what, path, sha256_of(path))


@dataclass(frozen=True, eq=False)
class Reported:
    """One drop.

    Attributes:
        name: For people; the same in no two drops of a report.
        evaluation: What is known of it.
        verdict: What that is worth, by `verdict.verdict_of`.
        recording_sha256: Of the file that was evaluated, hexadecimal.
        certificate: The file of the calibration; None: there was none.
        sources: Other files besides the recording that were read.
        options: What else was asked for, as it is typed.
        remarks: What else a reader should know, such as that no maneuver was given; a sentence each.
    """

    name: str
    evaluation: Evaluation
    verdict: Verdict
    recording_sha256: str
    certificate: Path | None
    remarks: tuple[str, ...] = ()
    sources: tuple[Source, ...] = ()
    options: tuple[str, ...] = ()
