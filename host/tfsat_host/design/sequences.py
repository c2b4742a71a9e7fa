"""In which order the joints of a closed loop may move: every joint out once and back once.

A closing stroke is never flown at once after its own opening stroke, because that induces nothing (paper, section
"Design of optimal reorientation maneuver"). Three joints have 30 such sequences. Flown backwards, a
sequence gives the inverse rotation, so 15 rotation angles are all there are.
"""

from __future__ import annotations

from functools import cache

Sequence = tuple[int, ...]
"""Signed joint numbers from 1, in the order they move: +1 opens joint 1, -1 closes it."""


@cache
def sequences(n_joints: int) -> tuple[Sequence, ...]:
    """All closed sequences of joints 1 to `n_joints`, in lexical order of opening first."""
    found: list[Sequence] = []

    def extend(done: Sequence) -> None:
        if len(done) == 2 * n_joints:
            found.append(done)
            return
        for joint in range(1, n_joints + 1):
            if joint not in done:
                extend((*done, joint))
            elif -joint not in done and done[-1] != joint:
                extend((*done, -joint))

    extend(())
    return tuple(found)


def backwards(sequence: Sequence) -> Sequence:
    """The sequence that undoes this one."""
    return tuple(-stroke for stroke in reversed(sequence))


@cache
def classes(n_joints: int) -> tuple[Sequence, ...]:
    """One sequence of each pair that undo one another: the one that comes first."""
    return tuple(s for s in sequences(n_joints) if s <= backwards(s))


def written(sequence: Sequence) -> str:
    """The sequence as people read it: "+1 +2 -1 -2"."""
    return " ".join(f"{stroke:+d}" for stroke in sequence)
