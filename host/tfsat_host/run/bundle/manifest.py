"""What a bundle says of itself: its files with their hashes, how and with what it was evaluated, what is missing."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

from tfsat_host import __version__, json_values
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import name_recording
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import Column, Columns, by_name, fields, record

MANIFEST = "manifest.json"
EVALUATION = "evaluation.json"
REPORT = "report.html"
ENVIRONMENT = "environment.json"
FORMAT = 1
NAME_CHARACTERS_MAX = 200
"""Of a drop's name: a folder's has no more on most systems."""
_FILES = ("maneuver", "calibration", "robot", "facility", "video", "laser")
_OPTIONAL = ("doubts", "video_rate")
"""Bundles of older programs have none."""
_PACKAGES = ("numpy", "scipy", "crcmod-plus", "fastcrc", "platformdirs", "pyserial", "rich", "rich-argparse")


class BundleError(TfsatError):
    """An archive is no bundle, is damaged or is not safe to unpack (exit code 1)."""


def _drop_name(value: object) -> str:
    name = json_values.text(value)
    if len(name) > NAME_CHARACTERS_MAX:
        raise ValueError(f"its name has {len(name)} characters, {NAME_CHARACTERS_MAX} are allowed")
    return name


@dataclass(frozen=True, slots=True)
class BundledFile:
    """A file as it was bundled: SHA-256 of its bytes, hexadecimal, and how many there are."""

    sha256: Annotated[str, json_values.sha256]
    bytes: int


@dataclass(frozen=True, slots=True)
class Missing:
    """What a whole bundle would have.

    Attributes:
        what: Such as `preflight.json`.
        why: A sentence.
        lost: It was there once, or should have been; otherwise it is merely not there.
    """

    what: str
    why: str
    lost: bool = False


@dataclass(frozen=True)
class EvaluationInputs:
    """How the drop was evaluated, by names in the bundle; None: none was used.

    Attributes:
        recording: The raw log.
        maneuver, calibration, robot, facility, video, laser: Files.
        video_rate: As the option of `evaluate`; None: not given.
        session: Which recording of the file, 8 hexadecimal digits; None: as `decode` chooses.
        swarm: As the option of `evaluate`.
        masses, inertias: As options of `evaluate` up to 0.1: all that is uncertain is fitted since.
    """

    recording: str
    maneuver: str | None = None
    calibration: str | None = None
    robot: str | None = None
    facility: str | None = None
    video: str | None = None
    laser: str | None = None
    session: Annotated[str, json_values.session_id] | None = None
    video_rate: float | None = None
    masses: bool = False
    inertias: bool = False
    swarm: bool = False

    @property
    def files(self) -> dict[str, str]:
        """Of those besides the recording that were used: the name of each, by its kind."""
        return {kind: getattr(self, kind) for kind in _FILES if getattr(self, kind) is not None}


@dataclass(frozen=True)
class Manifest:
    """All of `manifest.json`.

    Attributes:
        made_by: Command and version.
        name: Of the drop.
        evaluated: How.
        images: Hashes of the firmware that flew, by board.
        files: All files but the manifest, by name.
        missing: What is not there.
        record: What is not as the run's record says; sentences.
        left_out: Files of the run that were not taken, and why.
        doubts: What else makes the drop doubtful: samples that were lost, files of another robot; sentences.
    """

    made_by: str
    name: Annotated[str, _drop_name]
    evaluated: EvaluationInputs
    images: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, BundledFile] = field(default_factory=dict)
    missing: tuple[Missing, ...] = ()
    record: tuple[str, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    @property
    def lost(self) -> tuple[Missing, ...]:
        """What should be in the bundle and is not."""
        return tuple(part for part in self.missing if part.lost)

    @property
    def never_there(self) -> tuple[Missing, ...]:
        """What a whole bundle would have and this drop never had."""
        return tuple(part for part in self.missing if not part.lost)


MISSING: Columns = fields("what why lost")
MANIFEST_COLUMNS: Columns = (
    Column("made_by"),
    Column("format", of=lambda _: FORMAT),
    Column("name"),
    Column("evaluated", of=lambda manifest: asdict(manifest.evaluated)),
    Column("images"),
    Column("missing", columns=MISSING),
    *fields("record"),
    Column(
        "doubts",
        of=lambda manifest: [name_recording(text, manifest.evaluated.recording) for text in manifest.doubts],
    ),
    *fields("left_out"),
    Column(
        "files",
        of=lambda manifest: dict(sorted(manifest.files.items())),
        columns=by_name(fields("sha256 bytes")),
    ),
)
"""Of `manifest.json`, in its order."""


def format_manifest(manifest: Manifest) -> str:
    """Format a manifest as the text of its file."""
    return json_values.format_json(record(MANIFEST_COLUMNS, manifest))


def parse_manifest(data: bytes, source: str) -> Manifest:
    """Parse the output of `format_manifest`; `source` names it in errors.

    Raises:
        BundleError: it is no manifest, or one of another format.
    """
    try:
        values = json.loads(data.decode("utf-8"))
        if not isinstance(values, dict):
            raise ValueError("it is no list of files")
        if values["format"] != FORMAT:
            raise ValueError(f"its format is {values['format']!r}, this program reads {FORMAT}")
        return json_values.parse_dataclass(Manifest, values, _OPTIONAL)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise BundleError(
            what=f"The manifest of {source} cannot be understood: {_why(error)}.",
            meaning="What the bundle should hold is not known; nothing was unpacked.",
            next_step="Take the bundle from a copy, or use the tfsat-host that made it.",
        ) from error


def _why(error: Exception) -> str:
    """Describe a parse error in plain words instead of Python's."""
    if isinstance(error, KeyError):
        return f"it has no {error.args[0]}"
    if isinstance(error, json.JSONDecodeError | UnicodeDecodeError):
        return "it is no JSON text"
    return str(error) if isinstance(error, ValueError) else "something in it is not what a bundle has there"


def environment() -> dict[str, Any]:
    """Return the software and system that a result is computed with, for JSON.

    It identifies neither a person nor a computer.
    """
    return {
        "tfsat": __version__,
        "sources_sha256": sources_sha256(),
        "protocol_hash": PROTOCOL_HASH.hex(),
        "python": platform.python_version(),
        "implementation": platform.python_implementation(),
        "system": platform.system(),
        "release": platform.release(),
        "machine": platform.machine(),
        "byte_order": sys.byteorder,
        "packages": {name: _version(name) for name in _PACKAGES},
    }


@cache
def sources_sha256() -> str:
    """Compute the SHA-256 over the names and contents of tfsat's Python files.

    It distinguishes two states of the sources with the same version number.
    """
    package = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    # Sorted by POSIX name: the same sources give the same hash on every system.
    for name, path in sorted((path.relative_to(package).as_posix(), path) for path in package.rglob("*.py")):
        digest.update(f"{name} {sha256_of(path)}\n".encode())
    return digest.hexdigest()


def changed_since(before: Any) -> list[str]:
    """List how this computer's environment differs from that of a bundle, one sentence per difference."""
    if not isinstance(before, dict) or not isinstance(before.get("packages"), dict):
        return ["The bundle does not say with what it was computed."]
    now = environment()
    then, here = ({**snapshot, **snapshot["packages"]} for snapshot in (before, now))
    return [
        f"{key}: {then.get(key, 'unknown')} then, {value} now."
        for key, value in here.items()
        if key != "packages" and then.get(key, "unknown") != value
    ]


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
