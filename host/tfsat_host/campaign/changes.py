"""What of a drop is not as it was when it came into its campaign."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.campaign.entries import DropEntry
from tfsat_host.file_hash import sha256_of
from tfsat_host.record.run_record import verify

SIGNED_BY = "tfsat-host campaign add"
"""How the entry of the record begins with which a run is closed: what is signed after it came later than the drop."""


def changes_in(folder: Path, drop: DropEntry) -> list[str]:
    """What is not as it was when the drop came in; sentences."""
    recording = folder / drop.recording
    if not folder.is_dir():
        return []  # told as a finding of the campaign
    if not recording.is_file():
        return [f"{recording} is missing."]
    changes = [] if sha256_of(recording) == drop.sha256 else [f"{recording} was changed since it came in."]
    findings = verify(folder, closed_by=SIGNED_BY)
    return changes + [one.sentence for one in findings if one.name != drop.recording]
