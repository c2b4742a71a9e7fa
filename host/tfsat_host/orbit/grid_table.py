"""A distribution as a table for plotting programs."""

from __future__ import annotations

from typing import TextIO

import numpy as np

from tfsat_host.orbit.distribution import Distribution

COLUMNS = (
    "joint_i,joint_j,alpha_deg,beta_deg,"
    "euler_z_deg,euler_y_deg,euler_x_deg,"
    "rotation_x_deg,rotation_y_deg,rotation_z_deg,"
    "reorientation_deg,efficiency"
)
"""The first line of the CSV. Joints are counted from 1."""


def write_csv(found: Distribution, file: TextIO) -> None:
    """Writes one loop a line, below the names of the columns."""
    table = np.column_stack(
        [
            found.joints + 1,
            np.degrees(found.displacement_rad),
            np.degrees(found.euler_zyx_rad),
            np.degrees(found.rotation_vector_rad),
            np.degrees(found.angle_rad),
            found.efficiency,
        ]
    )
    np.savetxt(file, table, fmt="%d,%d,%.6g,%.6g" + ",%.8f" * 8, header=COLUMNS, comments="")
