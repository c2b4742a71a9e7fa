"""Pages of long campaigns: of the present firmware, or with a sentence that names the one they were measured on."""

from __future__ import annotations

import re
from pathlib import Path

from tfsat_host.protocol.limits import FIRMWARE_VERSION

_MEASURED_ON = re.compile(
    r"^\*\*Measured on firmware (\d+)\.(\d+)\.(\d+), not on the present one", re.MULTILINE
)


def is_of_this_firmware(page: Path) -> bool:
    """A page that its make target writes anew has no such sentence, and is compared again."""
    named = _MEASURED_ON.search(page.read_text(encoding="utf-8"))
    return named is None or tuple(map(int, named.groups())) == FIRMWARE_VERSION
