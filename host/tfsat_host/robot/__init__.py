"""The robot as rigid bodies joined by hinges: masses, joints, servos and sensors from a data file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tfsat_host.robot.path import RobotFileError, default_robot_path, find_robot, shipped_robots

if TYPE_CHECKING:
    from tfsat_host.robot.loading import load_robot
    from tfsat_host.robot.model import ASSUMED, AngleSensor, Imu, PulseMap, RobotModel, Servo, Uncertainty

__all__ = [
    "ASSUMED",
    "AngleSensor",
    "Imu",
    "PulseMap",
    "RobotFileError",
    "RobotModel",
    "Servo",
    "Uncertainty",
    "default_robot_path",
    "find_robot",
    "load_robot",
    "shipped_robots",
]


def __getattr__(name: str) -> Any:
    """Imports the model, and with it numpy, only when it is asked for."""
    if name == "load_robot":
        from tfsat_host.robot.loading import load_robot

        return load_robot
    if name in __all__:
        from tfsat_host.robot import model

        return getattr(model, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
