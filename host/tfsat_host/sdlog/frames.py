"""How bodies stood over time, for the formats that can show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrameTrack:
    """One frame in another, at m moments.

    Attributes:
        parent: Name of the frame that it is given in.
        child: Its own name.
        t_us: (m,) int64, the logger's clock, increasing.
        translation_m: (m, 3) the child's origin in the parent.
        quaternion_xyzw: (m, 4) unit quaternions that turn the child's axes into the parent's.
    """

    parent: str
    child: str
    t_us: NDArray[np.int64]
    translation_m: FloatArray
    quaternion_xyzw: FloatArray


@dataclass(frozen=True, eq=False)
class JointTrack:
    """One joint's angle: `t_us` (m,) int64, the logger's clock; `angle_rad` (m,)."""

    name: str
    t_us: NDArray[np.int64]
    angle_rad: FloatArray


@dataclass(frozen=True, eq=False)
class BodyFrames:
    """A tree of frames.

    Attributes:
        tracks: One a body, parents before children; none where a body's place is unknown.
        joints: One a joint that could be read.
        notes: Sentences: what this rests on, what is missing and why.
    """

    tracks: tuple[FrameTrack, ...]
    joints: tuple[JointTrack, ...]
    notes: tuple[str, ...]
