"""The emulated operator's hands: what the bodies truly do in each step, and that the gyros see just that."""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.emulator.performance import Performance, perform
from tfsat_host.calibration.response import TILT_STD_RAD
from tfsat_host.calibration.steps.step import Step, rest, servo, sweeps, swings, turn, zero
from tfsat_host.devices.jog_path import Jog
from tfsat_host.devices.jogging import JogClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot, EmulationError
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.emulated.manual_motion import LEAD_S, Operator

STOPS_DEG = (30, 60, 90, 60, 30, 0) * 2
PERSON = Operator(
    tremor_deg_s=5.0,
    sway_deg_s=1.0,
    reaction=0.01,
    placing_deg=0.1,
    tilt_deg=0.1,
    variation=0.04,
    stopping_deg=3.0,
    seed=5,
)
SWEEP = sweeps(1)[1]
"""Body 1 is held, body 2 and 3 move about joint 1."""
SWING = swings(2)[0]
TURN = turn("z", 360.0)


def rests(performance: Performance) -> list[np.ndarray]:
    """Rows of the stretches of more than half a second in which nothing moves."""
    still = np.all(performance.rates_deg_s == 0.0, axis=(1, 2))
    ends = np.flatnonzero(np.diff(still)) + 1
    stretches = np.split(np.arange(len(still)), ends)
    return [rows for rows in stretches if still[rows[0]] and np.ptp(performance.t_s[rows]) > 0.5]


@pytest.fixture(scope="module")
def swept() -> Performance:
    return perform(SWEEP, PERSON)


@pytest.fixture(scope="module")
def turn_performance() -> Performance:
    return perform(TURN, PERSON)


@pytest.mark.parametrize("step", [SWING, SWEEP, TURN], ids=lambda step: step.key)
def test_rates_and_attitudes_are_of_one_motion(step: Step) -> None:
    performance = perform(step, PERSON)
    for body in range(4):
        attitude = performance.attitudes[body]
        between = (
            np.rad2deg((attitude[:-1].inv() * attitude[1:]).as_rotvec()) / np.diff(performance.t_s)[:, None]
        )
        mean = (performance.rates_deg_s[:-1, body] + performance.rates_deg_s[1:, body]) / 2
        assert np.abs(between - mean).max() < 0.01


@pytest.mark.parametrize("step", [SWING, SWEEP, TURN], ids=lambda step: step.key)
def test_what_the_gyros_read_adds_up_to_the_true_motion(step: Step) -> None:
    performance = perform(step, PERSON)
    read = np.deg2rad(performance.gyros_deg_s())
    t_s = (performance.counts.t_us - performance.counts.t_us[0]) * 1e-6
    ends_s = [
        float(performance.t_s[rows[-1]]) - 0.05 for rows in rests(performance)[1:]
    ]  # the low-pass has settled
    assert len(ends_s) == {"swing": 1, "sweep": 12, "turn": 6}[step.kind]
    for body in range(4):
        turned = Rotation.from_rotvec((read[:-1, body] + read[1:, body]) / 2 * np.diff(t_s)[:, None])
        sums = list(accumulate(turned, lambda passed, increment: passed * increment))
        for end_s in ends_s:
            truth = performance.attitudes[body][0].inv() * performance.attitudes[body][performance.at(end_s)]
            passed = sums[int(np.searchsorted(t_s, end_s)) - 1]
            assert np.rad2deg((truth.inv() * passed).magnitude()) < 0.05


def test_a_sweep_rests_near_its_stops_within_the_range(swept: Performance) -> None:
    angles = swept.joints_deg[:, 0]
    assert angles.min() >= 0.0 and angles.max() <= 90.0
    stopped = rests(swept)
    assert len(stopped) == 1 + len(STOPS_DEG)
    assert angles[stopped[0]].tolist() == [0.0] * len(stopped[0])
    for rows, stop_deg in zip(stopped[1:], STOPS_DEG, strict=True):
        assert np.ptp(angles[rows]) == 0.0
        assert abs(angles[rows[0]] - stop_deg) <= 3.0
        assert np.ptp(swept.t_s[rows]) >= 0.95
    assert len({round(float(angles[rows[0]]), 6) for rows in stopped}) == len(stopped)


def test_a_hand_gives_way_by_the_reaction_and_no_more(swept: Performance) -> None:
    axes = []
    for rows in rests(swept)[1:]:
        moved_deg = swept.joints_deg[rows[0], 0]
        hand_turn_deg = swept.turn_deg(1, float(swept.t_s[rows[0]]))
        assert np.linalg.norm(hand_turn_deg) == pytest.approx(0.01 * moved_deg, abs=1e-6)
        axes += [hand_turn_deg / np.linalg.norm(hand_turn_deg)] if moved_deg > 10 else []
    assert np.ptp(axes, axis=0).max() < 1e-6
    assert np.abs(swept.rates_deg_s[:, 0]).max() > 1.0  # and it sways on the way


def test_a_tremor_has_the_rate_that_was_asked_for() -> None:
    still = replace(Operator.steady(), seed=3)
    exact = perform(SWEEP, still).joints_deg[:, 0]
    shaken = perform(SWEEP, replace(still, tremor_deg_s=5.0)).joints_deg[:, 0]
    n = min(len(exact), len(shaken))
    extra = np.diff(shaken[:n] - exact[:n]) / 0.002
    moving = np.abs(np.diff(exact[:n])) > 0.02  # more than 10 deg/s: full tremor, but near the stops
    assert np.sqrt(np.mean(extra[moving] ** 2)) == pytest.approx(5.0, rel=0.2)
    assert np.abs(extra[~moving]).mean() < 2.0


def test_a_turn_ends_where_the_edge_is_within_the_placing_error(turn_performance: Performance) -> None:
    stopped = rests(turn_performance)
    assert len(stopped) == 7
    ends = [turn_performance.turn_deg(1, float(turn_performance.t_s[rows[0]])) for rows in stopped]
    off = np.array([np.linalg.norm(end) for end in ends[1:]])  # 360 deg is where it began
    assert 0.01 < off.max() < 0.6
    assert len(set(np.round(off, 9))) == 6
    passed = np.cumsum(turn_performance.rates_deg_s[:, 0, 2]) * 0.002
    assert [passed[rows[0]] for rows in stopped[1:]] == pytest.approx([360, 0] * 3, abs=0.7)
    for body in (2, 3, 4):
        assert turn_performance.rates_deg_s[:, body - 1] == pytest.approx(
            turn_performance.rates_deg_s[:, 0], abs=1e-9
        )


def test_a_turns_axis_is_tilted_a_little_and_a_steady_ones_is_not() -> None:
    tilted = perform(TURN, replace(Operator.steady(), tilt_deg=0.1, seed=4)).rates_deg_s[:, 0]
    row = tilted[np.argmax(np.abs(tilted[:, 2]))]
    assert 0.01 < np.rad2deg(np.arccos(abs(row[2]) / np.linalg.norm(row))) < 0.4
    steady = perform(TURN)
    assert np.abs(steady.rates_deg_s[:, :, :2]).max() < 1e-9
    assert np.linalg.norm(steady.turn_deg(1, 6.0)) < 1e-9
    assert steady.turn_deg(1, LEAD_S + 2.0)[2] == pytest.approx(180.0, abs=1e-6) or (
        steady.turn_deg(1, LEAD_S + 2.0)[2] == pytest.approx(-180.0, abs=1e-6)
    )


def test_a_steady_sweep_is_exact() -> None:
    performance = perform(SWEEP)
    stops = [float(performance.joints_deg[rows[0], 0]) for rows in rests(performance)]
    assert stops == pytest.approx([0, *STOPS_DEG], abs=1e-9)
    assert np.abs(performance.rates_deg_s[:, 0]).max() < 1e-9


def test_a_swing_goes_out_and_back_five_times_each_differently() -> None:
    performance = perform(SWING, PERSON)
    angles = performance.joints_deg[:, 1]
    tops = [
        angles[i]
        for i in range(1, len(angles) - 1)
        if angles[i - 1] < angles[i] >= angles[i + 1] and angles[i] > 45
    ]
    high = np.array([top for top in tops if top > 52])
    assert len(high) >= 5 and np.ptp(high) > 1.0
    assert angles.min() >= 0.0 and angles.max() <= 90.0
    assert angles[0] == 0.0 and angles[-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("step", [rest(), zero(None), zero(2)], ids=lambda step: step.key)
def test_nothing_moves_in_a_rest(step: Step) -> None:
    performance = perform(step, PERSON)
    assert np.abs(performance.rates_deg_s).max() == 0.0
    assert np.abs(performance.gyros_deg_s()).max() == 0.0


@pytest.mark.parametrize("step", [SWING, SWEEP, TURN, rest(), zero(1)], ids=lambda step: step.key)
@pytest.mark.parametrize("pace", [0.8, 1.5])
def test_a_motion_takes_as_long_as_the_operator_says(step: Step, pace: float) -> None:
    with EmulatedRobot(imperfections=ideal()) as robot:
        robot.advance(SETTLE_US)
        operator = EmulatedOperator(robot, replace(PERSON, pace=pace))
        operator.begin(step)
        duration_s = operator.duration_s(step)
        if not step.moved:
            assert not robot.swinging
            return
        robot.advance(round(duration_s * 1e6) - 20_000)
        assert robot.swinging
        robot.advance(40_000)
        assert not robot.swinging


def test_the_operators_figures_at_nominal_pace() -> None:
    with EmulatedRobot(imperfections=ideal()) as robot:
        operator = EmulatedOperator(robot)
        steps = (rest(), zero(None), SWING, SWEEP, TURN)
        assert [operator.duration_s(step) for step in steps] == pytest.approx([20.0, 5.0, 12.0, 32.0, 33.2])
        turns_s = [operator.duration_s(turn("z", angle_deg)) for angle_deg in (90.0, 180.0, -720.0)]
        assert turns_s == pytest.approx([21.2, 21.2, 57.2])


def test_a_seed_repeats_everything_and_another_changes_it() -> None:
    first, again, other = (perform(SWEEP, Operator.human(seed)) for seed in (1, 1, 2))
    assert np.array_equal(first.joints_deg, again.joints_deg)
    assert np.array_equal(first.rates_deg_s, again.rates_deg_s)
    assert np.array_equal(first.counts.imu_counts, again.counts.imu_counts)
    n = min(len(first.t_s), len(other.t_s))
    assert not np.array_equal(first.joints_deg[:n], other.joints_deg[:n])


def test_the_same_step_a_second_time_is_another_motion() -> None:
    ends = []
    with EmulatedRobot(imperfections=ideal()) as robot:
        operator = EmulatedOperator(robot, PERSON)
        for _ in range(2):
            operator.begin(SWEEP)
            robot.advance(3_300_000)
            ends.append(robot.joint_angles_deg()[0])
            robot.advance(40_000_000)
    assert ends[0] != ends[1]


def test_zero_closes_the_joints_that_are_meant() -> None:
    with EmulatedRobot(imperfections=ideal()) as robot:
        operator = EmulatedOperator(robot)
        robot.hold((4,))
        for joint in (1, 2, 3):
            robot.swing(joint, 40.0, 2.0, 1)
        robot.advance(1_000_000)
        operator.begin(zero(2))
        robot.advance(10_000)
        assert robot.joint_angles_deg() == pytest.approx((40.0, 0.0, 40.0), abs=0.1)
        operator.begin(zero(None))
        robot.advance(10_000)
        assert robot.joint_angles_deg() == (0.0, 0.0, 0.0)


def test_hands_hold_against_a_servo_until_they_let_go() -> None:
    with EmulatedRobot(imperfections=ideal()) as robot:
        robot.advance(SETTLE_US)
        operator = EmulatedOperator(robot, replace(PERSON, reaction=0.0))
        operator.begin(servo(1))
        robot.record_truth(2_000)
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        sequencer.run(Jog(1, 0, 3000), 10.0, lambda: False, lambda _: None)
        rates = np.rad2deg(robot.truth()[:, 23:26])  # of body 2, which is held
        lead = round(0.9 * LEAD_S / 0.002)
        assert np.abs(rates[:lead]).max() == 0.0
        assert 0.5 < np.sqrt(np.mean(rates[2 * lead :] ** 2)) < 2.0
        operator.begin(rest())
        robot.record_truth(2_000)
        robot.advance(500_000)
        assert np.abs(robot.truth()[:, 20:32]).max() == 0.0


def test_a_joint_that_its_servo_holds_is_not_moved_by_hand() -> None:
    with EmulatedRobot(imperfections=ideal()) as robot:
        robot.advance(SETTLE_US)
        operator = EmulatedOperator(robot)
        refused: list[str] = []

        def try_by_hand(angle_cdeg: int) -> None:
            for step in (zero(1), SWEEP, TURN) if angle_cdeg > 0 else ():
                with pytest.raises(EmulationError) as error:
                    operator.begin(step)
                refused.append(error.value.what)

        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        sequencer.run(Jog(1, 0, 200), 0.0, lambda: False, try_by_hand)
        assert refused and set(refused) == {"Joint 1 cannot be put at 0 deg by hand."}


def test_human_hands_differ_and_stay_human() -> None:
    people = [Operator.human(seed) for seed in range(50)]
    assert Operator.human(3) == people[3]
    assert Operator.steady() == Operator()
    for person in people:
        assert 1.0 <= person.tremor_deg_s <= 5.0 and 0.2 <= person.sway_deg_s <= 1.0
        assert 0.0 <= person.reaction <= 0.01 and 0.8 <= person.pace <= 1.5
        assert person.placing_deg == 0.1
        # As calibration assumes of each of two directions.
        assert person.tilt_deg == pytest.approx(2**0.5 * np.rad2deg(TILT_STD_RAD), rel=0.02)
    assert len({person.tremor_deg_s for person in people}) == 50
