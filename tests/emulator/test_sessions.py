"""Session ids: another for each drop, the same for the same drop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.rehearsal.days import rehearse_drop
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.rehearsed_drop import session_seed
from tfsat_host.rehearsal.truth import truth_as_filed
from tfsat_host.robot import load_robot


def first_session(**seeds: int) -> int:
    with EmulatedRobot(**seeds) as robot:  # type: ignore[arg-type]
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        return logger.start_recording().session


def session_seed_of(first_deg: float, seed: int, rate_rad_s: tuple[float, float, float]) -> int:
    truth = replace(truth_as_filed(load_robot(), seed), rate_rad_s=np.array(rate_rad_s))
    return session_seed(schedule_maneuver(four_stroke(first_deg, 70)), truth, None, ())


def rehearsed_session(first_deg: float, seed: int, rate_rad_s: tuple[float, float, float]) -> int:
    schedule = schedule_maneuver(four_stroke(first_deg, 70))
    return rehearse_drop(schedule, seed=seed, rate_rad_s=rate_rad_s).recording.session


def test_without_a_seed_each_robot_has_its_own() -> None:
    assert first_session() != first_session()


def test_a_seed_repeats_it_and_a_session_seed_alone_decides() -> None:
    assert first_session(seed=3) == first_session(seed=3)
    assert first_session(seed=3) != first_session(seed=4)
    assert first_session(seed=3, session_seed=9) == first_session(seed=4, session_seed=9)


def test_two_rehearsals_share_one_only_if_they_are_the_same_drop() -> None:
    still, turning = (0.0, 0.0, 0.0), (0.01, 0.0, 0.0)
    base = rehearsed_session(59, 1, still)
    drops = [(59, 1, still), (58, 1, still), (59, 2, still), (59, 1, turning)]
    seeds = [session_seed_of(*drop) for drop in drops]
    assert len(set(seeds)) == 4 and seeds == [session_seed_of(*drop) for drop in drops]
    assert rehearsed_session(59, 1, turning) != base
