"""Whether gyros are mounted as the robot file says: what no mounting explains, or another one, is refused."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.misalignment import spans_two_axes, wahba
from tfsat_host.calibration.response import Response, direction, turn_axis
from tfsat_host.calibration.sensors.gyro import SKEW_STD, GyroCalibration
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import AXES, Step
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import ASSUMED, RobotModel

MAX_MISALIGNMENT_RAD = np.deg2rad(15.0)
"""Three standard deviations of a mounting by hand: beyond it, another one was meant."""
MAX_TURN_MISALIGNMENT_RAD = np.deg2rad(20.0)
"""A sensor that is mounted by hand, on a robot that is laid by hand."""
BENT_RAD = np.deg2rad(0.7)
"""Between two axes: scale factors make 0.2 deg of it, brackets 0.5."""
ASKEW_STDS = 3.0
"""Besides, of what two hinges may be tilted and a chip's axes may be askew: with chips that are anywhere within their
data sheet one pair in 20,000 is further apart."""
MAX_DIFFERENCE_RAD = np.deg2rad(0.5)
"""Between two measurements of the same axis."""
# Cosine: within 8 deg, two responses are measurements of one axis.
_PARALLEL = 0.99
_WRONG_AXES = "By the robot file every rate of this body would be taken for another axis's."
_OR_DIRECTION = (
    " If it sits as designed, the joint's angle sensors count the other way: correct their direction."
)


def check_misalignment(body: int, responses: Sequence[Response], model: RobotModel) -> None:
    """Refuses what no mounting, or another one than the robot file's, explains.

    Raises:
        CalibrationError: axes are exchanged or turned, or two directions contradict each other.
    """
    if not responses:
        return
    nominal = model.imus[body - 1].sensor_to_body
    if spans_two_axes(responses):
        _check_rotation(body, wahba(responses), nominal)
    else:
        # One axis leaves the turn about it open: compare its direction alone.
        first, expected = responses[0], nominal.T @ responses[0].axis_body
        if angle_between(first.reading, expected) > MAX_MISALIGNMENT_RAD:
            raise _mounted_otherwise(body, first.axis_body, first.reading, expected)
    _check_angles_between(body, responses, model)


def check_sense(step: Step, responses: Sequence[Response], model: RobotModel) -> None:
    """Refuses a motion that all moved gyros measured the other way round than the angle sensors.

    Args:
        step: What was moved.
        responses: Of its moved bodies, in order.
        model: For how the sensors are mounted by design.

    Raises:
        CalibrationError: the joint's angle sensors count the other way than the robot file says.
    """
    if len(responses) < 2:  # one gyro alone may as well be mounted the other way round
        return
    off = [
        angle_between(response.reading, model.imus[body - 1].sensor_to_body.T @ response.axis_body)
        for body, response in zip(step.moved, responses, strict=True)
    ]
    # All gyros reversed at once: what they have in common is the sense of the angle sensors.
    if min(off) > np.pi - MAX_MISALIGNMENT_RAD:
        raise CalibrationError(
            what=f"All gyros say that joint {step.joint} closed when its angle sensors say that it opened: both "
            f"sensors of joint {step.joint} count the other way than the robot file says.",
            meaning="Every stroke of this joint would be evaluated the wrong way round.",
            next_step=f"Change the sign of direction of both [[angle_sensor]] of joint {step.joint} in the robot "
            "file, give that with --robot, and run this command again.",
        )


def check_turn_axis(recording: SensorSamples, step: Step, gyros: Sequence[GyroCalibration]) -> None:
    """Refuses a turn about another axis, and a gyro that alone shows one.

    Raises:
        CalibrationError: the robot was laid wrongly, or a sensor is mounted otherwise than the robot file says.
    """
    axis = turn_axis(step)
    readings = [recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s for gyro in gyros]
    expected = [gyro.readings(axis) for gyro in gyros]
    # The median over the gyros gives the turn's sense even if one of them is mounted otherwise.
    together = np.median([rates @ due for rates, due in zip(readings, expected, strict=True)], axis=0)
    directions = [direction(rates, axis, together).reading for rates in readings]
    off = [angle_between(measured_axis, due) for measured_axis, due in zip(directions, expected, strict=True)]
    wrong = [index for index, angle in enumerate(off) if angle > MAX_TURN_MISALIGNMENT_RAD]
    # Most gyros off: the robot was laid wrongly. A minority off: their mounting is wrong.
    if len(wrong) > len(gyros) // 2:
        raise CalibrationError(
            what=f"The robot was turned about another axis, {np.rad2deg(np.median(off)):.0f} deg from {step.axis}.",
            meaning="The scale factor of another axis would have been taken for this one's.",
            next_step=f"Close all joints, lay the robot so that its {step.axis} axis is upright, and run "
            f"this command again.",
        )
    if wrong:
        raise _mounted_otherwise(gyros[wrong[0]].body, axis, directions[wrong[0]], expected[wrong[0]])


def _mounted_otherwise(
    body: int, axis_body: FloatArray, reading: FloatArray, expected: FloatArray
) -> CalibrationError:
    """Build the error for a sensor that shows a rotation along `reading`, not as `expected`.

    All are (3,); the rotation is about the body axis `axis_body`.
    """
    # Name the axes by their largest components: where it shows, where it should, what it is about.
    main, due, about = (int(np.argmax(np.abs(vector))) for vector in (reading, expected, axis_body))
    off = angle_between(reading, expected)
    exchanged = " and ".join(AXES[index] for index in sorted((main, due)))
    how = (
        "the other way round" if main == due else f"with {exchanged} exchanged, as far as one rotation tells"
    )
    return CalibrationError(
        what=f"The sensor on body {body} looks mounted {how}: it shows a rotation about the body's {AXES[about]} axis "
        f"on its {'-' if reading[main] < 0 else ''}{AXES[main]} axis, {np.rad2deg(off):.0f} deg from where its design "
        "has it.",
        meaning=_WRONG_AXES,
        next_step="Turn the sensor, or correct its sensor_to_body in the robot file and give that with --robot; "
        "then run this command again." + (_OR_DIRECTION if off > np.pi - MAX_MISALIGNMENT_RAD else ""),
    )


def _check_rotation(body: int, rotation: FloatArray, nominal: FloatArray) -> None:
    off = float(Rotation.from_matrix(nominal.T @ rotation).magnitude())
    if off <= MAX_MISALIGNMENT_RAD:
        return
    words = describe_misalignment(rotation, nominal)
    rows = np.rint(rotation).astype(int)
    # A matrix can be proposed only where the measured mounting rounds to right angles.
    upright = bool(words) and np.array_equal(rows @ rows.T, np.eye(3))
    cure = f"sensor_to_body = {rows.tolist()}" if upright else "its sensor_to_body"
    raise CalibrationError(
        what=f"The sensor on body {body} {words or f'is {np.rad2deg(off):.0f} deg off its design'}.",
        meaning=_WRONG_AXES,
        next_step=f"Turn the sensor, or write {cure} to its [[imu]] in the robot file and give that with "
        f"--robot; then run this command again."
        + (_OR_DIRECTION if np.diag(np.rint(nominal.T @ rotation)).all() else ""),
    )


def describe_misalignment(rotation: FloatArray, nominal: FloatArray) -> str:
    """Describe a sensor's mounting relative to its design; empty if it is mounted as designed.

    Args:
        rotation: (3, 3) from sensor to body axes, as measured.
        nominal: (3, 3) the same by design.
    """
    between = nominal.T @ rotation  # from true sensor axes to those of the design
    # Nearest of the right-angle rotations: the largest trace of RᵀM is the smallest angle between.
    best = max(_right_angles(), key=lambda turn: float(np.trace(turn.T @ between)))
    rows = np.abs(best).argmax(axis=0)
    lies_along = [
        ("-" if best[row, column] < 0 else "") + AXES[row] for column, row in enumerate(rows.tolist())
    ]
    axes_text = ", ".join(lies_along)
    moved = [AXES[column] for column in range(3) if rows[column] != column]
    if len(moved) == 2:
        return f"looks mounted with {moved[0]} and {moved[1]} exchanged (its x, y, z lie along {axes_text})"
    if np.array_equal(best, np.eye(3)):
        return ""
    return f"looks turned: its x, y, z lie along {axes_text} of where they should"


@cache
def _right_angles() -> tuple[FloatArray, ...]:
    """Return the 24 rotations that map coordinate axes to coordinate axes."""
    return tuple(np.rint(turn) for turn in Rotation.create_group("O").as_matrix())


def _check_angles_between(body: int, responses: Sequence[Response], model: RobotModel) -> None:
    tilt_std_rad = (model.uncertainty or ASSUMED).joint_axis_rad
    # Two hinges are tilted independently, so their angle scatters by sqrt(2) times one's tilt; a skew displaces both.
    most_skew_rad = BENT_RAD + ASKEW_STDS * np.hypot(2.0**0.5 * tilt_std_rad, 2.0 * SKEW_STD)
    for first, second in combinations(responses, 2):
        measured = angle_between(first.reading, second.reading)
        on_robot = angle_between(first.axis_body, second.axis_body)
        # Three standard deviations: trace over squared length is a direction's angular variance.
        doubt = 3.0 * np.sqrt(
            sum(np.trace(response.covariance) / response.length**2 for response in (first, second))
        )
        # Scale factors distort two measurements of one axis alike, so less is allowed between these.
        parallel = abs(first.axis_body @ second.axis_body) > _PARALLEL
        if abs(measured - on_robot) > (MAX_DIFFERENCE_RAD if parallel else most_skew_rad) + doubt:
            joints = (2, 3) if body == 4 else (1, 2)
            raise CalibrationError(
                what=f"The gyro on body {body} measured two axes {np.rad2deg(measured):.1f} deg apart that are "
                f"{np.rad2deg(on_robot):.1f} deg apart on the robot.",
                meaning="One of the motions was not about its joint alone, or the sensor moved in between.",
                next_step=Advice(
                    "Close the joints that are not moved, and run this command again. If the sensor was moved "
                    "since the first of the two: fasten it, then ",
                    NextStep("calibrate misalignment", ("--joint", str(joints[0]), "--anew")),
                    f", then --joint {joints[1]} without --anew.",
                ),
            )


def angle_between(first: FloatArray, second: FloatArray) -> float:
    """Compute the angle between two vectors (3,), 0 to pi."""
    # The arctangent stays accurate near 0 and pi, where an arccosine loses half the digits.
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))
