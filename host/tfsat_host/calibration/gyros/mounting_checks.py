"""Whether the directions that a gyro saw fit a sensor that is mounted as the robot file says."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.gyros.mounting import described, spans_two_axes, wahba
from tfsat_host.calibration.gyros.response import Response
from tfsat_host.calibration.steps.patterns import MotionPattern
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

MOST_OFF_RAD = np.deg2rad(15.0)
"""Three standard deviations of a mounting by hand: beyond it, another one was meant."""
MOST_SKEW_RAD = np.deg2rad(2.0)
"""Between two axes: scale factors make 0.2 deg of it, brackets 0.5."""
_PARALLEL = 0.99
MOST_APART_RAD = np.deg2rad(0.5)
"""Between two measurements of the same axis."""
_OR_DIRECTION = (
    " If it sits as designed, the joint's angle sensors count the other way: correct their direction."
)


def check_mounting(body: int, responses: Sequence[Response], model: RobotModel) -> None:
    """Refuses what no mounting, or another one than the robot file's, explains.

    Raises:
        CalibrationError: axes are exchanged or turned, or two directions contradict each other.
    """
    if not responses:
        return
    nominal = model.imus[body - 1].sensor_to_body
    if spans_two_axes(responses):
        rotation = wahba(responses)
        off = float(Rotation.from_matrix(nominal.T @ rotation).magnitude())
        if off > MOST_OFF_RAD:
            raise _otherwise(body, rotation, nominal)
    else:
        _check_direction(body, responses[0], nominal)
    _check_angles_between(body, responses)


def check_sense(pattern: MotionPattern, responses: Sequence[Response], model: RobotModel) -> None:
    """Refuses a motion that all moved gyros saw the other way round than the angle sensors.

    Args:
        pattern: What was moved.
        responses: Of its moved bodies, in order.
        model: For how the sensors are mounted by design.

    Raises:
        CalibrationError: the joint's angle sensors count the other way than the robot file says.
    """
    if len(responses) < 2:  # one gyro alone may as well be mounted the other way round
        return
    nominals = [model.imus[body - 1].sensor_to_body.T for body in pattern.moved]
    if all(
        angle_between(one.reading, turn @ one.axis_body) > np.pi - MOST_OFF_RAD
        for one, turn in zip(responses, nominals, strict=True)
    ):
        raise CalibrationError(
            what=f"All gyros say that joint {pattern.joint} closed when its angle sensors say that it opened: both "
            f"sensors of joint {pattern.joint} count the other way than the robot file says.",
            meaning="Every stroke of this joint would be evaluated the wrong way round.",
            next_step=f"Change the sign of direction of both [[angle_sensor]] of joint {pattern.joint} in the robot "
            "file, give that with --robot, and run this command again.",
        )


def mounted_otherwise(
    body: int, axis_body: FloatArray, seen: FloatArray, expected: FloatArray
) -> CalibrationError:
    """That a sensor shows a rotation about a body axis (3,) along `seen` (3,), not as `expected` (3,)."""
    main, due = (int(np.argmax(np.abs(vector))) for vector in (seen, expected))
    sign = "-" if seen[main] < 0 else ""
    about = AXES[int(np.argmax(np.abs(axis_body)))]
    off = angle_between(seen, expected)
    exchanged = " and ".join(AXES[index] for index in sorted((main, due)))
    how = (
        "the other way round" if main == due else f"with {exchanged} exchanged, as far as one rotation tells"
    )
    return CalibrationError(
        what=f"The sensor on body {body} looks mounted {how}: it shows a rotation about the body's {about} axis on "
        f"its {sign}{AXES[main]} axis, {np.rad2deg(off):.0f} deg from where its design has it.",
        meaning="By the robot file every rate of this body would be taken for another axis's.",
        next_step="Turn the sensor, or correct its sensor_to_body in the robot file and give that with --robot; "
        "then run this command again." + (_OR_DIRECTION if off > np.pi - MOST_OFF_RAD else ""),
    )


def _otherwise(body: int, rotation: FloatArray, nominal: FloatArray) -> CalibrationError:
    words = described(rotation, nominal)
    off = float(np.rad2deg(Rotation.from_matrix(nominal.T @ rotation).magnitude()))
    rows = np.rint(rotation).astype(int)
    upright = bool(words) and np.array_equal(rows @ rows.T, np.eye(3))
    cure = f"sensor_to_body = {rows.tolist()}" if upright else "its sensor_to_body"
    return CalibrationError(
        what=f"The sensor on body {body} {words or f'is {off:.0f} deg off its design'}.",
        meaning="By the robot file every rate of this body would be taken for another axis's.",
        next_step=f"Turn the sensor, or write {cure} to its [[imu]] in the robot file and give that with "
        f"--robot; then run this command again."
        + (_OR_DIRECTION if np.diag(np.rint(nominal.T @ rotation)).all() else ""),
    )


def _check_direction(body: int, response: Response, nominal: FloatArray) -> None:
    expected = nominal.T @ response.axis_body
    if angle_between(response.reading, expected) > MOST_OFF_RAD:
        raise mounted_otherwise(body, response.axis_body, response.reading, expected)


def _check_angles_between(body: int, responses: Sequence[Response]) -> None:
    for i, first in enumerate(responses):
        for second in responses[:i]:
            skew = abs(
                angle_between(first.reading, second.reading)
                - angle_between(first.axis_body, second.axis_body)
            )
            doubt = 3.0 * np.sqrt(
                sum(float(np.trace(r.covariance) / (r.reading @ r.reading)) for r in (first, second))
            )
            parallel = abs(first.axis_body @ second.axis_body) > _PARALLEL
            if skew > (MOST_APART_RAD if parallel else MOST_SKEW_RAD) + doubt:
                raise CalibrationError(
                    what=f"The gyro on body {body} saw two axes "
                    f"{np.rad2deg(angle_between(first.reading, second.reading)):.1f} deg "
                    f"apart that are {np.rad2deg(angle_between(first.axis_body, second.axis_body)):.1f} deg "
                    f"apart on the robot.",
                    meaning="One of the motions was not about its joint alone, or the sensor moved in between.",
                    next_step="Close the joints that are not moved, and run this command again. If the sensor was "
                    f"moved since the first of the two: fasten it, then {_commands(body)}.",
                )


def _commands(body: int) -> str:
    first, second = (2, 3) if body == 4 else (1, 2)
    return f"tfsat-host calibrate misalignment --joint {first} --anew, then --joint {second} without --anew"


def angle_between(first: FloatArray, second: FloatArray) -> float:
    """Between two vectors (3,), 0 to pi."""
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))
