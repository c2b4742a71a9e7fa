"""How fast live samples really come, and which never came."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from tfsat_host.protocol.messages import LiveSampleStream
from tfsat_host.units import US_PER_S

WINDOW_US = US_PER_S
"""The rate is that of the last second, on the logger's clock."""


class StreamMeter:
    """Measures a stream of live samples.

    Attributes:
        missed: Samples that the logger took and that never arrived, since the first.
        gaps: Places at which some are missing.
    """

    def __init__(self) -> None:
        self.missed = 0
        self.gaps = 0
        self._recent: deque[tuple[int, int]] = deque()

    def add(self, samples: Iterable[LiveSampleStream]) -> None:
        """Takes samples in the order in which they came."""
        for sample in samples:
            if self._recent:
                lost = sample.index - self._recent[-1][0] - 1
                if lost < 0:  # the logger has restarted: its indices begin anew
                    self._recent.clear()
                elif lost > 0:
                    self.missed += lost
                    self.gaps += 1
            self._recent.append((sample.index, sample.time_us))
            while self._recent[-1][1] - self._recent[0][1] > WINDOW_US:
                self._recent.popleft()

    @property
    def rate_hz(self) -> float | None:
        """Samples that the logger took a second, those that never arrived included; None: not known yet."""
        if len(self._recent) < 2:
            return None
        (first, first_us), (last, last_us) = self._recent[0], self._recent[-1]
        return (last - first) * US_PER_S / (last_us - first_us) if last_us > first_us else None
