"""Virtual time that follows a real clock."""

from __future__ import annotations

from tfsat_host.emulated.robot import US_PER_S

STEP_US = 1000
"""Virtual time between two looks at the ports: about the frame of full-speed USB."""
LONGEST_BACKLOG_S = 0.25
"""What is made up for after a hiccup; it is also how long a host waits for an answer."""
TOLERATED_LAG_S = 0.5
"""Lag in all that is not worth a word."""


class Pacer:
    """Says how many steps are due, and when the next one is.

    The clock is the caller's: seconds from any origin, never going back. What the computer cannot make
    up for within LONGEST_BACKLOG_S is given up: virtual time then lags for good, by `lag_s`.

    Args:
        now_s: The clock at virtual time zero.
    """

    def __init__(self, now_s: float) -> None:
        self._origin_s = now_s
        self._steps = 0
        self._lag_told = False
        self.lag_s = 0.0

    def steps_due(self, now_s: float) -> int:
        """Steps of STEP_US to run now; counted as run."""
        behind_s = now_s - self._time_of(self._steps)
        if behind_s > LONGEST_BACKLOG_S:
            given_up_s = behind_s - LONGEST_BACKLOG_S
            self._origin_s += given_up_s
            self.lag_s += given_up_s
            behind_s = LONGEST_BACKLOG_S
        due = max(0, int(behind_s * US_PER_S / STEP_US))
        self._steps += due
        return due

    def wait_s(self, now_s: float) -> float:
        """Seconds until the next step is due; 0 if one is."""
        return max(0.0, self._time_of(self._steps + 1) - now_s)

    def new_lag(self) -> bool:
        """True once: when the lag has become worth telling."""
        if self._lag_told or self.lag_s < TOLERATED_LAG_S:
            return False
        self._lag_told = True
        return True

    def _time_of(self, steps: int) -> float:
        return self._origin_s + steps * STEP_US / US_PER_S
