"""Parts of a robot that were replaced: a board, a sensor or a servo breaks, and the rest of a calibration holds on.

Each part of that name is a specimen of its own: nothing that was measured of one is taken for the next. A quantity
that rests on none of the replaced parts keeps its value and its date.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Final

from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT

LOGGER, SEQUENCER = "logger", "sequencer"
IMUS: Final = tuple(f"imu-{body}" for body in range(1, IMU_COUNT + 1))
ANGLES: Final = tuple(f"angle-{joint}" for joint in range(1, JOINT_COUNT + 1))
SERVOS: Final = tuple(f"servo-{joint}" for joint in range(1, JOINT_COUNT + 1))
PARTS: Final = {
    LOGGER: "the Teensy: the zero points, since its converter reads the angle sensors",
    SEQUENCER: "the Micro: the maps of the servos, since its clock times their pulses",
    **{part: f"IMU of body {body}: all of its gyro" for body, part in enumerate(IMUS, 1)},
    **{
        part: f"an angle sensor of joint {joint}, one or both: zero point and nonlinearity"
        for joint, part in enumerate(ANGLES, 1)
    },
    **{part: f"servo of joint {joint}: its map" for joint, part in enumerate(SERVOS, 1)},
}
"""What may be replaced, and which quantities end with it."""


@dataclass(frozen=True, slots=True)
class Replacement:
    """A part that was replaced.

    Attributes:
        at: When it was told.
        part: One of `PARTS`.
        was: What the part before told of itself: a logger its serial number, an IMU its WHO_AM_I, hexadecimal.
    """

    at: datetime
    part: str
    was: str = ""


@dataclass(frozen=True, slots=True)
class Specimens:
    """Which specimen of each part was in place when, counted from 0.

    Attributes:
        replacements: In order of time.
    """

    replacements: tuple[Replacement, ...] = ()

    def number(self, *parts: str, at: datetime | None = None) -> int:
        """Return the specimen in place at a time; None: now. Of several parts the number changes with each."""
        return sum(
            replacement.part in parts and (at is None or replacement.at <= at)
            for replacement in self.replacements
        )

    def gyro(self, body: int, at: datetime | None = None) -> int:
        """Return the specimen of the gyro of a body (1 to 4)."""
        return self.number(IMUS[body - 1], at=at)

    def angle(self, joint: int, at: datetime | None = None) -> int:
        """Return the specimen of the angle sensors of a joint (1 to 3), whose bend is theirs alone."""
        return self.number(ANGLES[joint - 1], at=at)

    def zero(self, joint: int, at: datetime | None = None) -> int:
        """Return the specimen of a joint's angle sensors with the converter that reads them."""
        return self.number(ANGLES[joint - 1], LOGGER, at=at)

    def servo(self, joint: int, at: datetime | None = None) -> int:
        """Return the specimen of a joint's servo with the board that times its pulses."""
        return self.number(SERVOS[joint - 1], SEQUENCER, at=at)

    def since(self, moment: datetime) -> list[str]:
        """Name the parts that were replaced after a moment, in order of time, each once."""
        return list(dict.fromkeys(entry.part for entry in self.replacements if entry.at > moment))


NEVER_REPLACED: Final = Specimens()
