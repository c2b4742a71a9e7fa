"""Whether a calibration is of the robot whose sensors these are, in the same words wherever it is asked."""

from __future__ import annotations

from tfsat_host.calibration.certificate.certificate import Subject
from tfsat_host.calibration.steps.evidence import Origin


def of_another_robot(subject: Subject, origin: Origin) -> str:
    """Why it is of another one, a sentence that begins with "It is"; empty: it is of this one.

    One of its IMUs may have been exchanged since.
    """
    if subject.emulated != origin.emulated:
        theirs, these = ("an emulated", "a real") if subject.emulated else ("a real", "an emulated")
        return f"It is of {theirs} robot; these sensors are {these} one's."
    if subject.logger_serial != origin.logger_serial:
        there, here = (
            serial or "without a serial number" for serial in (subject.logger_serial, origin.logger_serial)
        )
        return f"It is of other sensors: it was taken on logger {there}; these hang on logger {here}."
    return ""
