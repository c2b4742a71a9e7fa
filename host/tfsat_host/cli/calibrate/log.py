"""`tfsat-host calibrate bias --log`: the biases from a recording that was quiet before its release."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.cli.calibrate.campaign import open_campaign, tell
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from pathlib import Path

    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.sdlog import DropLog


def run(args: argparse.Namespace, out: Output) -> int:
    """Takes the rest out of the recording, judges and keeps it as one on the bench."""
    from tfsat_host.robot import load_robot
    from tfsat_host.sdlog.load import load

    model = load_robot(args.robot)
    with out.progress(f"Reading {args.log}", total=1.0) as advance:
        log = load(args.log, progress=advance)
    rested = _rest_of(log, args.log)
    campaign = open_campaign(args, rested.origin, model)
    before = campaign.calibration
    campaign.accept(rested)
    tell(args, campaign, [rested], before, model, out)
    return 0


def _rest_of(log: DropLog, file: Path) -> Evidence:
    """Raises CalibrationError if nothing rested, or nobody knows when."""
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.calibration.steps.quiet_log import LEAST_S, quiet_before_release
    from tfsat_host.calibration.steps.step import rest

    counts = quiet_before_release(log)
    if counts is None:
        raise CalibrationError(
            what=f"The robot in {file} never rested for {LEAST_S:g} s before its release.",
            meaning="The biases cannot be told from its motion; nothing was kept.",
            next_step="Take them on the bench: tfsat-host calibrate bias",
        )
    if log.unix_offset_us is None:
        raise CalibrationError(
            what=f"{file} does not say at what time of day it was recorded.",
            meaning="Whether its biases are older than a landing could never be told; nothing was kept.",
            next_step="Take them on the bench: tfsat-host calibrate bias",
        )
    header = log.header
    origin = Origin(
        logger_serial=header.board_serial.hex() if any(header.board_serial) else "",
        who_am_i=header.who_am_i.hex(),
        emulated=header.image_crc == 0,
        firmware=".".join(map(str, header.firmware_version)),
        image_crc=f"{header.image_crc:08x}",
    )
    taken = datetime.fromtimestamp(0, UTC) + timedelta(microseconds=log.unix_offset_us + int(counts.t_us[0]))
    return Evidence(rest(), counts, taken, origin)
