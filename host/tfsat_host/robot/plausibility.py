"""Whether the entries of a robot file are of one robot: connected bodies, and masses, lengths and units that fit.

Each entry is sound by itself when these checks begin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.config import Table
from tfsat_host.robot.model import RobotModel

# The radius of gyration of a body over its reach, from its center of mass to its joints and corners, and over the size
# of the robot. One that is off by a factor of 1000 in its inertia or mass is off by 32 in that radius.
_MIN_GYRATION, _MAX_GYRATION = 0.03, 3.0
# Shapes are drawn roughly and inertias rounded: a mass that is spread by more than twice what its boxes can hold, by
# more than this share of its greatest moment, is another one's.
_MAX_SPREAD_RATIO, _ROUNDING_SHARE = 2.0, 0.05
# Centers of mass in m instead of mm, next to the greatest length of the robot.
_METERS_OVER_SIZE = (1e-5, 1e-3)
_MAX_IMU_DISTANCE = 2.0  # sizes of the robot


def check_sizes(bodies: Sequence[Table], robot: RobotModel) -> None:
    """Check that inertia, mass and lengths are of one robot, in the units that the file's keys name.

    Raises:
        RobotFileError: a body's mass is spread by far less or more than its joints and boxes lie apart, or by more than
            its boxes allow about its center of mass, or all centers of mass look like meters.
    """
    com_m = robot.origin_m + robot.com_m
    marks = np.concatenate([com_m, robot.joint_point_m, robot.origin_m])
    if not robot.n_joints:
        return  # nothing to compare with
    # The diagonal around all joints and centers of mass is the scale to judge units by.
    size_m = float(np.linalg.norm(marks.max(axis=0) - marks.min(axis=0)))
    offsets_m = float(np.abs(robot.com_m).max())
    if _METERS_OVER_SIZE[0] * size_m < offsets_m < _METERS_OVER_SIZE[1] * size_m:
        bodies[0].fail(
            "com_mm",
            f"no center of mass is farther than {1e3 * offsets_m:.2g} mm from the origin of its frame, in a robot of "
            f"{1e3 * size_m:.3g} mm",
            "Give com_mm in mm, not m; write 0 where an origin is the center of mass.",
        )
    for b, (entry, corners) in enumerate(zip(bodies, robot.shape_m, strict=True)):
        at_joints = robot.joint_point_m[(robot.joint_inner == b) | (robot.joint_outer == b)]
        # A body reaches from its center of mass to its joints and corners.
        ends = np.concatenate([at_joints - com_m[b], corners - robot.com_m[b]])
        reach_m = float(np.linalg.norm(ends, axis=1).max(initial=0.0))
        inertia = robot.inertia_kg_m2[b]
        # The radius of gyration is a length made of inertia and mass: a wrong unit of either shows.
        gyration_m = math.sqrt(np.linalg.eigvalsh(inertia)[-1] / robot.mass_kg[b])
        if gyration_m < _MIN_GYRATION * reach_m or 0.0 < _MAX_GYRATION * max(size_m, reach_m) < gyration_m:
            entry.fail(
                "inertia_g_m2",
                f"with its mass the radius of gyration is {1e3 * gyration_m:.3g} mm, and its joints and corners reach "
                f"{1e3 * reach_m:.3g} mm from the center of mass",
                "Check the units: mass in kg, inertia in g m^2 (1 kg m^2 is 1000 g m^2), lengths in mm.",
            )
        if len(corners):
            _check_spread(entry, robot.com_m[b], corners, np.diag(inertia), float(robot.mass_kg[b]))


def check_imu_places(entries: Sequence[Table], robot: RobotModel) -> None:
    """Check that each IMU is on its robot.

    Raises:
        RobotFileError: one lies farther from its body's center of mass than twice the robot's length.
    """
    corners_m = [shape + origin for shape, origin in zip(robot.shape_m, robot.origin_m, strict=True)]
    marks = np.concatenate([robot.origin_m + robot.com_m, robot.joint_point_m, *corners_m])
    size_m = float(np.linalg.norm(marks.max(axis=0) - marks.min(axis=0)))
    for entry, imu in zip(entries, robot.imus, strict=True):
        away_m = float(np.linalg.norm(imu.position_m - robot.com_m[imu.body]))
        if away_m > _MAX_IMU_DISTANCE * size_m > 0.0:
            entry.fail(
                "position_mm",
                f"is {1e3 * away_m:.3g} mm from the center of mass of its body, of a robot of {1e3 * size_m:.3g} mm",
                "Give it in mm, in the body's frame.",
            )


def _check_spread(
    entry: Table, com_m: FloatArray, corners: FloatArray, moments: FloatArray, mass_kg: float
) -> None:
    """Refuse an inertia that spreads the mass wider than the body's boxes allow.

    A mass between two walls with its mean at a < x < b has a variance of at most (x - a)(b - x).
    R. Bhatia, C. Davis, A Better Bound on the Variance, American Mathematical Monthly 107, 2000.
    """
    # Along each axis the second moment is half the trace less the moment about it.
    variance = (moments.sum() / 2.0 - moments) / mass_kg
    room = (com_m - corners.min(axis=0)) * (corners.max(axis=0) - com_m)
    wide = np.flatnonzero(
        mass_kg * (variance - _MAX_SPREAD_RATIO**2 * room) > _ROUNDING_SHARE * moments.max()
    )
    if len(wide):
        k = int(wide[0])
        entry.fail(
            "com_mm",
            f"the inertia spreads the mass by {1e3 * math.sqrt(variance[k]):.3g} mm along {'xyz'[k]}, and about this "
            f"center of mass the boxes have room for {1e3 * math.sqrt(max(room[k], 0.0)):.3g} mm",
            "Check units and frame of com_mm, boxes_mm and inertia_g_m2: lengths in mm in the body's frame, inertia in "
            "g m^2 about the center of mass.",
        )


def check_tree(
    bodies: Sequence[Table],
    joints: Sequence[Table],
    inner: IntArray,
    outer: IntArray,
    body_names: tuple[str, ...],
) -> None:
    """Check that joints from `inner` to `outer` (n - 1,) connect all bodies without a loop.

    Raises:
        RobotFileError: a joint closes a loop or joins a body to itself, or a body is not connected.
    """
    # Merge groups joint by joint: a joint within a group closes a loop, two groups left are apart.
    group = list(range(len(body_names)))
    for joint, a, b in zip(joints, inner, outer, strict=True):
        if a == b:
            joint.fail("outer", "the joint joins a body to itself", "Name two different bodies.")
        if group[a] == group[b]:
            joint.fail(
                "outer",
                f"the joint closes a loop: {body_names[a]!r} and {body_names[b]!r} are already connected",
                "Remove one joint of the loop; only open chains and trees can be computed.",
            )
        group = [group[a] if g == group[b] else g for g in group]
    for body, g in enumerate(group):
        if g != group[0]:
            bodies[body].fail(
                "name",
                f"no joint connects {body_names[body]!r} with {body_names[0]!r}",
                "Add the missing `[[joint]]`, or remove the body.",
            )
