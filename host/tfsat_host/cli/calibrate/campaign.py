"""A command's certificate: opened before anything is measured, and what came into it told at the end."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.options import certificate_path
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.robot import RobotModel


def open_campaign(args: argparse.Namespace, origin: Origin, model: RobotModel) -> Campaign:
    """The certificate that the steps go into; something may be written there.

    Raises:
        CalibrationError: it is of other sensors, damaged, or its recordings are.
        TfsatError: nothing can be written there.
    """
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.cli.calibrate.bench import subject_of
    from tfsat_host.cli.outputs import check_may_write

    path = certificate_path(args, emulated=origin.emulated)
    check_may_write(path, marker=b"", force=True)  # whether what is there may be replaced, the campaign knows
    return Campaign(path, model, subject_of(origin, model), force=args.force)


def tell(
    args: argparse.Namespace,
    campaign: Campaign,
    kept: Sequence[Evidence],
    before: Calibration | None,
    model: RobotModel,
    out: Output,
) -> None:
    """The command's result, as a table or as JSON.

    Args:
        args: The command's.
        campaign: With all steps accepted.
        kept: This command's steps.
        before: What was known when it began.
        model: The robot.
        out: Its voice.
    """
    from tfsat_host.cli.calibrate.results import NUMBERS, TABLES, Measured, campaign_numbers, show_end

    if campaign.calibration is None:
        raise ValueError("nothing was accepted")
    measured = Measured(kept, before, campaign.calibration, model, campaign.certificate)

    def show() -> None:
        TABLES[args.quantity](measured, out)
        show_end(measured, args, out)

    joint = {} if getattr(args, "joint", None) is None else {"joint": args.joint}
    numbers = NUMBERS[args.quantity](measured)
    out.result({**joint, **numbers, **campaign_numbers(measured)}, show)
