"""`tfsat-host logger-settings`: how the logger samples and records."""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict, dataclass, replace
from typing import Any

from tfsat_host.cli.boards import offering_emulated, open_logger
from tfsat_host.cli.usage import add_actions, add_options, device
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.logger_configuration import DLPF_HZ, FACTORY, StoredLoggerSettings, check, rate_max_hz
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import LoggerSettings
from tfsat_host.quantity import Column, Columns, fields, record

_SETTINGS = (
    ("rate", "rate_hz", "sampling rate", "Hz"),
    ("gyro_range", "gyro_range_deg_s", "gyro range", "deg/s (±)"),
    ("accel_range", "accel_range_g", "accelerometer range", "g (±)"),
    ("dlpf", "dlpf_cfg", "low-pass filter", ""),
    ("bus_khz", "bus_khz", "I2C bus clock", "kHz"),
    ("after_landing", "after_landing_s", "recording after landing", "s"),
    ("file_mib", "file_mib", "room of a recording", "MiB"),
)
"""Option, name; label and unit in the table."""


@dataclass(frozen=True, slots=True)
class SettingsInForce:
    """A logger's settings now, those before, the logger, and whether its clock was set."""

    stored: StoredLoggerSettings
    before: LoggerSettings
    device: Device
    clock_set: bool


_LOGGER_SETTINGS = fields(" ".join(name for name, *_ in LoggerSettings.LAYOUT))
_SHOWN: Columns = (
    *fields("origin=stored.origin rate_max_hz=stored.rate_max_hz"),
    Column("settings", of="stored.settings", columns=_LOGGER_SETTINGS),
    Column("device", columns=DEVICE),
)
_SET: Columns = (
    *_SHOWN,
    Column("before", columns=_LOGGER_SETTINGS),
    Column("verified", of=lambda _: True),
    *fields("clock_set"),
)
_ACTIONS = """
show  show the current settings
set   change the named settings, keep the others
    --rate HZ           sampling rate, 10 to 1000
    --gyro-range DEG_S  full scale of the gyros: 250, 500, 1000 or 2000
    --accel-range G     full scale of the accelerometers: 2, 4, 8 or 16
    --dlpf N            low-pass filter, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz
    --bus-khz KHZ       clock of the I2C buses: 100 or 400
    --after-landing S   a recording closes automatically this long after the landing, 5 to 600
    --file-mib MIB      room that a recording takes on the card, 1 to 1024
    --factory           factory values for all other settings
    --clock             also set the logger's time of day to this computer's, until power goes off
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Show, or set what is named; the device."""
    kinds: dict[str, Any] = {option: {"type": _whole, "dest": name} for option, name, *_ in _SETTINGS}
    actions = add_actions(parser, _ACTIONS, after=device("logger"), required=False, **kinds)
    # Without an action it shows: these options then stand behind the command itself.
    add_options(parser, device("logger"))
    # An action's defaults would replace options that were typed before its name.
    for argument in (argument for action in actions.values() for argument in action._actions):
        if argument.dest in ("port", "emulated", "json", "yes"):
            argument.default = argparse.SUPPRESS


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows or sets."""
    sets = args.action == "set"
    changes = _wanted_settings(args) if sets else {}
    with offering_emulated(), open_logger(args, out) as logger:
        before = stored = logger.settings()
        settings = replace(before.settings, **changes)
        if changes:
            check(settings)
        if sets and args.clock:
            logger.set_clock(time.time_ns() // 1000)
        if changes:
            stored = logger.write_settings(settings)
        result = SettingsInForce(stored, before.settings, logger.device(), sets and args.clock)

    def show() -> None:
        _show(stored, before.settings, out)
        if changes:
            out.line("Stored, read back and identical")
        if result.clock_set:
            out.line("Clock: set to this computer's time, until power goes off")

    out.result(record(_SET if sets else _SHOWN, result), show)
    return 0


def _wanted_settings(args: argparse.Namespace) -> dict[str, int]:
    named = {name: value for _, name, *_ in _SETTINGS if (value := getattr(args, name)) is not None}
    if not named and not args.factory and not args.clock:
        raise UsageError(
            what="No setting was named.",
            meaning="The logger keeps its settings.",
            next_step=Advice("For example: ", NextStep("logger-settings set", ("--rate", "1000"))),
        )
    return asdict(FACTORY) | named if args.factory else named


def _show(stored: StoredLoggerSettings, before: LoggerSettings, out: Output) -> None:

    now = stored.settings
    columns = ["setting", "value", "unit", *(["before"] if before != now else [])]
    # The filter is set by a number, but it is known by its cut-off.
    shown = [{**asdict(settings), "dlpf_cfg": DLPF_HZ[settings.dlpf_cfg]} for settings in (now, before)]
    rows = [
        (label, shown[0][name], f"Hz (--dlpf {now.dlpf_cfg})" if name == "dlpf_cfg" else unit, shown[1][name])
        for _, name, label, unit in _SETTINGS
    ]
    out.table(columns, [row[: len(columns)] for row in rows])
    origin = "factory" if stored.origin == Origin.FACTORY else "stored on the logger"
    out.line(f"Settings: {origin}")
    out.line(f"Max. rate: {rate_max_hz(now.bus_khz)} Hz (I2C bus at {now.bus_khz} kHz)")


def _whole(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 6):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number")
    return int(text)
