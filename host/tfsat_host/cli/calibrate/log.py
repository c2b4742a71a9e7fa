"""`tfsat-host calibrate bias --log`: the biases from a recording that was quiet before its release."""

from __future__ import annotations

import argparse
import shlex
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.cli.calibrate.campaign import open_campaign, tell
from tfsat_host.cli.calibrate.options import as_typed_here
from tfsat_host.present.output import Output
from tfsat_host.run.certificate import origin_of_log

if TYPE_CHECKING:
    from pathlib import Path

    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.sdlog import DropLog


def run(args: argparse.Namespace, out: Output) -> int:
    """Takes the rest out of the recording, judges and keeps it as one on the bench."""
    from tfsat_host.robot import load_robot
    from tfsat_host.sdlog.load import load

    model = load_robot(args.robot)
    with out.progress(f"Reading {args.log}", total=1.0) as advance:
        log = load(args.log, progress=advance)
    # What is to be typed next is for the robot of the recording, not for whatever is plugged in.
    here = argparse.Namespace(**{**vars(args), "emulated": origin_of_log(log.header).emulated})
    try:
        rested = _rest_of(log, args.log)
        campaign = open_campaign(args, rested.origin, model, out)
        before = campaign.calibration
        newer = _newer_than(rested, campaign)
        if newer is None:
            campaign.accept(rested)
    except CalibrationError as error:
        error.next_step = as_typed_here(error.next_step, here)
        raise
    if newer is not None and newer.taken > rested.taken:
        raise _too_old(rested, newer, campaign.certificate, args)
    if newer is not None:
        out.note(f"{campaign.certificate} rests on this recording already: nothing was changed.")
    tell(here, campaign, [rested], before, model, out)
    return 0


def _newer_than(rested: Evidence, campaign: Campaign) -> Evidence | None:
    """The rest for which this one would not count, or this very one; None: it is the newest."""
    known = (one for one in campaign.evidence if one.step.key == rested.step.key)
    return max((one for one in known if one.taken >= rested.taken), key=lambda one: one.taken, default=None)


def _too_old(rested: Evidence, newer: Evidence, file: Path, args: argparse.Namespace) -> CalibrationError:
    other = file.with_name(f"{file.stem}-{args.log.stem}.toml")
    robot = "" if args.robot is None else f" --robot {shlex.quote(str(args.robot))}"
    return CalibrationError(
        what=f"The rest in {args.log} is of {rested.taken:%Y-%m-%d %H:%M} UTC, older than the biases in {file}, which "
        f"are of {newer.taken:%Y-%m-%d %H:%M} UTC.",
        meaning="The newest biases count: nothing was changed.",
        next_step="To look at the recording's, give them a certificate of their own: tfsat-host calibrate bias "
        f"--log {shlex.quote(str(args.log))} --out {shlex.quote(str(other))}{robot}",
    )


def _rest_of(log: DropLog, file: Path) -> Evidence:
    """Raises CalibrationError if nothing rested, or nobody knows when."""
    from tfsat_host.calibration.quiet_log import LEAST_S, quiet_before_release
    from tfsat_host.calibration.steps.evidence import Evidence
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
    taken = datetime.fromtimestamp(0, UTC) + timedelta(microseconds=log.unix_offset_us + int(counts.t_us[0]))
    return Evidence(rest(), counts, taken, origin_of_log(log.header))
