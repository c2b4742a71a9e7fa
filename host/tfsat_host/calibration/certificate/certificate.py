"""The calibration of one robot in one campaign: values, uncertainties, recordings, and how long each holds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from typing import Literal

from tfsat_host import __version__
from tfsat_host.arrays import describe_fields
from tfsat_host.calibration.replacements import ANGLES, IMUS, LOGGER, Replacement, Specimens
from tfsat_host.calibration.sensors.gyro import GyroCalibration, by_design
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.servos.dynamics_fit import MeasuredDynamics
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.next_step import NextStep
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.robot import RobotModel

AXES_OF_BODIES = {1: "xy", 2: "xy", 3: "xy", 4: "xy"}
"""Two orthogonal axes on every body (paper, tab. misal)."""

CLOCKS_DIFFER = timedelta(minutes=1)
"""Two computers' clocks may disagree by so much; what was measured later than this is of the future."""
_MAX_NAMED = 3

QUANTITY_NAMES = {
    "bias": "biases of the gyros",
    "zero": "zero points",
    "misalignment": "misalignments of the gyros",
    "scale": "scale factors and the angle sensors' nonlinearity",
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

    def with_part(self, part: str, told: str) -> Subject:
        """Return the robot with another part, given what that tells of itself; see `Replacement`."""
        if part == LOGGER:
            return replace(self, logger_serial=told)
        if part not in IMUS or not told:
            return self
        at = 2 * IMUS.index(part)
        return replace(self, who_am_i=self.who_am_i[:at] + told + self.who_am_i[at + 2 :])

    def of_robot(self, model: RobotModel) -> Subject:
        """Return the subject without the IMUs that a robot file does not have: theirs is 00."""
        answers = zip(bytes.fromhex(self.who_am_i), model.imus, strict=True)
        return replace(self, who_am_i="".join("00" if imu.absent else f"{byte:02x}" for byte, imu in answers))

    def name_part(self, part: str) -> str:
        """Name one of the IMUs by its WHO_AM_I."""
        told = self.of_part(part)
        return "silent" if told == "00" else f"an IMU with WHO_AM_I {told}"

    def of_part(self, part: str) -> str:
        """Return what a part tells of itself; empty: nothing."""
        if part == LOGGER:
            return self.logger_serial
        return self.who_am_i[2 * IMUS.index(part) :][:2] if part in IMUS else ""

    def describe(self) -> str:
        """Format the subject for people."""
        kind = "the emulated logger" if self.emulated else "logger"
        return f"{self.robot} on {kind} {self.logger_serial or 'without a serial number'}"


@dataclass(frozen=True, slots=True)
class Recording:
    """One recording that a calibration rests on.

    Attributes:
        step: Key of the step.
        recorded_at: When it was begun.
        file: Its name in the recordings' folder.
        sha256: Of its bytes, hexadecimal.
    """

    step: str
    recorded_at: datetime
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
        recordings: The recordings, in order of time.
        landings: In order of time.
        written: When the certificate was computed.
        tool_version, protocol_hash: Of the program that computed it.
        logger_image: CRC of the image that the logger ran in the newest recording, 8 hexadecimal digits; None: it
            ran natively, or nothing was recorded.
        simulated_quantities: Of `QUANTITY_NAMES`, what was never measured: a rehearsal drew it
            from an emulated robot's hidden truth.
        servo_dynamics: Of the servos and directions that were measured, by joint. No drop needs them.
        replacements: Parts of the robot that were replaced, in order of time.
    """

    subject: Subject
    gyros: tuple[GyroCalibration, ...]
    joints: tuple[JointSensors, ...]
    servo_maps: tuple[ServoMap, ...]
    recordings: tuple[Recording, ...]
    landings: tuple[Landing, ...]
    written: datetime
    tool_version: str = __version__
    protocol_hash: str = field(default_factory=PROTOCOL_HASH.hex)
    logger_image: str | None = None
    simulated_quantities: tuple[str, ...] = ()
    servo_dynamics: tuple[MeasuredDynamics, ...] = ()
    replacements: tuple[Replacement, ...] = ()

    __repr__ = describe_fields

    def of_robot(self, model: RobotModel) -> Calibration:
        """Return the calibration of what a robot file has.

        An absent part is absent, whatever was measured of it before; a part that is there, and was absent when this
        was measured, was never measured.
        """
        places = zip(self.gyros, model.imus, strict=True)
        return replace(
            self,
            gyros=tuple(
                gyro
                if gyro.absent == imu.absent
                else by_design(gyro.body, imu.sensor_to_body, absent=imu.absent)
                for gyro, imu in places
            ),
            joints=tuple(
                sensors
                if sensors.absent == model.servos[sensors.joint - 1].absent
                else sensors_by_design(model, sensors.joint)
                for sensors in self.joints
            ),
        )

    def parts_put_on(self, model: RobotModel) -> list[str]:
        """Name the parts that were absent when this was measured, and are in a robot file."""
        then = [gyro.absent for gyro in self.gyros] + [joint.absent for joint in self.joints]
        now = [imu.absent for imu in model.imus] + [servo.absent for servo in model.servos]
        parts = zip((*IMUS, *ANGLES), then, now, strict=True)
        return [part for part, was_absent, is_absent in parts if was_absent and not is_absent]

    @property
    def present_gyros(self) -> list[GyroCalibration]:
        """Those of bodies that have an IMU."""
        return [gyro for gyro in self.gyros if not gyro.absent]

    @property
    def present_joints(self) -> list[JointSensors]:
        """Sensors of the joints that are there."""
        return [sensors for sensors in self.joints if not sensors.absent]

    @property
    def first_logger(self) -> str:
        """Serial number of the logger that the robot had first, hexadecimal: with its name, what the robot is."""
        return next(
            (entry.was for entry in self.replacements if entry.part == LOGGER), self.subject.logger_serial
        )

    def subject_at(self, moment: datetime | None) -> Subject:
        """Return what the robot was at a moment, before the parts that were replaced later; None: what it is."""
        subject = self.subject
        for entry in reversed(self.replacements):
            if moment is not None and entry.at > moment:
                subject = subject.with_part(entry.part, entry.was)
        return subject

    @property
    def specimens(self) -> Specimens:
        """Which specimen of each part was in place when."""
        return Specimens(self.replacements)

    @property
    def last_landing(self) -> datetime | None:
        """When the robot last hit the ground, as far as is known."""
        return self.landings[-1].at if self.landings else None

    def widen(self, factor: float) -> Calibration:
        """Scale all standard deviations of gyros and angle sensors by `factor`."""
        square = factor**2
        return replace(
            self,
            # What gyros have in common stays tied to the axes, which are no worse.
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

    def shortcomings(self, before: datetime | None = None, *, servos: bool = True) -> tuple[Quantity, ...]:
        """Find the quantities that are missing for a drop, or were measured before a landing.

        Args:
            before: Only landings before this time count: those that a recording of that time could know.
            servos: Whether the servos' count; no sensor's reading rests on them.
        """
        return tuple(
            quantity
            for quantity in quantities(self, before)
            if quantity.state != "valid" and (servos or quantity.kind != "servo")
        )


State = Literal["valid", "missing", "stale"]
"""Of a quantity for the next drop; stale: measured before the last landing, which may have changed it."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """One thing that a drop needs to be calibrated.

    Attributes:
        kind: Of `QUANTITY_NAMES`.
        name: For people, such as `bias of body 1`; an axis in it is one of the body, not of the sensor.
        measured_at: When; None: not yet.
        state: For the next drop.
        command: What measures it.
    """

    kind: str
    name: str
    measured_at: datetime | None
    state: State
    command: NextStep

    @property
    def ends_at_landing(self) -> bool:
        """Whether a landing may change it.

        It may change biases, zero points, misalignments, and how a servo's horn sits. A gyro's scale factor is a
        property of its silicon, which survives 10,000 g (PS-MPU-6000A rev. 3.4, section 6.9).
        """
        return self.kind != "scale"


def quantities(calibration: Calibration, before: datetime | None = None) -> tuple[Quantity, ...]:
    """Return everything that a drop needs, in the order in which it is measured.

    `before`: only landings before this time make quantities stale; None: all.
    """
    landings = [landing.at for landing in calibration.landings if before is None or landing.at < before]
    last = max(landings, default=None)
    servo_times = {servo_map.joint: servo_map.recorded_at for servo_map in calibration.servo_maps}
    # One command for all joints where none has a zero that holds now.
    landed = calibration.last_landing

    def quantity(kind: str, name: str, measured_at: datetime | None, *arguments: str) -> Quantity:
        state: State = "valid"
        if measured_at is None:
            state = "missing"
        elif kind != "scale" and _is_stale(measured_at, last):
            state = "stale"
        return Quantity(kind, name, measured_at, state, NextStep(f"calibrate {kind}", arguments))

    # What is not there is not missed.
    gyros, joints = calibration.present_gyros, calibration.present_joints
    none_holds = all(_is_stale(joint.zero_recorded_at, landed) for joint in joints)
    return (
        *(quantity("bias", f"bias of body {gyro.body}", gyro.bias_recorded_at) for gyro in gyros),
        *(
            quantity(
                "zero",
                f"zero point of joint {sensors.joint}",
                sensors.zero_recorded_at,
                *(("--all",) if none_holds else ("--joint", str(sensors.joint))),
            )
            for sensors in joints
        ),
        *(
            quantity(
                "misalignment",
                f"misalignment of body {gyro.body} about {axis}",
                gyro.axes.get(axis),
                *_motion_about(gyro.body, axis),
            )
            for gyro in gyros
            for axis in AXES_OF_BODIES[gyro.body]
        ),
        *(
            quantity(
                "scale",
                f"scale factor {axis} of body {gyro.body}",
                gyro.scaled.get(axis),
                *_motion_about(gyro.body, axis),
            )
            for gyro in gyros
            for axis in "xyz"
        ),
        *(
            quantity("servo", f"servo of joint {joint}", servo_times.get(joint), "--joint", str(joint))
            for joint in (sensors.joint for sensors in joints)
        ),
    )


def _is_stale(measured_at: datetime | None, landing: datetime | None) -> bool:
    """Return whether something was never measured, or no later than the landing."""
    return measured_at is None or (landing is not None and measured_at <= landing)


def _motion_about(body: int, axis: str) -> tuple[str, ...]:
    """Return the arguments of the motion that turns the body about that axis (paper, tab. misal)."""
    # No joint turns a body about z: only the whole robot, by hand, can.
    if axis == "z":
        return ("--turn", "z", "360")
    # Joint 2 turns all bodies about y; about x body 4 turns by joint 3, the others by joint 1.
    joint = 2 if axis == "y" else 3 if body == 4 else 1
    return ("--joint", str(joint))


def with_landing(calibration: Calibration, landing: Landing) -> Calibration:
    """Add a landing, unless one within two minutes of it is known already."""
    # Recording and person may tell of one fall at slightly different times.
    if any(abs((other.at - landing.at).total_seconds()) < 120.0 for other in calibration.landings):
        return calibration
    landings = sorted((*calibration.landings, landing), key=lambda entry: entry.at)
    return replace(calibration, landings=tuple(landings))


def commands_of(shortcomings: Iterable[Quantity]) -> tuple[NextStep, ...]:
    """Return the commands that measure the quantities, each once, in order."""
    return tuple(dict.fromkeys(quantity.command for quantity in shortcomings))


def summarize_shortcomings(shortcomings: Sequence[Quantity]) -> str:
    """Count shortcomings by state, with their names where they are few; empty if there are none."""
    parts = []
    for state, words in (("missing", "missing"), ("stale", "older than the last landing")):
        names = [quantity.name for quantity in shortcomings if quantity.state == state]
        if names:
            names_text = f" ({', '.join(names)})" if len(names) <= _MAX_NAMED else ""
            parts.append(f"{len(names)} calibration{'s' if len(names) > 1 else ''} {words}{names_text}")
    return ", ".join(parts)


def measured_in_future(calibration: Calibration, now: datetime) -> list[Quantity]:
    """Find the quantities that were measured later than now: a clock was wrong then, or is now."""
    return [
        quantity
        for quantity in quantities(calibration)
        if quantity.measured_at is not None and quantity.measured_at > now + CLOCKS_DIFFER
    ]


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


def exchanged_imus(subject: Subject, who_am_i: str) -> list[int]:
    """Return the bodies whose IMU says to be another part than the one that was calibrated.

    `who_am_i` is as `Subject.who_am_i`; 00 where an IMU does not answer.
    """
    pairs = zip(bytes.fromhex(subject.who_am_i), bytes.fromhex(who_am_i), strict=True)
    return [body for body, (calibrated, present) in enumerate(pairs, 1) if calibrated != present]


def in_words(names: Sequence[str]) -> str:
    """Some of `QUANTITY_NAMES` for people, such as `zero points, maps of the servos`."""
    return ", ".join(QUANTITY_NAMES[name] for name in names)
