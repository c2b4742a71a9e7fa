"""Whether the servos reach the speed that a schedule assumes.

No more than a notice: the speed is the user's estimate of the servos, and so is the robot file's.
"""

from __future__ import annotations

from pathlib import Path

from tfsat_host.config import Table, read_config
from tfsat_host.maneuver.schedule import Schedule
from tfsat_host.robot import RobotFileError, default_robot_path
from tfsat_host.robot.path import ROBOT_FILE


def servo_speed_notices(schedule: Schedule, robot_file: Path | None = None) -> tuple[str, ...]:
    """A sentence if the speed is above what the robot file says of the servos of the moved joints.

    Reads no more of the file than the servo rates, so that an upload does not wait for numpy.
    """
    path = default_robot_path() if robot_file is None else robot_file
    moved = sorted({stroke.joint for stroke in schedule.strokes})
    joints: list[Table] = []
    try:
        joints = read_config(path, ROBOT_FILE).tables("joint")
        servos = [joints[joint - 1].table("servo") for joint in moved]
        average = min(servo.number("average_rate_deg_s") for servo in servos)
        greatest = min(servo.number("max_rate_deg_s") for servo in servos)
    except RobotFileError as error:
        return (f"The speed was not compared with the servos. {error.what}",)
    except IndexError:
        return (f"The speed was not compared with the servos: {path} has {len(joints)} joints.",)
    speed = schedule.speed_deg_s
    if speed <= average:
        return ()
    if speed > greatest:
        above = f"above the greatest rate of the servos, {greatest:g} deg/s"
    else:
        above = f"above the average rate of the servos, {average:g} deg/s ({greatest:g} at most)"
    return (
        f"The speed of {speed:g} deg/s is {above}, by {path.name}: joints will not be where the schedule "
        "assumes when the next stroke starts, and may turn back before they reach their angles. "
        f"Rehearse it, or plan with {average:g} deg/s or less.",
    )
