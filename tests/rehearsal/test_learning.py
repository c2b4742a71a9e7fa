"""`design --learn`: what maneuvers tell of the robot, compared by the fit of their emulated drops."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.errors import UsageError
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.cross_validation import combine
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.maneuver import Maneuver, Schedule, schedule_maneuver
from tfsat_host.rehearsal import learning
from tfsat_host.rehearsal.learning import learn
from tfsat_host.robot import RobotModel, Uncertainty, load_robot

ROBOT = load_robot()
_fit_of, _candidates = learning._fit_of, learning._candidates
# Opens all joints in turn, then closes them in the same order: a closed loop of six strokes.
SIX = "+1 +2 +3 -1 -2 -3"


@cache
def fit_of(schedule: Schedule) -> ModelFit:
    return _fit_of(ROBOT, schedule)


class SerialPool:
    """A pool that works in this process, each maneuver once."""

    def __init__(self, *_: object) -> None: ...

    def __enter__(self) -> SerialPool:
        return self

    def __exit__(self, *_: object) -> None: ...

    @staticmethod
    def map(_: object, schedules: list[Schedule]) -> Iterator[ModelFit]:
        return map(fit_of, schedules)


@pytest.fixture
def two_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Restrict the candidates to a loop of two joints and one of three."""

    def chosen(robot: RobotModel) -> Iterator[tuple[str, Maneuver]]:
        # Each candidate costs a drop and a fit: one loop of each kind will do.
        prefixes = (f"to learn: {SIX} by 57/", "to learn: +1 +3 -1 -3 by 7")
        yield from ((name, maneuver) for name, maneuver in _candidates(robot) if name.startswith(prefixes))

    monkeypatch.setattr(learning, "_candidates", chosen)
    monkeypatch.setattr(learning, "worker_pool", SerialPool)


def test_candidates_are_flown_one_stroke_after_another() -> None:
    names, maneuvers = zip(*_candidates(ROBOT), strict=True)
    assert len(set(names)) == len(names) > 40
    for maneuver in maneuvers:
        schedule = schedule_maneuver(maneuver)
        # The fall lasts 2.5 s; a loop that closes leaves the robot as it was hung up.
        assert schedule.end_s <= 2.5
        assert sum(stroke.angle_deg for stroke in maneuver.strokes) == pytest.approx(0.0)


@pytest.mark.usefixtures("two_candidates")
def test_what_tells_most_comes_first_and_two_drops_tell_more() -> None:
    shares: list[float] = []
    search = learn(ROBOT, "com", shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert SIX in search.lessons[0].name and "+1 +3" in search.lessons[-1].name
    by_rank = [search.rms(lesson) for lesson in search.lessons]
    # The least standard deviation first; the paper's maneuver lies between the two.
    assert by_rank == sorted(by_rank) and by_rank[0] < search.rms(search.usual) < by_rank[-1]
    assert search.rms(*search.pair) < by_rank[0]
    # Two different drops may tell as much as the best one flown twice, or more.
    assert search.rms(*search.pair) <= search.rms(search.lessons[0], search.lessons[0])
    assert len(search.names) == 9 and search.unit == "mm"
    first, second = search.pair
    combined = combine([first.fit, second.fit])
    # Of offsets that are not those of the file the information is a little another one.
    assert search.std(first, second) == pytest.approx(np.sqrt(np.diag(combined.covariance)[:9]), rel=0.02)


@pytest.mark.usefixtures("two_candidates")
def test_another_quantity_has_its_own_order_and_an_exact_one_none() -> None:
    search = learn(ROBOT, "hinge-points")
    assert [name.rsplit(" ", 2)[1] for name in search.names] == ["point"] * 6
    assert (search.std(search.lessons[0]) < 0.5).all(), "less than the file says"
    # Masses without an uncertainty are no numbers that could be learnt.
    exact = model_offsets(replace(ROBOT, uncertainty=Uncertainty(com_m=0.003)))
    assert not learning._rows(exact, "masses") and len(learning._rows(exact, "com")) == 9


def test_a_robot_that_no_board_flies_is_refused() -> None:
    with pytest.raises(UsageError, match="no robot that both boards fly"):
        learn(load_robot("cubesat_3u"), "com")


@pytest.mark.usefixtures("two_candidates")
def test_the_command_writes_the_best_and_the_other_of_the_pair(tfsat_host: RunCli) -> None:
    design = tfsat_host.json("design", "--learn", "com")
    assert design["wanted"] == "com" and design["compared"] == 3
    assert [maneuver["drops"] for maneuver in design["maneuvers"]][-2:] == [2, 2]
    for file in design["files"]:
        # What the drop tower has against it is said, and no matter here.
        dry_run = tfsat_host("upload-sequence", "--file", file, "--dry-run", "--json", expect=None)
        assert json.loads(dry_run.stdout)["end_s"] <= 2.5
    process = tfsat_host("design", "--learn", "com")
    assert "÷ 59/70's" in process.stdout and "tfsat-host envelope --file maneuver.toml" in process.stdout
    refused = tfsat_host("design", "--learn", "com", "--time-limit", 1, expect=2)
    assert "--time-limit: --learn compares maneuvers that use the whole fall" in refused.stderr
