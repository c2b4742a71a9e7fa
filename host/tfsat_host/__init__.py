"""Ground tools of a transformable CubeSat robot: upload, calibrate, record, decode, rehearse.

`load("SD.bin")` decodes a recording into a `DropLog`.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes a quarter of the time of `tfsat-host --help`
if TYPE_CHECKING:
    from typing import Any

    from tfsat_host.sdlog import DropLog, load

__all__ = ["DropLog", "__version__", "load"]

__version__ = "0.2.0"


def __getattr__(name: str) -> Any:
    """Imports the decoder, and with it numpy, only when it is asked for."""
    if name in ("DropLog", "load"):
        from tfsat_host import sdlog

        return getattr(sdlog, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
