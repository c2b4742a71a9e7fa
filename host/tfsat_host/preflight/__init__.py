"""GO or NO-GO before a drop: evidence from both boards and the run's files, and what each check makes of it.

`boards` and `logger` collect the evidence through the devices' clients, and `checks` makes of it what a person reads.
Knows nothing of ports, terminals or folders.
"""

from tfsat_host.preflight.checks import judge, may_drop
from tfsat_host.preflight.preflight_check import GoNoGo, PreflightCheck

__all__ = ["GoNoGo", "PreflightCheck", "judge", "may_drop"]
