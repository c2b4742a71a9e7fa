"""In which order joints may move in a closed loop, and all sequences at once against each walked stroke by stroke."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, path_rotation
from tfsat_host.dynamics.stroke import STEPS
from tfsat_host.plan.loops import Loops, backwards, best_sequence, classes, format_sequence, sequences
from tfsat_host.robot import RobotModel

ALPHA_DEG = np.array([[58.75, 40.0, 0.0], [70.29, 90.0, 30.0], [0.0, 55.0, 81.0]])


@pytest.mark.parametrize("start_deg", [(0.0, 0.0, 0.0), (5.0, -10.0, 20.0)])
def test_every_sequence_is_walked_as_its_strokes_say(
    drop_tower: RobotModel, start_deg: tuple[float, ...]
) -> None:
    body, start = Multibody.of(drop_tower), np.radians(start_deg)
    alpha = np.radians(ALPHA_DEG)
    rotations = Loops(body, (0, 1, 2), sequences(3), start_rad=start).rotations(alpha)
    for s, sequence in enumerate(sequences(3)):
        joints = [abs(stroke) - 1 for stroke in sequence]
        deltas = (np.sign(sequence)[:, None] * alpha[joints]).T
        walked = path_rotation(body, joints, deltas, start_rad=np.broadcast_to(start, (3, 3)), steps=STEPS)
        between = Rotation.from_quat(rotations[:, s].T).inv() * Rotation.from_quat(walked)
        # Each sequence walked stroke by stroke, to 1e-10 deg.
        assert np.degrees(between.magnitude()).max() < 1e-10


def test_some_joints_of_a_robot_in_another_order(drop_tower: RobotModel) -> None:
    body = Multibody.of(drop_tower)
    angles = Loops(body, (2, 0), sequences(2)).angles_rad(np.radians([[30.0], [60.0]]))
    walked = path_rotation(body, [2, 0, 2, 0], np.radians([30.0, 60.0, -30.0, -60.0]), steps=STEPS)
    assert sequences(2)[0] == (1, 2, -1, -2)
    assert angles[0, 0] == pytest.approx(2 * np.arccos(abs(walked[3])), abs=1e-9)


def test_the_best_sequence_is_chosen_for_every_candidate() -> None:
    # Column by column: which sequence a candidate flies best.
    best, which = best_sequence(np.array([[1.0, 2.0], [3.0, 0.5]]))
    assert best.tolist() == [3.0, 2.0]
    assert which.tolist() == [1, 0]


def test_the_quadrature_is_right_to_a_fifth_of_a_millidegree(drop_tower: RobotModel) -> None:
    """Compare two steps of order 6 per edge with ten, on displacements up to the ends of the range."""
    alpha = np.random.default_rng(7).uniform(0.0, np.pi / 2, (3, 200))
    body = Multibody.of(drop_tower)
    rough = Loops(body, (0, 1, 2), sequences(3)).rotations(alpha)
    fine = Loops(body, (0, 1, 2), sequences(3), steps=10).rotations(alpha)
    assert np.degrees(2.0 * np.abs(rough - fine).max()) < 2e-4


@pytest.mark.parametrize(("joints", "count"), [(1, 0), (2, 2), (3, 30), (4, 864)])
def test_how_many_sequences_there_are(joints: int, count: int) -> None:
    """Count the sequences: the paper's figure shows 30 for three joints."""
    assert len(sequences(joints)) == count
    assert len(set(sequences(joints))) == count
    # A class is a sequence and the one that undoes it.
    assert 2 * len(classes(joints)) == count


def test_every_joint_opens_once_and_closes_later_but_not_at_once() -> None:
    for sequence in sequences(3):
        assert sorted(sequence) == [-3, -2, -1, 1, 2, 3]
        for joint in (1, 2, 3):
            assert sequence.index(joint) < sequence.index(-joint)
        assert all(after != -before for before, after in pairwise(sequence))


def test_backwards_is_a_sequence_too_and_its_own_inverse() -> None:
    for sequence in sequences(3):
        assert backwards(sequence) in sequences(3)
        # No sequence undoes itself.
        assert backwards(sequence) != sequence
        assert backwards(backwards(sequence)) == sequence


def test_a_class_holds_a_sequence_and_the_one_that_undoes_it() -> None:
    both = {*classes(3), *(backwards(s) for s in classes(3))}
    assert both == set(sequences(3))


def test_a_sequence_is_written_as_people_read_it() -> None:
    assert format_sequence((3, 2, 1, -2, -3, -1)) == "+3 +2 +1 -2 -3 -1"  # the paper's example
    assert (3, 2, 1, -2, -3, -1) in sequences(3)
