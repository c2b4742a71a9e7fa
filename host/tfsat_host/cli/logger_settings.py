"""`tfsat-host logger-settings`: how the logger samples and records."""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_device_options
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.logger_settings import StoredLoggerSettings
    from tfsat_host.protocol.messages import LoggerSettings

_ACTIONS = {"show": "what is in force", "set": "change what is named, keep the rest"}
_OPTIONS = (
    ("--rate", "rate_hz", "HZ", "sampling rate, 10 to 1000"),
    ("--gyro-range", "gyro_range_deg_s", "DEG_S", "full scale of the gyros: 250, 500, 1000 or 2000"),
    ("--accel-range", "accel_range_g", "G", "full scale of the accelerometers: 2, 4, 8 or 16"),
    ("--dlpf", "dlpf_cfg", "N", "low-pass filter, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz"),
    ("--bus-khz", "bus_khz", "KHZ", "clock of the I2C buses: 100 or 400"),
    (
        "--after-landing",
        "after_landing_s",
        "S",
        "a recording closes by itself this long after the landing, 5 to 600",
    ),
    ("--file-mib", "file_mib", "MIB", "room that a recording takes on the card, 1 to 1024"),
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Show, or set what is named; the device."""
    actions = add_subcommands(parser, _ACTIONS, required=False)
    set_ = actions["set"]
    for option, name, metavar, meaning in _OPTIONS:
        set_.add_argument(option, dest=name, metavar=metavar, type=_whole, help=meaning)
    set_.add_argument(
        "--factory", action="store_true", help="take the factory's values for all that is not named"
    )
    set_.add_argument(
        "--clock",
        action="store_true",
        help="also set the logger's time of day to this computer's, until power goes",
    )
    # Without an action it shows: these options then stand behind the command itself.
    add_device_options(parser, "logger")
    for action in actions.values():
        add_device_options(action, "logger")
        _keep_what_stands_before(action)


def _keep_what_stands_before(action: argparse.ArgumentParser) -> None:
    """An action's defaults would replace options that were typed before its name."""
    for option in action._actions:
        if option.dest in ("port", "emulated", "json", "yes"):
            option.default = argparse.SUPPRESS


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows or sets."""
    return _set(args, out) if args.action == "set" else _show(args, out)


def _show(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.cli.advice import offering_emulated
    from tfsat_host.cli.connection import open_logger

    with offering_emulated(), open_logger(args, out) as logger:
        stored = logger.settings()
        result = {**_as_dict(stored), "device": _device(logger)}
    out.result(result, lambda: _tell(stored, None, out))
    return 0


def _set(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.cli.advice import offering_emulated
    from tfsat_host.cli.connection import open_logger
    from tfsat_host.devices.logger_settings import FACTORY, check

    named = {name: value for _, name, _, _ in _OPTIONS if (value := getattr(args, name)) is not None}
    wanted = asdict(FACTORY) | named if args.factory else named
    if not wanted and not args.clock:
        raise UsageError(
            what="Nothing to set was named.",
            meaning="The logger keeps its settings.",
            next_step="Such as: tfsat-host logger-settings set --rate 1000",
        )
    with offering_emulated(), open_logger(args, out) as logger:
        before = logger.settings()
        settings = replace(before.settings, **wanted)
        check(settings)
        if args.clock:
            logger.set_clock(time.time_ns() // 1000)
        stored = logger.write_settings(settings) if wanted else before
        result = {
            **_as_dict(stored),
            "before": asdict(before.settings),
            "verified": True,
            "clock_set": args.clock,
            "device": _device(logger),
        }

    def tell() -> None:
        _tell(stored, before.settings, out)
        if wanted:
            out.line("Stored, read back and identical.")
        if args.clock:
            out.line("The logger's time of day is this computer's, until its power goes.")

    out.result(result, tell)
    return 0


def _tell(stored: StoredLoggerSettings, before: LoggerSettings | None, out: Output) -> None:
    from tfsat_host.devices.logger_settings import DLPF_HZ, bus_arithmetic
    from tfsat_host.protocol.enums import Origin

    now = stored.settings
    rows = (
        ("sampling rate", "rate_hz", "Hz"),
        ("gyro range", "gyro_range_deg_s", "deg/s, ±"),
        ("accelerometer range", "accel_range_g", "g, ±"),
        ("low-pass filter", "dlpf_cfg", f"{DLPF_HZ[now.dlpf_cfg]} Hz"),
        ("I2C bus clock", "bus_khz", "kHz"),
        ("after the landing", "after_landing_s", "s"),
        ("file", "file_mib", "MiB"),
    )
    changed = before is not None and before != now
    columns = ("setting", "value", "unit", *(["before"] if changed else []))
    out.table(
        columns,
        [
            (what, getattr(now, name), unit, *([getattr(before, name)] if changed else []))
            for what, name, unit in rows
        ],
    )
    origin = "the firmware's own" if stored.origin == Origin.FACTORY else "stored on the logger"
    out.line(f"These settings are {origin}.")
    out.line(f"{bus_arithmetic(now.rate_hz, now.bus_khz)}.")


def _as_dict(stored: StoredLoggerSettings) -> dict[str, Any]:
    return {
        "origin": stored.origin.name.lower(),
        "settings": asdict(stored.settings),
        "rate_max_hz": stored.rate_max_hz,
    }


def _device(logger: LoggerClient) -> dict[str, str | None]:
    return {"port": logger.port, **logger.identity.as_dict()}


def _whole(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 6):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number")
    return int(text)
