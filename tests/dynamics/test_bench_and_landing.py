"""The chain held by hand, and at the end of the fall."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot, Script

G = 9.80665
RATE = np.array([0.9, 0.0, 0.0])


def move_joint_1(script: Script, rate: float = 0.9) -> None:
    """Joint 1 opens at constant rate for 0.1 s."""
    for k in range(1, 11):
        script.step(0.01, [0.01 * k * rate, 0.0, 0.0], [rate, 0.0, 0.0], np.zeros(3))


def test_at_rest_every_accelerometer_reads_one_g_upwards(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    turned = Rotation.from_euler("xyz", [30, -20, 10], degrees=True)
    script.show(2)
    script.say("place", turned.as_quat(), [0, 0, 1])
    script.show(2)
    level, tilted = script.run(probe)
    assert level.specific_force == pytest.approx([0, 0, G])
    assert level.position == pytest.approx([0, 0, 0])
    # One g in the direction that is up for the body.
    assert tilted.specific_force == pytest.approx(turned.inv().apply([0, 0, G]))


@pytest.mark.parametrize(
    ("held_bodies", "moving_sign"), [((1, 2, 3), {0: 1.0}), ((0,), {1: -1.0, 2: -1.0, 3: -1.0})]
)
def test_held_bodies_stand_and_the_others_turn_about_the_joint(
    probe: Path, drop_tower: Robot, held_bodies: tuple[int, ...], moving_sign: dict[int, float]
) -> None:
    script = Script(drop_tower)
    script.hold(*held_bodies)
    move_joint_1(script)
    for body in range(4):
        script.show(body)
    for body, state in enumerate(script.run(probe)):
        sign = moving_sign.get(body, 0.0)
        # Bodies that are held do not turn, the others turn about the joint.
        assert state.rate == pytest.approx(sign * RATE, abs=1e-12)
        turned = np.degrees(Rotation.from_quat(state.quaternion).as_rotvec())
        assert turned == pytest.approx([sign * np.degrees(0.09), 0, 0], abs=1e-9)


def test_a_joint_between_two_held_bodies_is_locked(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    script.hold(0, 2)  # joints 1 and 2 lie between bodies 1 and 3, joint 3 does not
    angles = np.array([0.1, 0.2, 0.3])
    script.step(0.1, angles, 10 * angles, np.zeros(3))
    for body in range(4):
        script.show(body)
    states = script.run(probe)
    # Joints between two held bodies are locked; their rates are zero.
    assert states[0].angles == pytest.approx([0, 0, 0.3], abs=0)
    for body in range(3):
        assert np.abs(states[body].rate).max() == 0.0
    assert states[3].rate == pytest.approx([-3.0, 0, 0])


def test_centripetal_and_tangential_acceleration_are_felt_on_the_bench(
    probe: Path, drop_tower: Robot
) -> None:
    script = Script(drop_tower)
    script.hold(2)
    script.step(1e-3, np.zeros(3), [2.0, 0, 0], [7.0, 0, 0])
    arm = np.array([0.0, 0.04, 0.12])  # from the axis of joint 1
    at = drop_tower.point[0] + arm - drop_tower.origin[0]
    script.show(0, at)
    (state,) = script.run(probe)
    # Tangential and centripetal acceleration, and gravity.
    expected = np.cross([7, 0, 0], arm) + np.cross([2, 0, 0], np.cross([2, 0, 0], arm)) + [0, 0, G]
    assert state.specific_force == pytest.approx(expected)


def test_a_held_body_feels_only_gravity_while_the_others_move(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    script.hold(0)  # not the base, which is shaken by joints 1 and 2
    script.step(1e-3, [0.5, 0.6, 0.0], [2.0, -1.0, 0.0], [7.0, 9.0, 0.0])
    script.show(0, (0.05, 0.05, 0.05))
    (state,) = script.run(probe)
    assert state.specific_force == pytest.approx([0, 0, G], abs=1e-12)
    # What is held does not move, whatever the others do.
    assert np.abs(state.velocity).max() < 1e-12
    assert np.abs(state.angular_acceleration).max() < 1e-12


def test_holding_a_turning_robot_stops_it_where_it_is(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    script.release((0.2, -0.3, 0.4))
    script.step(0.5, np.zeros(3), np.zeros(3), np.zeros(3))
    script.show(1)
    script.hold(1)
    script.show(1)
    flying, held_state = script.run(probe)
    # Stopped in place: attitude and position stay.
    assert held_state.quaternion == pytest.approx(flying.quaternion)
    assert held_state.position == pytest.approx(flying.position)
    assert np.abs(held_state.rate).max() == 0.0


def test_landing_is_a_pulse_and_then_rest(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    script.release((0.0, 0.0, 0.5))
    script.step(0.5, np.zeros(3), np.zeros(3), np.zeros(3))
    script.show(2, drop_tower.com[2])
    script.say("land", 300.0, 0.04)
    for _ in range(5):
        script.show(2, drop_tower.com[2])
        script.step(0.01, np.zeros(3), np.zeros(3), np.zeros(3))
    script.show(2, drop_tower.com[2])
    falling, *landing = script.run(probe)
    up = np.array([state.specific_force[2] for state in landing])
    assert abs(up[0] - falling.specific_force[2]) < 0.1
    # 300 m/s² of shock and half of gravity, at the middle of the pulse.
    assert up[2] == pytest.approx(300.0 + 0.5 * G, abs=0.05)
    rest = [float(np.linalg.norm(state.specific_force)) for state in landing[4:]]
    assert rest == pytest.approx([G, G], abs=1e-9)
    turning = [float(np.linalg.norm(state.rate)) for state in landing]
    # The rotation only ever slows down in the pulse.
    assert turning == sorted(turning, reverse=True)
    assert turning[0] == pytest.approx(float(np.linalg.norm(falling.rate)))
    assert turning[-1] < 1e-12
