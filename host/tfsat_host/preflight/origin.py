"""Whose sensors hang on a logger that is connected."""

from __future__ import annotations

from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.devices.client import BoardIdentity


def origin_of_logger(identity: BoardIdentity, who_am_i: bytes) -> Origin:
    """By its own words.

    Args:
        identity: Of the logger, by HELLO.
        who_am_i: Of the IMUs, by its status.
    """
    return Origin(
        identity.serial, who_am_i.hex(), identity.runs_natively, identity.firmware, identity.image_crc
    )
