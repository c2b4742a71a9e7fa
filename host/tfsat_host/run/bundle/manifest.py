"""What a bundle says of itself: its files with their hashes, how they were evaluated, and what is missing."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Annotated, Any

from tfsat_host import json_values
from tfsat_host.errors import TfsatError

MANIFEST = "manifest.json"
EVALUATION = "evaluation.json"
REPORT = "report.html"
ENVIRONMENT = "environment.json"
FORMAT = 1
NAME_CHARACTERS_MAX = 200
"""Of a drop's name: a folder's has no more on most systems."""
_FILES = ("maneuver", "calibration", "robot", "facility", "video", "laser")
_FLAGS = ("masses", "inertias", "swarm")


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
class Evaluated:
    """How the drop was evaluated, by names in the bundle; None: none was used.

    Attributes:
        recording: The raw log.
        maneuver, calibration, robot, facility, video, laser: Files.
        session: Which recording of the file, 8 hexadecimal digits; None: as `decode` chooses.
        masses, inertias, swarm: As the options of `evaluate`.
    """

    recording: str
    maneuver: str | None = None
    calibration: str | None = None
    robot: str | None = None
    facility: str | None = None
    video: str | None = None
    laser: str | None = None
    session: Annotated[str, json_values.session_id] | None = None
    masses: bool = False
    inertias: bool = False
    swarm: bool = False

    @property
    def files(self) -> dict[str, str]:
        """Of those besides the recording that were used: the name of each, by its kind."""
        return {kind: getattr(self, kind) for kind in _FILES if getattr(self, kind) is not None}

    def options(self) -> tuple[str, ...]:
        """As they are typed for `evaluate`, with the bundle's names."""
        session = () if self.session is None else (f"--session {self.session}",)
        flags = (f"--{name}" for name in _FLAGS if getattr(self, name))
        return (*(f"--{kind} {name}" for kind, name in self.files.items()), *session, *flags)


@dataclass(frozen=True)
class Manifest:
    """All that stands in `manifest.json`.

    Attributes:
        made_by: Command and version.
        name: Of the drop.
        evaluated: How.
        images: Hashes of the firmware that flew, by board.
        files: All files but the manifest, by name.
        missing: What is not there.
        record: What is not as the run's record says; sentences.
        doubts: What else stands against the drop: samples that were lost, files of another robot; sentences.
        left_out: Files of the run that were not taken, and why.
    """

    made_by: str
    name: Annotated[str, _drop_name]
    evaluated: Evaluated
    images: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, BundledFile] = field(default_factory=dict)
    missing: tuple[Missing, ...] = ()
    record: tuple[str, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "made_by": self.made_by,
            "format": FORMAT,
            "name": self.name,
            "evaluated": vars(self.evaluated),
            "images": dict(self.images),
            "missing": [asdict(one) for one in self.missing],
            "record": list(self.record),
            "doubts": list(self.doubts),
            "left_out": dict(self.left_out),
            "files": {name: asdict(file) for name, file in sorted(self.files.items())},
        }


def format_manifest(manifest: Manifest) -> str:
    """The file's text."""
    return json.dumps(manifest.as_dict(), indent=1) + "\n"


def parse_manifest(data: bytes, source: str) -> Manifest:
    """What `format_manifest` wrote; `source` is the name that errors give it.

    Raises:
        BundleError: it is no manifest, or one of another format.
    """
    try:
        values = _whole(json.loads(data.decode("utf-8")))
        if values["format"] != FORMAT:
            raise ValueError(f"its format is {values['format']!r}, this program reads {FORMAT}")
        return json_values.parsed(Manifest, values, optional=("doubts",))  # older bundles have none
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise BundleError(
            what=f"The manifest of {source} cannot be understood: {_why(error)}.",
            meaning="What the bundle should hold is not known; nothing was unpacked.",
            next_step="Take the bundle from a copy, or use the tfsat-host that made it.",
        ) from error


def _why(error: Exception) -> str:
    """In words that are not Python's."""
    if isinstance(error, KeyError):
        return f"it has no {error.args[0]}"
    if isinstance(error, json.JSONDecodeError | UnicodeDecodeError):
        return "it is no JSON text"
    if isinstance(error, ValueError):
        return str(error)
    return "something in it is not what a bundle has there"


def _whole(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("it is no list of files")
    return value
