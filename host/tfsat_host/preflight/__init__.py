"""GO or NO-GO on the morning of a drop: evidence from both boards and the run's files, and what each check makes of it.

`asking` collects the evidence through the devices' clients, and `judging` turns it into checks; the checks are pure.
Knows nothing of ports, terminals or folders.
"""

from tfsat_host.preflight.check import Check, Verdict
from tfsat_host.preflight.judging import judge, may_drop

__all__ = ["Check", "Verdict", "judge", "may_drop"]
