"""Whether a recording is of the robot that its preflight and its certificate are of: each names its logger."""

from __future__ import annotations

from typing import Any


def not_of_this_robot(serial: str, preflight: Any, certificate: str | None) -> list[str]:
    """What names another logger than the recording does; a sentence each.

    Args:
        serial: Of the logger that recorded, hexadecimal; empty: it gave none.
        preflight: What `preflight.json` holds; whatever is no preflight's names no logger.
        certificate: The logger that the certificate names; None: there is none, or it cannot be read.
    """
    said = {"preflight.json": _logger_in(preflight), "the certificate": certificate}
    return [
        f"The recording is of logger {serial or 'without a serial number'}, {what} of logger "
        f"{other or 'without a serial number'}: they are of different robots."
        for what, other in said.items()
        if other is not None and other.lower() != serial.lower()
    ]


def _logger_in(preflight: Any) -> str | None:
    boards = preflight.get("boards") if isinstance(preflight, dict) else None
    logger = boards.get("logger") if isinstance(boards, dict) else None
    serial = logger.get("serial") if isinstance(logger, dict) else None
    return serial if isinstance(serial, str) else None
