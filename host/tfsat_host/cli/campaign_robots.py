"""The drops of a campaign by the robot that flew: each robot's are compared by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.evaluate.dropped_robot import DroppedRobot, dropped_robot
from tfsat_host.cli.evaluate.several import Comparison, comparison_as_dict, show_comparison
from tfsat_host.cli.output import Output
from tfsat_host.file_hash import sha256_of

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun

_SHOWN = 8
_Key = tuple[DroppedRobot, str]


@dataclass(frozen=True, eq=False)
class OfOneRobot:
    """The drops of one robot, evaluated with one robot file.

    Attributes:
        robot: By the logger's own words.
        model_sha256: Of the robot file.
        name: As much of both as tells it from the campaign's other ones.
        numbers: Of the drops.
        compared: What they say together; None: there is but one.
    """

    robot: DroppedRobot
    model_sha256: str
    name: str
    numbers: tuple[int, ...]
    compared: Comparison | None

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "robot": self.robot.kind,
            "logger_serial": self.robot.logger_serial,
            "robot_sha256": self.model_sha256,
            "drops": list(self.numbers),
            "comparison": None if self.compared is None else comparison_as_dict(self.compared),
        }


def by_robot(done: Sequence[tuple[int, EvaluatedRun]]) -> list[OfOneRobot]:
    """Each robot's drops; `done` are their numbers and evaluations."""
    grouped: dict[_Key, list[tuple[int, EvaluatedRun]]] = {}
    for number, run in done:
        key = (dropped_robot(run.found.log), sha256_of(run.found.model.path))
        grouped.setdefault(key, []).append((number, run))
    return [
        OfOneRobot(
            *key,
            _name(key, list(grouped)),
            tuple(number for number, _ in drops),
            Comparison([run for _, run in drops]) if len(drops) > 1 else None,
        )
        for key, drops in grouped.items()
    ]


def _name(key: _Key, all_of_them: Sequence[_Key]) -> str:
    robot, sha256 = key
    alike = {one for one, _ in all_of_them if one.kind == robot.kind}
    name = str(robot) if len(alike) > 1 else f"{robot.kind} robot"
    files = [one for one in all_of_them if one[0] == robot]
    return f"{name}, robot file {sha256[:_SHOWN]}…" if len(files) > 1 else name


def show_robots(robots: Sequence[OfOneRobot], out: Output) -> None:
    """What each robot's drops say together, and that robots are kept apart."""
    if len(robots) > 1:
        out.line(
            f"The drops are of {len(robots)} robots or robot files: none is combined with those of another."
        )
    for robot in robots:
        if robot.compared is not None:
            out.line(f"The drops of the {robot.name} together:")
            show_comparison(robot.compared, out, robot.numbers)
        elif len(robots) > 1:
            out.line(f"Drop {robot.numbers[0]} is the only one of the {robot.name}: compared with nothing.")
