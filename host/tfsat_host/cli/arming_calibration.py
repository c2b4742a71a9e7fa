"""What `arm` says of calibration before the servos get pulses: afterwards the robot's sensors may be others."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output
from tfsat_host.run.files import find_certificate

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.evidence import Origin


def tell_calibration(args: argparse.Namespace, origin: Origin | None, out: Output) -> dict[str, Any] | None:
    """Says in notes what stands against the calibration; gives `calibration` for `--json`, None without one.

    Nothing here refuses an arming: a drop without a calibration can be evaluated with one that follows, a drop that is
    not flown cannot.

    Args:
        args: The command's.
        origin: Whose sensors hang on the logger; None: it was not asked.
        out: Its voice.
    """
    file = find_certificate(args.calibration, Path(), emulated=origin is not None and origin.emulated)
    if file is None:
        return None
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.run.certificate_notices import as_json, notices, unreadable_as_json

    try:
        calibration = read_calibration(file)
    except TfsatError as error:
        out.warn(f"{error.what} {error.meaning} {error.next_step}")
        return unreadable_as_json(file, error.what)
    said = notices(calibration, origin, file)
    for sentence in said:
        out.note(f"Calibration {file}: {sentence}")
    if origin is None:
        out.note(f"Calibration {file}: whether it is of this robot's sensors was not asked of the logger.")
    elif not said:
        out.note(f"Calibration: {file} holds for this drop.")
    return as_json(calibration, file, said)
