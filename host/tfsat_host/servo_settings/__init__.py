"""How the joints' servos turn pulses into angles: settings, their rules, their file. No ports, no terminal."""

from tfsat_host.servo_settings.file import format_settings, parse_settings, read_settings_file
from tfsat_host.servo_settings.settings import (
    FACTORY,
    FRAME,
    NS_PER_US,
    Finding,
    ServoSettings,
    SettingsDefect,
    SettingsError,
    find_defect,
    find_misfit,
    insist_on_fit,
    limits_text,
)

__all__ = [
    "FACTORY",
    "FRAME",
    "NS_PER_US",
    "Finding",
    "ServoSettings",
    "SettingsDefect",
    "SettingsError",
    "find_defect",
    "find_misfit",
    "format_settings",
    "insist_on_fit",
    "limits_text",
    "parse_settings",
    "read_settings_file",
]
