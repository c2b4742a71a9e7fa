"""Ground tools of a transformable CubeSat robot: upload, calibrate, record, decode, rehearse.

import tfsat_host as tfsat

log = tfsat.load("SD.bin")                   # a recording as a `DropLog`
drop = tfsat.Run.open("run").evaluate()      # a drop with the files beside it, evaluated
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes a quarter of the time of `tfsat-host --help`
if TYPE_CHECKING:
    from typing import Any

    from tfsat_host.run import EvaluationOptions, Run
    from tfsat_host.sdlog import DropLog, load

__all__ = ["DropLog", "EvaluationOptions", "Run", "__version__", "load"]

__version__ = "0.2.0"


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> Any:
    """Imports decoder and evaluation, and with them numpy, only when they are asked for."""
    if name in ("DropLog", "load"):
        from tfsat_host import sdlog

        return getattr(sdlog, name)
    if name in ("EvaluationOptions", "Run"):
        from tfsat_host import run

        return getattr(run, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
