"""Whether the files of a bundle are those that its preflight checked: `preflight.json` names each by its hash."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tfsat_host.bundle.manifest import Evaluated

_KINDS = ("maneuver", "calibration", "robot", "facility")


def not_as_checked(preflight: Any, at_hand: Mapping[str, str], used: Evaluated) -> list[str]:
    """What the preflight checked and is gone, or is another one now; a sentence each.

    A certificate is written again when the robot has landed: the one that was checked lies among those that were kept.

    Args:
        preflight: What `preflight.json` holds; whatever is no preflight's names no files.
        at_hand: SHA-256 of every file, by its name in the bundle.
        used: Which of them the drop is evaluated with.
    """
    files = preflight.get("files") if isinstance(preflight, dict) else None
    if not isinstance(files, dict):
        return []
    found = (_finding(kind, files[kind], at_hand, getattr(used, kind)) for kind in _KINDS if kind in files)
    return [sentence for sentence in found if sentence]


def _finding(kind: str, checked: Any, at_hand: Mapping[str, str], name: str | None) -> str:
    """Empty: it is there."""
    sha256 = checked.get("sha256") if isinstance(checked, dict) else None
    if not isinstance(sha256, str):
        return f"preflight.json does not say which {kind} was checked."
    kept = kind == "calibration" and sha256 in at_hand.values()
    if kept or (name is not None and at_hand.get(name) == sha256):
        return ""
    then = f"{checked.get('path')}, SHA-256 {sha256[:12]}…"
    if name is None:
        return f"The {kind} that the preflight checked ({then}) is gone."
    beside = ", and none of the certificates that were kept is" if kind == "calibration" else ""
    return f"{name} is not the {kind} that the preflight checked ({then}){beside}."
