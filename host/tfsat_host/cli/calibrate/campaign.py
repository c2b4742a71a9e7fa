"""A command's certificate: opened before anything is measured, and what came into it told at the end."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.options import as_typed_here, certificate_path, resuming
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.robot import RobotModel


class NotKept(TfsatError):
    """A step was measured and accepted, and cannot be written (exit code 1)."""


def open_campaign(args: argparse.Namespace, origin: Origin, model: RobotModel, out: Output) -> Campaign:
    """The certificate that the steps go into; something may be written there. Warns of recordings that are lost.

    Raises:
        CalibrationError: it is of other sensors, damaged, or its recordings are.
        TfsatError: nothing can be written there.
    """
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.cli.calibrate.bench import subject_of
    from tfsat_host.output_files import check_may_write

    path = certificate_path(args, emulated=origin.emulated)
    check_may_write(path, marker=b"", force=True)  # whether what is there may be replaced, the campaign knows
    campaign = Campaign(path, model, subject_of(origin, model), force=args.force)
    for sentence in campaign.left_out:
        out.warn(f"{sentence} Its step does not count any more.")
    return campaign


def keep(campaign: Campaign, step: Evidence, args: argparse.Namespace, *, anew: bool = False) -> Calibration:
    """Has the campaign judge a step and keep it.

    Raises:
        CalibrationError: it was refused; nothing was changed.
        NotKept: the disk is full, or something else stands against writing; nothing was changed.
    """
    from tfsat_host.calibration.steps.evidence import file_name

    try:
        return campaign.accept(step, anew=anew)
    except OSError as error:
        recording = campaign.folder / file_name(step)
        file = campaign.certificate if recording.exists() else recording
        raise NotKept(
            what=f"{file} could not be written: {error.strerror or error}.",
            meaning=f"This step was not kept; {campaign.certificate} is as before.",
            next_step=f"Make room, or see that it may be written; then: {resuming(args)}",
        ) from error


def note_without_zero(campaign: Campaign, args: argparse.Namespace, out: Output) -> None:
    """Says before a motion that the angles of closed joints are only known by design."""
    unknown = [sensors.joint for sensors in campaign.solution().joints if sensors.zero_taken is None]
    if not unknown or out.json_mode:
        return
    joints = f"joint{'s' if len(unknown) > 1 else ''} {', '.join(map(str, unknown))}"
    every = len(unknown) == len(campaign.solution().joints)
    which = "--all" if every else f"--joint {unknown[0]}"
    out.note(
        f"Zero points of {joints} are not calibrated: what follows will be less sure for bodies beyond a closed "
        "joint.\n"
        f"  To measure them first: {as_typed_here(f'tfsat-host calibrate zero {which}', args)}"
    )


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
    from tfsat_host.cli.calibrate.results import Measured, campaign_numbers, numbers, show_end, show_found

    if campaign.calibration is None:
        raise ValueError("nothing was accepted")
    measured = Measured(kept, before, campaign.calibration, model, campaign.certificate)

    def show() -> None:
        show_found(args.quantity, measured, out)
        show_end(measured, args, out)

    joint = {} if getattr(args, "joint", None) is None else {"joint": args.joint}
    out.result({**joint, **numbers(args.quantity, measured), **campaign_numbers(measured)}, show)
