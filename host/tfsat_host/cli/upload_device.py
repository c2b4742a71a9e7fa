"""The part of `upload-sequence` that touches a board."""

from __future__ import annotations

import argparse

from tfsat_host.cli.advice import device_option, offering_emulated
from tfsat_host.cli.connection import open_sequencer
from tfsat_host.errors import RefusedError
from tfsat_host.maneuver import Schedule
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.servo_settings import ServoSettings, find_misfit


class LimitsRefusal(RefusedError):
    """The maneuver would leave a joint's limits; the board would store it, and refuse to arm with it."""

    code = ErrorCode.SETTINGS_DO_NOT_FIT


def upload(
    schedule: Schedule, args: argparse.Namespace, out: Output
) -> tuple[dict[str, object], ServoSettings]:
    """Sends the schedule, has it read back and compared; the JSON keys that tell of it, and the board's settings.

    Raises:
        LimitsRefusal: a stroke leaves its joint's limits in the board's servo settings.
        TfsatError: no board, another board, a refusal, or what was read back differs.
    """
    with offering_emulated(), open_sequencer(args, out) as sequencer:
        settings = sequencer.settings().settings
        _check_limits(schedule, settings, args)
        with out.progress(f"uploading to {sequencer.port}"):
            result = sequencer.upload(schedule)
        told: dict[str, object] = {
            "verified": True,
            "written": result.written,
            "identity": sequencer.identity.describe(),
            "device": {"port": sequencer.port, **sequencer.identity.as_dict()},
            "maneuver_crc": f"{result.stored.crc:04x}",
            "generation": result.stored.generation,
        }
        return told, settings


def _check_limits(schedule: Schedule, settings: ServoSettings, args: argparse.Namespace) -> None:
    misfit = find_misfit(((stroke.joint, stroke.angle_cdeg) for stroke in schedule.strokes), settings)
    if misfit is not None:
        raise LimitsRefusal(
            what=f"{misfit.words[:1].upper()}{misfit.words[1:]}.",
            meaning="The servo would be driven against its stop, so the board would refuse to arm. Nothing was sent.",
            next_step="Choose smaller angles, or correct the limits. "
            f"They are shown by: tfsat-host upload-servos --show{device_option(args)}",
        )
