"""The calibration of one robot in one campaign: values, uncertainties, recordings, and how long each holds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import TYPE_CHECKING

from tfsat_host import __version__
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.next_step import NextStep
from tfsat_host.protocol.limits import PROTOCOL_HASH

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.evidence import Origin

AXES_OF_BODIES = {1: "xy", 2: "xy", 3: "xy", 4: "xy"}
"""Two orthogonal axes on every body (paper, tab. misal)."""

DRAWABLE = {
    "bias": "biases of the gyros",
    "zero": "zero points",
    "misalignment": "misalignments of the gyros",
    "scale": "scale factors and the angle sensors' bend",
    "servo": "maps of the servos",
}
"""What `calibrate` measures, by its name there, and what that is called."""


@dataclass(frozen=True, slots=True)
class Subject:
    """What a calibration is of: only evidence of the same subject goes into one.

    Attributes:
        robot: Name in the robot file.
        logger_serial: Of the board that the sensors hang on, hexadecimal.
        who_am_i: Register 0x75 of IMUs 1 to 4, hexadecimal.
        emulated: It is no real robot.
    """

    robot: str
    logger_serial: str
    who_am_i: str
    emulated: bool

    def describe(self) -> str:
        """Format the subject for people."""
        kind = "the emulated logger" if self.emulated else "logger"
        return f"{self.robot} on {kind} {self.logger_serial or 'without a serial number'}"


@dataclass(frozen=True, slots=True)
class Paper:
    """One recording that a calibration rests on.

    Attributes:
        step: Key of the step.
        taken: When it was begun.
        file: Its name in the recordings' folder.
        sha256: Of its bytes, hexadecimal.
    """

    step: str
    taken: datetime
    file: str
    sha256: str


@dataclass(frozen=True, slots=True)
class Landing:
    """A fall that ended.

    Attributes:
        at: When.
        told_by: Who says so, such as `recording 1a2b3c4d`.
    """

    at: datetime
    told_by: str


@dataclass(frozen=True, eq=False)
class Calibration:
    """All that is known of one robot's sensors and servos.

    Attributes:
        subject: Whose.
        gyros: Of bodies 1 to 4.
        joints: Sensors of joints 1 to 3.
        servo_maps: Of the joints whose servo was measured, by joint.
        servo_taken: When, in the same order.
        papers: The recordings, in order of time.
        landings: In order of time.
        written: When the certificate was computed.
        tool_version, protocol_hash: Of the program that computed it.
        logger_image: CRC of the image that the logger ran in the newest recording, 8 hexadecimal digits; None: it
            ran natively, or nothing was recorded.
        drawn: Of `DRAWABLE`, what was never measured: a rehearsal drew it from an emulated robot's hidden truth.
    """

    subject: Subject
    gyros: tuple[GyroCalibration, ...]
    joints: tuple[JointSensors, ...]
    servo_maps: tuple[ServoMap, ...]
    servo_taken: tuple[datetime, ...]
    papers: tuple[Paper, ...]
    landings: tuple[Landing, ...]
    written: datetime
    tool_version: str = __version__
    protocol_hash: str = field(default_factory=PROTOCOL_HASH.hex)
    logger_image: str | None = None
    drawn: tuple[str, ...] = ()

    @property
    def last_landing(self) -> datetime | None:
        """When the robot last hit the ground, as far as is known."""
        return self.landings[-1].at if self.landings else None

    def widen(self, factor: float) -> Calibration:
        """Scale all standard deviations of gyros and angle sensors by `factor`."""
        square = factor**2
        return replace(
            self,
            gyros=tuple(replace(gyro, covariance=square * gyro.covariance) for gyro in self.gyros),
            joints=tuple(
                replace(
                    sensors,
                    zero_covariance=square * sensors.zero_covariance,
                    bend_covariance=square * sensors.bend_covariance,
                )
                for sensors in self.joints
            ),
        )

    def shortcomings(self, before: datetime | None = None) -> tuple[Shortcoming, ...]:
        """Find the quantities that are missing for a drop, or were measured before a landing.

        Args:
            before: Only landings before this time count: those that a recording of that time could know.
        """
        landings = [landing.at for landing in self.landings if before is None or landing.at < before]
        last = max(landings, default=None)
        return tuple(
            Shortcoming(
                quantity.name,
                quantity.command,
                "missing" if quantity.taken is None else "stale",
                quantity.taken,
            )
            for quantity in quantities(self)
            if quantity.taken is None
            or (quantity.ends_at_landing and last is not None and quantity.taken <= last)
        )


@dataclass(frozen=True, slots=True)
class Quantity:
    """One thing that a drop needs to be calibrated.

    Attributes:
        name: For people, such as `bias of body 1`; an axis in it is one of the body, not of the sensor.
        taken: When; None: not yet.
        ends_at_landing: A landing may change it.
        command: What measures it.
    """

    name: str
    taken: datetime | None
    ends_at_landing: bool
    command: NextStep


@dataclass(frozen=True, slots=True)
class Shortcoming:
    """A quantity that a drop cannot rely on.

    Attributes:
        name: Of the quantity.
        command: What measures it.
        reason: `missing`, or `stale`: older than the last landing.
        taken: When it was measured, if ever.
    """

    name: str
    command: NextStep
    reason: str
    taken: datetime | None


def quantities(calibration: Calibration) -> tuple[Quantity, ...]:
    """Everything that a drop needs, in the order in which it is measured.

    A landing ends what it may change: biases, zero points, mountings, and how a servo's horn sits. A gyro's scale
    factor is a property of its silicon, which survives 10,000 g (PS-MPU-6000A rev. 3.4, section 6.9).
    """
    last = calibration.last_landing
    needs_zero = [
        sensors.zero_taken is None or (last is not None and sensors.zero_taken <= last)
        for sensors in calibration.joints
    ]
    # One command for all joints where none has a valid zero.
    zero = _calibrate("zero", "--all") if all(needs_zero) else None
    servo_times = {
        servo_map.joint: when
        for servo_map, when in zip(calibration.servo_maps, calibration.servo_taken, strict=True)
    }
    return (
        *(
            Quantity(f"bias of body {gyro.body}", gyro.bias_taken, True, _calibrate("bias"))
            for gyro in calibration.gyros
        ),
        *(
            Quantity(
                f"zero point of joint {sensors.joint}",
                sensors.zero_taken,
                True,
                zero or _calibrate("zero", "--joint", str(sensors.joint)),
            )
            for sensors in calibration.joints
        ),
        *(_misalignment(gyro, axis) for gyro in calibration.gyros for axis in AXES_OF_BODIES[gyro.body]),
        *(_scale(gyro, axis) for gyro in calibration.gyros for axis in "xyz"),
        *(
            Quantity(
                f"servo of joint {sensors.joint}",
                servo_times.get(sensors.joint),
                True,
                _calibrate("servo", "--joint", str(sensors.joint)),
            )
            for sensors in calibration.joints
        ),
    )


def _misalignment(gyro: GyroCalibration, axis: str) -> Quantity:
    return Quantity(
        f"misalignment of body {gyro.body} about {axis}",
        gyro.axes.get(axis),
        True,
        _calibrate("misalignment", "--joint", str(_joint_about(gyro.body, axis))),
    )


def _scale(gyro: GyroCalibration, axis: str) -> Quantity:
    # No joint turns a body about z: only the whole robot, by hand, can.
    motion = ("--turn", "z", "360") if axis == "z" else ("--joint", str(_joint_about(gyro.body, axis)))
    taken_at = gyro.scaled.get(axis)
    return Quantity(f"scale factor {axis} of body {gyro.body}", taken_at, False, _calibrate("scale", *motion))


def _calibrate(quantity: str, *arguments: str) -> NextStep:
    return NextStep(f"calibrate {quantity}", arguments)


def _joint_about(body: int, axis: str) -> int:
    """Return the joint whose patterns move the body about that axis (paper, tab. misal)."""
    # Joint 2 turns all bodies about y; about x body 4 turns by joint 3, the others by joint 1.
    if axis == "y":
        return 2
    return 3 if body == 4 else 1


def with_landing(calibration: Calibration, landing: Landing) -> Calibration:
    """Add a landing, unless one within two minutes of it is known already."""
    # Recording and person may tell of one fall at slightly different times.
    if any(abs((other.at - landing.at).total_seconds()) < 120.0 for other in calibration.landings):
        return calibration
    landings = sorted((*calibration.landings, landing), key=lambda entry: entry.at)
    return replace(calibration, landings=tuple(landings))


def commands_of(shortcomings: Iterable[Quantity | Shortcoming]) -> tuple[NextStep, ...]:
    """Return the commands that measure the shortcomings' quantities, each once, in order."""
    return tuple(dict.fromkeys(gap.command for gap in shortcomings))


def summarize_shortcomings(shortcomings: Sequence[Shortcoming]) -> str:
    """Summarize shortcomings in a few words; empty if there are none."""
    parts = []
    for reason, words in (("missing", "not calibrated"), ("stale", "older than the last landing")):
        names = [gap.name for gap in shortcomings if gap.reason == reason]
        if names:
            parts.append(f"{words}: {list_names(names)}")
    return "; ".join(parts)


def list_names(names: Sequence[str]) -> str:
    """List the first three names, and how many more there are."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def of_another_robot(subject: Subject, origin: Origin) -> str:
    """Why it is of another one, a sentence that begins with "It is"; empty: it is of this one.

    One of its IMUs may have been exchanged since.
    """
    if subject.emulated != origin.emulated:
        theirs, these = ("an emulated", "a real") if subject.emulated else ("a real", "an emulated")
        return f"It is of {theirs} robot; these sensors are {these} one's."
    if subject.logger_serial != origin.logger_serial:
        there, here = (
            serial or "without a serial number" for serial in (subject.logger_serial, origin.logger_serial)
        )
        return f"It is of other sensors: it was taken on logger {there}; these hang on logger {here}."
    return ""


def in_words(names: Sequence[str]) -> str:
    """Some of `DRAWABLE` for people, such as `zero points, maps of the servos`."""
    return ", ".join(DRAWABLE[name] for name in names)
