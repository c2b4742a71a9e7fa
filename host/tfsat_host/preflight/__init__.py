"""GO or NO-GO before a drop: evidence from both boards and the run's files, and what each check makes of it.

`board_queries` and `logger_queries` collect the evidence through the devices' clients, `checks` judges it, and
`preflight_result` shows it. Knows nothing of ports or folders.
"""

from tfsat_host.preflight.checks import judge, may_drop
from tfsat_host.preflight.preflight_check import GoNoGo, PreflightCheck

__all__ = ["GoNoGo", "PreflightCheck", "judge", "may_drop"]
