"""What a jog does to the emulated robot's joint: slowly there, held, and limp at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.devices.jog_path import Jog, JogEnd, JogError, JogRefused
from tfsat_host.devices.jogging import ORDER_S, JogClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot, EmulationError
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.protocol.messages import SequencerStatusReply

SPEED_DEG_S = JOG_SPEED_CDEG_S / 100
TRUTH_US = 5_000
LIMP_AFTER_US = 120_000
"""A servo goes limp 100 ms after its last pulse."""


@pytest.fixture
def robot() -> Iterator[EmulatedRobot]:
    with EmulatedRobot() as emulated_robot:
        emulated_robot.advance(SETTLE_US)
        emulated_robot.hold((3,))
        emulated_robot.record_truth(TRUTH_US)
        yield emulated_robot


@pytest.fixture
def sequencer(robot: EmulatedRobot) -> JogClient:
    return JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))


def go_on() -> bool:
    return False


def ignore(_angle_cdeg: int) -> None:
    pass


def angles_deg(robot: EmulatedRobot, joint: int) -> NDArray[np.float64]:
    """(n, 2): seconds and the joint's true angle."""
    truth = robot.truth()
    return np.column_stack([truth[:, 0], np.rad2deg(truth[:, joint])])


def fastest_deg_s(robot: EmulatedRobot, joint: int) -> float:
    """Over a tenth of a second: a digital servo follows each pulse in a small step."""
    path = angles_deg(robot, joint)
    # Over a tenth of a second, so that the small steps of a digital servo do not count.
    step = 100_000 // TRUTH_US
    return float(np.max(np.abs(path[step:, 1] - path[:-step, 1])) / 0.1)


def is_limp(robot: EmulatedRobot, joint: int) -> bool:
    robot.advance(LIMP_AFTER_US)
    try:
        robot.swing(joint, 1.0, 0.1, 1)
    except EmulationError:
        return False
    return True


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_the_joint_goes_slowly_and_ends_limp(robot: EmulatedRobot, sequencer: JogClient, joint: int) -> None:
    reported_angles_cdeg: list[int] = []
    assert sequencer.run(Jog(joint, 0, 3000), 0.0, go_on, reported_angles_cdeg.append) == JogEnd(True, 3000)
    path = angles_deg(robot, joint)
    assert path[-1, 1] == pytest.approx(30.0, abs=0.5)
    # Slower than 1.3 times the jog's speed at any moment.
    assert fastest_deg_s(robot, joint) < 1.3 * SPEED_DEG_S
    moving = (path[:, 1] > 1.0) & (path[:, 1] < 29.0)
    # From 1 to 29 deg in the time that the speed asks for.
    assert np.count_nonzero(moving) * TRUTH_US * 1e-6 == pytest.approx(28.0 / SPEED_DEG_S, rel=0.1)
    for other in {1, 2, 3} - {joint}:
        # The other joints stay limp and hang where they are.
        assert np.ptp(angles_deg(robot, other)[:, 1]) < 0.5
    assert (
        reported_angles_cdeg[0] == 0
        and reported_angles_cdeg[-1] == 3000
        and reported_angles_cdeg == sorted(reported_angles_cdeg)
    )
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, joint)


def test_it_is_held_longer_than_the_board_waits_for_orders(
    robot: EmulatedRobot, sequencer: JogClient
) -> None:
    # Four times the board's own patience: orders must keep coming.
    hold_s = 4 * JOG_IDLE_MS / 1000
    still_held: list[bool] = []

    def look(angle_cdeg: int) -> None:
        if angle_cdeg == 1500:
            # Swung by hand at each report: a held joint resists.
            still_held.append(not is_limp(robot, 1))

    start_us = robot.now_us
    assert sequencer.run(Jog(1, 0, 1500), hold_s, go_on, look).held
    assert robot.now_us - start_us >= (hold_s + 1) * 1_000_000
    assert len(still_held) > 10 and all(still_held)
    assert is_limp(robot, 1)


def test_a_wish_to_stop_lets_the_joint_go_on_its_way(robot: EmulatedRobot, sequencer: JogClient) -> None:
    reported_angles_cdeg: list[int] = []
    end = sequencer.run(
        Jog(2, 0, 9000),
        0.0,
        lambda: bool(reported_angles_cdeg) and reported_angles_cdeg[-1] > 2000,
        reported_angles_cdeg.append,
    )
    assert not end.held
    assert 20 < angles_deg(robot, 2)[-1, 1] < 30
    # Within 3 deg of the truth: what it was told lags by a poll.
    assert end.angle_cdeg / 100 == pytest.approx(angles_deg(robot, 2)[-1, 1], abs=3)
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 2)


def test_an_exception_lets_the_joint_go(robot: EmulatedRobot, sequencer: JogClient) -> None:
    def fail(angle_cdeg: int) -> None:
        # An error of the caller must not leave a driven servo.
        if angle_cdeg > 1000:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        sequencer.run(Jog(1, 0, 9000), 0.0, go_on, fail)
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 1)


def test_an_impatient_ctrl_c_says_where_the_joint_is_too(robot: EmulatedRobot, sequencer: JogClient) -> None:
    def interrupt(angle_cdeg: int) -> None:
        if angle_cdeg > 1000:
            raise KeyboardInterrupt

    end = sequencer.run(Jog(1, 0, 9000), 0.0, go_on, interrupt)
    assert not end.held and 1000 < end.angle_cdeg < 1500
    assert sequencer.status().state == SequencerState.SAFE
    assert is_limp(robot, 1)


def test_a_restart_of_the_board_ends_the_jog_without_a_jerk(
    robot: EmulatedRobot, sequencer: JogClient
) -> None:
    restarted: list[int] = []

    def restart(angle_cdeg: int) -> None:
        if angle_cdeg > 3000 and not restarted:
            restarted.append(angle_cdeg)
            robot.set_power(BoardIndex.SEQUENCER, False)
            robot.advance(50_000)
            robot.set_power(BoardIndex.SEQUENCER, True)

    with pytest.raises(
        JogError, match=r"restarted 0\.\d s ago \(power on\), which ended the jog\. It is safe"
    ):
        sequencer.run(Jog(1, 0, 6000), 0.0, go_on, restart)
    assert restarted
    # No jerk: the new program must not pull the joint back.
    assert fastest_deg_s(robot, 1) < 1.3 * SPEED_DEG_S
    assert is_limp(robot, 1)


def test_only_a_safe_board_jogs(robot: EmulatedRobot, sequencer: JogClient) -> None:
    robot.seat()
    sequencer.upload(schedule_maneuver(four_stroke(59, 69)))
    sequencer.arm()
    with pytest.raises(BoardRefusal):
        sequencer.check(Jog(1, 0, 1000))
    with pytest.raises(BoardRefusal):
        sequencer.run(Jog(1, 0, 1000), 0.0, go_on, ignore)
    # A refusal that disarmed a board in the tower would cost the drop.
    assert sequencer.status().state == SequencerState.ARMED, "a refused jog must not disarm"


@pytest.mark.parametrize(("start", "end", "option"), [(0, 9100, "--to 91"), (-100, 100, "--from -1")])
def test_limits_are_those_of_the_board(
    sequencer: JogClient, robot: EmulatedRobot, start: int, end: int, option: str
) -> None:
    with pytest.raises(JogRefused, match=f"{option} is outside joint 1's limits, 0 to 90 deg"):
        sequencer.check(Jog(1, start, end))


def test_four_orders_a_second_say_where_the_joint_is(
    robot: EmulatedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Send four jog orders a second, with `from` at the joint's present angle.

    A board that restarted unnoticed takes the next order for a new jog: `from` must not pull it back.
    """
    from tfsat_host.devices.client import Client
    from tfsat_host.protocol.messages import JogRequest

    sent: list[tuple[float, JogRequest]] = []
    request: Callable[..., object] = Client.request

    def spy(self: Client, message: object, reply_type: object, **options: int) -> object:
        if isinstance(message, JogRequest):
            sent.append((self.transport.now_s(), message))
        return request(self, message, reply_type, **options)

    monkeypatch.setattr(Client, "request", spy)
    sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
    sequencer.run(Jog(1, 0, 9000), 2.0, go_on, ignore)
    times_s = np.array([time_s for time_s, _ in sent])
    # A quarter of the board's patience: three orders may get lost.
    assert ORDER_S == JOG_IDLE_MS / 4000 == 0.25
    assert np.all(np.diff(times_s) < 0.3) and np.all(np.diff(times_s) > 0.24)
    # Six seconds of motion and two of holding.
    assert len(sent) > (6.0 + 2.0) / 0.3
    for time_s, message in sent:
        expected_cdeg = min(9000, JOG_SPEED_CDEG_S * (time_s - times_s[0]))
        # `from` is where the joint is by then, not where the jog began.
        assert message.from_cdeg == pytest.approx(expected_cdeg, abs=100)
        assert message.to_cdeg == 9000


def test_a_host_that_falls_silent_lets_the_joint_go(robot: EmulatedRobot, sequencer: JogClient) -> None:
    frozen: list[float] = []

    def freeze(angle_cdeg: int) -> None:
        if angle_cdeg > 2000 and not frozen:
            # Longer than the board waits for orders.
            robot.advance(JOG_IDLE_MS * 1000 + 100_000)
            frozen.append(angles_deg(robot, 1)[-1, 1])
            assert is_limp(robot, 1)

    with pytest.raises(JogError, match="This computer was away for"):
        sequencer.run(Jog(1, 0, 9000), 0.0, go_on, freeze)
    # At most the way of that time at full speed.
    assert 20 < frozen[0] < 20 + 1.2 * SPEED_DEG_S * JOG_IDLE_MS / 1000 + 3
    assert is_limp(robot, 1)


def test_an_answer_from_before_a_freeze_orders_nothing(
    robot: EmulatedRobot, sequencer: JogClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Answers from before a freeze lead to no order.

    The board would take an order for a joint that it has released as a new jog.
    """
    frozen_deg: list[float] = []
    ask = JogClient.status

    def status_and_freeze(self: JogClient) -> SequencerStatusReply:
        answer = ask(self)
        # This answer is from before the freeze: no order may follow from it.
        if answer.joint_angle_cdeg[0] > 2000 and not frozen_deg:
            robot.advance(JOG_IDLE_MS * 1000 + 100_000)
            assert is_limp(robot, 1)
            frozen_deg.append(angles_deg(robot, 1)[-1, 1])
        return answer

    monkeypatch.setattr(JogClient, "status", status_and_freeze)
    with pytest.raises(JogError, match="This computer was away for"):
        sequencer.run(Jog(1, 0, 9000), 0.0, go_on, ignore)
    # Where it was let go, and not a degree farther.
    assert angles_deg(robot, 1)[-1, 1] == pytest.approx(frozen_deg[0], abs=1.0)
    assert is_limp(robot, 1)
