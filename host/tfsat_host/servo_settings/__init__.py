"""How the joints' servos turn pulses into angles: settings, their rules, their file. No ports, no terminal."""

from tfsat_host.servo_settings.errors import SettingsDefect, SettingsError
from tfsat_host.servo_settings.file import format_settings, parse_settings, read_settings_file
from tfsat_host.servo_settings.fit import Misfit, find_misfit
from tfsat_host.servo_settings.rules import FRAME, Finding, find_defect
from tfsat_host.servo_settings.settings import FACTORY, ServoSettings

__all__ = [
    "FACTORY",
    "FRAME",
    "Finding",
    "Misfit",
    "ServoSettings",
    "SettingsDefect",
    "SettingsError",
    "find_defect",
    "find_misfit",
    "format_settings",
    "parse_settings",
    "read_settings_file",
]
