"""In which order joints may move in a closed loop."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tfsat_host.plan.loops import backwards, classes, sequences, written


@pytest.mark.parametrize(("joints", "count"), [(1, 0), (2, 2), (3, 30), (4, 864)])
def test_how_many_sequences_there_are(joints: int, count: int) -> None:
    """The paper's figure shows 30 for three joints."""
    assert len(sequences(joints)) == count
    assert len(set(sequences(joints))) == count
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
        assert backwards(sequence) != sequence
        assert backwards(backwards(sequence)) == sequence


def test_a_class_holds_a_sequence_and_the_one_that_undoes_it() -> None:
    both = {*classes(3), *(backwards(s) for s in classes(3))}
    assert both == set(sequences(3))


def test_a_sequence_is_written_as_people_read_it() -> None:
    assert written((3, 2, 1, -2, -3, -1)) == "+3 +2 +1 -2 -3 -1"  # the paper's example
    assert (3, 2, 1, -2, -3, -1) in sequences(3)
