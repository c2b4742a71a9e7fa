"""A Monte Carlo study, cut into chunks that can be computed anywhere and in any order.

Chunk i draws from the i-th child of the seed, and its size is fixed: a sample has the same numbers whatever
the number of workers, and the first samples of a longer study are those of a shorter one. A source draws its deviates
even if its standard deviation is 0: without one kind of error, all others stay as they were.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.sensitivity.flight import final_attitude
from tfsat_host.sensitivity.parameters import Parameters
from tfsat_host.sensitivity.sources import ErrorSources

CHUNK = 500
"""Samples a chunk: small enough for a processor's cache, large enough for numpy."""
LARGEST_DEVIATE = 4.5
"""Deviates beyond it, seven of a million, are drawn to it: a share of up to 20 % leaves something of every mass."""


@dataclass(frozen=True, eq=False)
class Study:
    """What is drawn, how often, and from which seed.

    Attributes:
        parameters: Of the robot and its plan.
        sources: What may be wrong with them.
        samples: How many, at least one.
        seed: From 0.
    """

    parameters: Parameters
    sources: ErrorSources
    samples: int
    seed: int

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.samples // CHUNK)

    def deviates(self, chunk: int) -> FloatArray:
        """(s, d) standard normal deviates of a chunk; s is less than `CHUNK` in the last one only."""
        seeds = np.random.SeedSequence(self.seed, spawn_key=(chunk,))
        drawn = np.random.Generator(np.random.PCG64(seeds)).standard_normal((CHUNK, len(self.sources.names)))
        left = self.samples - chunk * CHUNK
        return np.clip(drawn[:left], -LARGEST_DEVIATE, LARGEST_DEVIATE)

    def vectors(self, deviates: FloatArray) -> FloatArray:
        """(s, p) parameters of the samples."""
        return np.asarray(self.parameters.nominal + self.sources.shifts(deviates))


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What s samples did.

    Attributes:
        quaternion_xyzw: (s, 4) final attitude of the base: from base axes to inertial axes.
        moving_time_s: (s,) what the strokes take together.
        end_s: (s,) when the last joint has arrived, after release.
    """

    quaternion_xyzw: FloatArray
    moving_time_s: FloatArray
    end_s: FloatArray

    def __len__(self) -> int:
        return len(self.end_s)

    @classmethod
    def joined(cls, parts: list[Outcomes]) -> Outcomes:
        """The outcomes of chunks, in their order."""
        return cls(
            np.concatenate([part.quaternion_xyzw for part in parts]),
            np.concatenate([part.moving_time_s for part in parts]),
            np.concatenate([part.end_s for part in parts]),
        )

    @property
    def rotation_vector_deg(self) -> FloatArray:
        """(s, 3)."""
        return np.degrees(quaternion.logarithm(self.quaternion_xyzw.T)).T

    @property
    def reorientation_deg(self) -> FloatArray:
        """(s,) rotation angles."""
        return np.degrees(quaternion.angle(self.quaternion_xyzw.T))

    def attitude_error_deg(self, nominal_xyzw: FloatArray) -> FloatArray:
        """(s,) angles between the final attitudes and the nominal one (4,)."""
        back = quaternion.inverse(nominal_xyzw)[:, None]
        return np.degrees(quaternion.angle(quaternion.product(back, self.quaternion_xyzw.T)))


def run_chunk(study: Study, chunk: int) -> Outcomes:
    """The outcomes of one chunk; the same wherever it runs."""
    vectors = study.vectors(study.deviates(chunk))
    moves = study.parameters.moves(vectors)
    attitude = final_attitude(study.parameters.robots(vectors), moves, study.parameters.initial_rate_rad_s)
    return Outcomes(np.ascontiguousarray(attitude.T), moves.moving_time_s, moves.last_end_s)
