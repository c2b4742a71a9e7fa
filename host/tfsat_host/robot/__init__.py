"""The robot as rigid bodies joined by hinges: masses, joints, servos and sensors from a data file."""

from tfsat_host.robot.errors import RobotFileError
from tfsat_host.robot.loading import default_robot_path, load_robot
from tfsat_host.robot.model import AngleSensor, Imu, RobotModel, Servo

__all__ = ["AngleSensor", "Imu", "RobotFileError", "RobotModel", "Servo", "default_robot_path", "load_robot"]
