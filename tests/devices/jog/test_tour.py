"""A tour of stops: held from the first to the last, followed by whoever watches, limp at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest

from tests.devices.jog.test_lost_board import Board
from tests.devices.jog.test_motion import angles_deg, fastest_deg_s, go_on, is_limp
from tests.devices.scripted import ScriptedTransport
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.devices.jog_path import JogEnd, JogError, JogRefused, JogTour
from tfsat_host.devices.jogging import JogClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_SPEED_CDEG_S
from tfsat_host.protocol.messages import JogRequest

TOUR = JogTour(1, (0, 2000, 500, 1000), 0.4)


class Watch:
    """Remembers what it is told."""

    def __init__(self, pause: Callable[[float], None]) -> None:
        self._pause = pause
        self.reports: list[tuple[int, int]] = []
        self.rests: list[int] = []
        self.states: set[SequencerState] = set()
        self.rest_action: Callable[[int], None] = self.rests.append

    def pause(self, duration_s: float) -> None:
        self._pause(duration_s)

    def on_angle(self, stop: int, angle_cdeg: int) -> None:
        self.reports.append((stop, angle_cdeg))

    def on_rest(self, stop: int) -> None:
        self.rest_action(stop)


@pytest.fixture
def robot() -> Iterator[EmulatedRobot]:
    with EmulatedRobot() as emulated_robot:
        emulated_robot.advance(SETTLE_US)
        emulated_robot.hold((3,))
        emulated_robot.record_truth(5_000)
        yield emulated_robot


@pytest.fixture
def sequencer(robot: EmulatedRobot) -> JogClient:
    return JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))


def test_it_rests_at_each_stop_and_is_let_go_only_at_the_end(
    robot: EmulatedRobot, sequencer: JogClient
) -> None:
    watch = Watch(sequencer.wait)
    rested: list[tuple[float, float, SequencerState]] = []

    def look(stop: int) -> None:
        watch.rests.append(stop)
        path = angles_deg(robot, 1)
        # The last 0.2 s before the stop counts as resting.
        still = path[path[:, 0] > path[-1, 0] - 0.2]
        rested.append((still[-1, 1], float(np.ptp(still[:, 1])), sequencer.status().state))

    watch.rest_action = look
    start_us = robot.now_us
    assert sequencer.tour(TOUR, go_on, watch) == JogEnd(True, 1000)
    assert watch.rests == [0, 1, 2, 3]
    # Each stop: reached, still, and held.
    for (angle_deg, spread_deg, state), stop_cdeg in zip(rested, TOUR.stops_cdeg, strict=True):
        assert angle_deg == pytest.approx(stop_cdeg / 100, abs=0.5)
        assert spread_deg < 0.1
        assert state == SequencerState.JOGGING
    assert (robot.now_us - start_us) * 1e-6 == pytest.approx(TOUR.duration_s, abs=0.15 * len(TOUR.stops_cdeg))
    assert fastest_deg_s(robot, 1) < 1.3 * JOG_SPEED_CDEG_S / 100
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 1)


def test_what_is_shown_goes_from_stop_to_stop(robot: EmulatedRobot, sequencer: JogClient) -> None:
    watch = Watch(sequencer.wait)
    sequencer.tour(TOUR, go_on, watch)
    assert [stop for stop, _ in watch.reports] == sorted(stop for stop, _ in watch.reports)
    # Angles go from stop to stop in one direction.
    for stop, (before, after) in enumerate(pairwise((0, *TOUR.stops_cdeg))):
        angles = [angle_cdeg for reported_stop, angle_cdeg in watch.reports if reported_stop == stop]
        assert angles[-1] == after
        assert min(before, after) <= min(angles) <= max(angles) <= max(before, after)
        assert angles == sorted(angles, reverse=after < before)


@pytest.mark.parametrize("stop", [0, 1, 2])
def test_whoever_watches_can_end_it(robot: EmulatedRobot, sequencer: JogClient, stop: int) -> None:
    watch = Watch(sequencer.wait)

    def fail(rested: int) -> None:
        if rested == stop:
            raise ZeroDivisionError

    watch.rest_action = fail
    with pytest.raises(ZeroDivisionError):
        sequencer.tour(TOUR, go_on, watch)
    assert watch.reports[-1] == (stop, TOUR.stops_cdeg[stop])
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 1)


def test_a_wish_to_stop_lets_the_joint_go_between_stops(robot: EmulatedRobot, sequencer: JogClient) -> None:
    watch = Watch(sequencer.wait)
    # A wish to stop while the third stop is approached.
    end = sequencer.tour(TOUR, lambda: bool(watch.reports) and watch.reports[-1][0] == 2, watch)
    assert not end.held
    assert watch.rests == [0, 1]
    assert is_limp(robot, 1)


def test_an_impatient_ctrl_c_lets_it_go_too(robot: EmulatedRobot, sequencer: JogClient) -> None:
    def interrupt(duration_s: float) -> None:
        sequencer.wait(duration_s)
        if len(watch.reports) > 12:
            raise KeyboardInterrupt

    watch = Watch(interrupt)
    assert not sequencer.tour(TOUR, go_on, watch).held
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 1)


def test_a_watch_that_takes_too_long_finds_the_joint_let_go(
    robot: EmulatedRobot, sequencer: JogClient
) -> None:
    watch = Watch(sequencer.wait)
    # 1.2 s at each stop: longer than the board waits for orders.
    watch.rest_action = lambda _stop: robot.advance(1_200_000)
    with pytest.raises(JogError, match="This computer was away for") as caught:
        sequencer.tour(TOUR, go_on, watch)
    assert caught.value.next_step.endswith("then bring it to 0 deg by hand and type the same command again.")
    assert is_limp(robot, 1)


def test_stops_beyond_the_boards_limits_are_refused(robot: EmulatedRobot, sequencer: JogClient) -> None:
    with pytest.raises(JogRefused, match=r"A stop at 90\.01 deg is outside joint 2's limits, 0 to 90 deg"):
        sequencer.check_tour(JogTour(2, (0, 9001, 0), 1.0))
    sequencer.check_tour(JogTour(2, (0, 9000, 0), 1.0))


def test_only_a_safe_board_takes_it(robot: EmulatedRobot, sequencer: JogClient) -> None:
    robot.seat()
    sequencer.upload(schedule_maneuver(four_stroke(59, 69)))
    sequencer.arm()
    with pytest.raises(BoardRefusal):
        sequencer.check_tour(TOUR)
    with pytest.raises(BoardRefusal):
        sequencer.tour(TOUR, go_on, Watch(sequencer.wait))
    assert sequencer.status().state == SequencerState.ARMED, "a refused tour must not disarm"


def test_a_lost_order_to_go_on_is_repeated_only_after_asking_whether_the_joint_is_still_held() -> None:
    board = Board()
    transport = ScriptedTransport(board)
    client = JogClient.connect(transport)
    watch = Watch(client.wait)

    def lose_the_next(stop: int) -> None:
        watch.rests.append(stop)
        # The next three orders are lost.
        board.ignores_orders = 3

    watch.rest_action = lose_the_next
    with pytest.raises(JogError, match="was commanded to 1 deg only after 4 s; 30 deg was asked for"):
        client.tour(JogTour(1, (100, 3000), 0.0), go_on, watch)
    assert watch.rests == [0]
    assert board.state == SequencerState.SAFE
    types = [frame.type for frame in transport.requests]
    assert board.ignores_orders == 0
    assert (JogRequest.TYPE, JogRequest.TYPE) not in set(pairwise(types))
