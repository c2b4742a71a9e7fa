"""What can be asked of an evaluation, the same for every command and every program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import UsageError

_FILES = ("maneuver", "calibration", "robot", "video", "laser", "facility")
_FLAGS = ("masses", "inertias", "swarm")
_OF_ONE_DROP = ("session", "video", "laser")


@dataclass(frozen=True, slots=True)
class EvaluationOptions:
    """What is known of a drop besides its recording, and what of the model may be corrected.

    Attributes:
        maneuver: What was flown; None: `maneuver.toml` beside the recording, if it is there.
        calibration: The certificate; None: the one beside the recording or in the current folder, if there is one.
        robot: A robot file, or the name of a shipped one; None: `robot.toml` beside the recording, else `drop_tower`.
        video: Events of the drop in a video, CSV.
        laser: Places of the two laser spots over time, CSV.
        facility: For the release velocity that `laser` gives; None: COSMOTORRE's.
        session: Id of the recording in its file; None: as `sdlog.load` chooses.
        masses, inertias: Whether these may be corrected, too.
        swarm: Whether the paper's particle swarm looks for the centers of mass as well.
    """

    maneuver: Path | None = None
    calibration: Path | None = None
    robot: Path | str | None = None
    video: Path | None = None
    laser: Path | None = None
    facility: Path | None = None
    session: int | None = None
    masses: bool = False
    inertias: bool = False
    swarm: bool = False

    def typed(self) -> tuple[str, ...]:
        """As they are typed for `evaluate`; for the provenance of results."""
        given = [f"--{name} {getattr(self, name)}" for name in _FILES if getattr(self, name) is not None]
        given += [f"--session {self.session:08x}"] if self.session is not None else []
        return (*given, *(f"--{name}" for name in _FLAGS if getattr(self, name)))

    def check(self, places: Sequence[Path]) -> None:
        """What belongs to one drop only is refused for several.

        Raises:
            UsageError: it was given for several, or a drop twice, or a facility for nothing.
        """
        if self.facility is not None and self.laser is None:
            raise _wrong(
                "--facility says what release velocity is permitted, and only --laser tells that velocity."
            )
        if self.swarm and (self.masses or self.inertias):
            raise _wrong("--swarm searches for centers of mass alone, as the paper's does.")
        if len(places) == 1:
            return
        for name in _OF_ONE_DROP:
            if getattr(self, name) is not None:
                raise _wrong(f"--{name} belongs to one drop, and {len(places)} were named.")
        real = [place.resolve() for place in places]
        twice = next((place for i, place in enumerate(places) if real[i] in real[:i]), None)
        if twice is not None:
            raise _wrong(f"{twice} was named twice: one drop says nothing about itself.")


AS_FOUND = EvaluationOptions()
"""With what lies beside the recording."""


def _wrong(what: str) -> UsageError:
    return UsageError(what=what, meaning="Nothing was evaluated.", next_step="tfsat-host evaluate --help")
