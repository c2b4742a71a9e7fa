"""`tfsat-host calibrate replaced`: parts of the robot are other ones now."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.arguments import certificate_path, commands_as_typed
from tfsat_host.cli.calibrate.bench import open_bench
from tfsat_host.cli.calibrate.flow import open_campaign
from tfsat_host.cli.calibrate.show import show_certificate
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.robot import RobotModel


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks the logger what hangs on it now, and ends what rested on the part before.

    Raises:
        UsageError: a part is not there, or the logger is the one that the certificate names.
        CalibrationError: there is no certificate, it is of another robot, or it was simulated.
    """
    from tfsat_host.calibration.replacements import LOGGER, PARTS
    from tfsat_host.robot.absent_parts import load_robot_of_boards

    model = load_robot_of_boards(args.robot)
    for part in args.parts:
        _require_part(part, model)
    with open_bench(args, model, out) as bench, commands_as_typed(args, out):
        campaign = open_campaign(args, bench.origin, model, out, replaced=args.parts)
        before = campaign.calibration
        same = before is not None and before.subject.logger_serial == bench.origin.logger_serial
        if LOGGER in args.parts and same and bench.origin.logger_serial:
            raise UsageError(
                what=f"This logger is the one that was calibrated: serial number {bench.origin.logger_serial}.",
                meaning="Nothing was changed.",
                next_step=Advice("Plug the new one in; ", NextStep("ports"), " lists what is there."),
            )
        calibration = campaign.replace_parts(datetime.now(UTC))
    parts = "; ".join(f"{part} ({PARTS[part]})" for part in args.parts)
    out.note(f"Replaced: {parts}. All other values hold as before.")
    show_certificate(certificate_path(args, emulated=bench.origin.emulated), calibration, args, out)
    return 0


def _require_part(part: str, model: RobotModel) -> None:
    """Raises UsageError if a robot has no such part, or this one does not."""
    from tfsat_host.calibration.replacements import PARTS
    from tfsat_host.robot.absent_parts import bodies_with_imu, describe_absent, require_joint

    if part not in PARTS:
        raise UsageError(
            what=f"A robot has no part {part!r}.",
            meaning="Nothing was changed.",
            next_step=f"Parts: {', '.join(PARTS)}.",
        )
    kind, _, number = part.partition("-")
    if kind == "imu" and int(number) not in bodies_with_imu(model):
        raise UsageError(
            what=f"{model.name} has no {part}. {describe_absent(model)}.",
            meaning="Nothing was changed.",
            next_step="Name a part that it has, or the right robot file with --robot.",
        )
    if kind in ("angle", "servo"):
        require_joint(model, int(number))
