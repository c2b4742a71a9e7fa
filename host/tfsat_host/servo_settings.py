"""How the joints' servos turn pulses into angles: settings as the board holds them, its rules, and their file.

Whole microseconds, nanoseconds per degree and 0.01 deg. The board repeats the rules on what it receives
(firmware/arduino_sequencer/src/core/settings.cpp): which settings a servo can follow, joint by joint in its order; and
that a maneuver stays within the joints' limits, or ARM refuses. The file is TOML:

    format = 1
    frame_ms = 20.0            # from pulse to pulse, 5 to 20
    moving_at_once = 1         # joints that the supply can move at the same time, 1 to 3; left out: 1

    [[servo]]                  # one for each joint
    joint = 1
    zero_us = 1000             # pulse that holds 0 deg; the board keeps whole microseconds
    us_per_deg = 11.111        # change of the pulse for each degree, to 0.001
    reversed = false           # true: shorter pulses open the joint
    limits_deg = [0.0, 90.0]   # what may be commanded, to 0.01

A key that is not known is an error: a misspelt limit must not be silently ignored.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from pathlib import Path
from typing import Final

from tfsat_host.config import ConfigKind, Fault, Table, format_config, parse_config, read_config
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.maneuver import TimedStroke, count_moving
from tfsat_host.maneuver.maneuver import place_of_stroke
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import limits
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.units import CDEG_PER_DEG, exact

NOTHING_CHANGED = "Nothing was sent to the robot; its settings are as they were."
NS_PER_US = 1000
FRAME: Final = limits.JOINT_COUNT
"""The index at which the board reports a frame that makes no sense; joints come before it, from 0."""
MOVING: Final = FRAME + 1
"""The index of a number of joints that makes no sense."""


class SettingsDefect(StrEnum):
    """Stable names, as in `error.code` of `--json`; the others are config's `Fault`s."""

    FRAME_RANGE = "frame-range"
    SLOPE_RANGE = "slope-range"
    JOINT_LIMITS = "joint-limits"
    MOVING_RANGE = "moving-range"
    PULSE_RANGE = "pulse-range"
    FILE_JOINTS = "file-joints"


class SettingsError(TfsatError):
    """The settings' file cannot be understood, or no servo can follow it; `code` is a SettingsDefect or a Fault."""


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """The settings of all servos.

    Attributes:
        frame_us: From pulse to pulse.
        servos: Of joints 1 to 3, in order.
        moving_at_once: Joints that the supply can move at the same time.
    """

    frame_us: int
    servos: tuple[ServoSetting, ...]
    moving_at_once: int = limits.MOVING_AT_ONCE

    def of(self, joint: int) -> ServoSetting:
        """Return the servo setting of a joint, 1 to 3."""
        return self.servos[joint - 1]


def pulse_ns(servo: ServoSetting, angle_cdeg: int) -> int:
    """Pulse width that holds an angle from 0 deg, as the board computes it: the fraction of a nanosecond is cut."""
    change_ns = angle_cdeg * servo.ns_per_deg // CDEG_PER_DEG
    return servo.zero_us * NS_PER_US + (-change_ns if servo.reversed else change_ns)


_FACTORY_SERVO = ServoSetting(
    zero_us=limits.SERVO_FACTORY_ZERO_US,
    ns_per_deg=limits.SERVO_FACTORY_NS_PER_DEG,
    reversed=0,
    min_cdeg=limits.JOINT_ANGLE_MIN_CDEG,
    max_cdeg=limits.JOINT_ANGLE_MAX_CDEG,
)
FACTORY = ServoSettings(limits.SERVO_FRAME_US, (_FACTORY_SERVO,) * limits.JOINT_COUNT)
"""What a board uses that never received settings."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What makes no sense.

    Attributes:
        code: Which rule.
        index: Of the joint from 0, or FRAME: what the board's refusal carries as its detail.
        key: Of the file's entry that is to be corrected.
        problem: What is wrong, to follow the name of the entry.
        cure: What to do.
    """

    code: SettingsDefect
    index: int
    key: str
    problem: str
    cure: str


def find_defect(settings: ServoSettings) -> Finding | None:
    """Find the first defect that the board would refuse; None: it would accept the settings."""
    return next(_defects(settings), None)


def _defects(settings: ServoSettings) -> Iterator[Finding]:
    # In the order of the board's own check: its refusal names the first defect that it meets.
    for index, servo in enumerate(settings.servos):
        if not limits.SERVO_NS_PER_DEG_MIN <= servo.ns_per_deg <= limits.SERVO_NS_PER_DEG_MAX:
            least, most = limits.SERVO_NS_PER_DEG_MIN / NS_PER_US, limits.SERVO_NS_PER_DEG_MAX / NS_PER_US
            yield Finding(
                SettingsDefect.SLOPE_RANGE,
                index,
                "us_per_deg",
                f"{servo.ns_per_deg / NS_PER_US:g} us/deg is outside {least:g} to {most:g} us/deg",
                "Give the change of pulse width for one degree, without a sign (11.111 for a usual servo); "
                "reversed = true turns the direction.",
            )
        # The range must begin at the start pose, from which every maneuver counts.
        if not limits.JOINT_ANGLE_MIN_CDEG == servo.min_cdeg < servo.max_cdeg <= limits.JOINT_ANGLE_MAX_CDEG:
            low, high = limits.JOINT_ANGLE_MIN_CDEG / CDEG_PER_DEG, limits.JOINT_ANGLE_MAX_CDEG / CDEG_PER_DEG
            yield Finding(
                SettingsDefect.JOINT_LIMITS,
                index,
                "limits_deg",
                f"{limits_text(servo)} deg cannot be a joint's range: it begins at {low:g}, the start pose, "
                f"and ends above it, at {high:g} at most",
                f"Write limits_deg = [{low:g}, {high:g}], or a smaller second number.",
            )
        # Pulses are linear in the angle, so the ends of the range bound all of them.
        for angle_cdeg in (servo.min_cdeg, servo.max_cdeg):
            width_us = pulse_ns(servo, angle_cdeg) / NS_PER_US
            if not limits.SERVO_PULSE_MIN_US <= width_us <= limits.SERVO_PULSE_MAX_US:
                yield Finding(
                    SettingsDefect.PULSE_RANGE,
                    index,
                    "zero_us" if angle_cdeg == 0 else "us_per_deg",
                    f"{angle_cdeg / CDEG_PER_DEG:g} deg would need a pulse of {width_us:.10g} us, "
                    f"outside {limits.SERVO_PULSE_MIN_US} to {limits.SERVO_PULSE_MAX_US} us",
                    "Correct zero_us, us_per_deg or reversed, or narrow limits_deg: "
                    "pulses must stay within what a servo takes over the whole range.",
                )
    if not limits.SERVO_FRAME_MIN_US <= settings.frame_us <= limits.SERVO_FRAME_MAX_US:
        least, most = limits.SERVO_FRAME_MIN_US / NS_PER_US, limits.SERVO_FRAME_MAX_US / NS_PER_US
        yield Finding(
            SettingsDefect.FRAME_RANGE,
            FRAME,
            "frame_ms",
            f"{settings.frame_us / NS_PER_US:g} ms is outside {least:g} to {most:g} ms",
            f"Give {most:g} for an analog servo; down to {least:g} for a digital one whose data sheet allows it.",
        )
    if not 1 <= settings.moving_at_once <= limits.JOINT_COUNT:
        yield Finding(
            SettingsDefect.MOVING_RANGE,
            MOVING,
            "moving_at_once",
            f"{settings.moving_at_once} joints cannot move at once; the robot has {limits.JOINT_COUNT}",
            f"Give 1, or up to {limits.JOINT_COUNT} where the supply was tried with so many servos moving.",
        )


def limits_text(servo: ServoSetting) -> str:
    """Format a servo's limits without the unit (deg), such as `0 to 90`."""
    return f"{servo.min_cdeg / CDEG_PER_DEG:g} to {servo.max_cdeg / CDEG_PER_DEG:g}"


@dataclass(frozen=True, slots=True)
class Misfit:
    """Why the board would not arm with a maneuver, by its servo settings.

    Attributes:
        code: Of the board's refusal.
        words: What does not fit, and what the settings allow; to end a sentence.
        stroke: Number of the stroke at fault, from 1.
    """

    code: ErrorCode
    words: str
    stroke: int


def find_misfit(strokes: Sequence[TimedStroke], settings: ServoSettings) -> Misfit | None:
    """Find the first stroke that moves too many joints at once or leaves its joint's limits; None: none does."""
    return next(chain(_too_many_moving(strokes, settings), _beyond_limits(strokes, settings)), None)


def _too_many_moving(strokes: Sequence[TimedStroke], settings: ServoSettings) -> Iterator[Misfit]:
    for number, moving in enumerate(count_moving(strokes), 1):
        if moving > settings.moving_at_once:
            yield Misfit(
                ErrorCode.TOO_MANY_MOVING,
                f"stroke {number} makes {moving} joints move at once, but the servo settings allow "
                f"moving_at_once = {settings.moving_at_once}",
                number,
            )


def _beyond_limits(strokes: Sequence[TimedStroke], settings: ServoSettings) -> Iterator[Misfit]:
    # Strokes are relative: the limits hold for what they add up to, from the start pose at 0 deg.
    pose_cdeg = dict.fromkeys(range(1, len(settings.servos) + 1), 0)
    for number, stroke in enumerate(strokes, 1):
        pose_cdeg[stroke.joint] += stroke.angle_cdeg
        servo, angle_cdeg = settings.of(stroke.joint), pose_cdeg[stroke.joint]
        if not servo.min_cdeg <= angle_cdeg <= servo.max_cdeg:
            yield Misfit(
                ErrorCode.SETTINGS_DO_NOT_FIT,
                f"stroke {number} takes joint {stroke.joint} to {angle_cdeg / CDEG_PER_DEG:g} deg, "
                f"but its servo settings allow {limits_text(servo)} deg",
                number,
            )


_MISFIT_REMEDIES = {
    ErrorCode.SETTINGS_DO_NOT_FIT: "Choose smaller angles, or correct the limits. They are shown by: ",
    ErrorCode.TOO_MANY_MOVING: "Move one joint after the other; or, where the supply was tried with so many servos "
    "moving, raise moving_at_once. It is shown by: ",
}


def insist_on_fit(strokes: Sequence[TimedStroke], settings: ServoSettings, file: Path | None = None) -> None:
    """Raises RefusedError for a maneuver that the board would store and refuse to arm by its servo settings.

    `file`: the maneuver's, which the error names with the line of the stroke at fault.
    """
    misfit = find_misfit(strokes, settings)
    if misfit is not None:
        meaning = (
            "The servo would be driven against its stop"
            if misfit.code == ErrorCode.SETTINGS_DO_NOT_FIT
            else "The supply may dip, and a servo or the board with it"
        )
        place = "" if file is None else f"{place_of_stroke(file, misfit.stroke)}: "
        raise RefusedError(
            what=f"{place}{misfit.words[:1].upper()}{misfit.words[1:]}.",
            meaning=f"{meaning}, so the board would refuse to arm. Nothing was sent.",
            next_step=Advice(_MISFIT_REMEDIES[misfit.code], NextStep("upload-servos", ("--show",))),
            code=misfit.code,
        )


FORMAT: Final = 1
_US_PER_MS = 1000
_RESOLVED = {
    "frame_ms": (_US_PER_MS, "ms", "milliseconds, such as 20"),
    "zero_us": (1, "us", "the pulse width at 0 deg in microseconds, such as 1000"),
    "us_per_deg": (NS_PER_US, "us per deg", "microseconds for each degree, such as 11.111"),
    "limits_deg": (CDEG_PER_DEG, "deg", "two numbers in degrees, such as [0, 90]"),
}
"""Of each entry with a unit: how many steps of the board's one of it has, its name, and what is wanted."""
_MAX_VALUE = 1e9
"""Beyond every unit's range, and far from where a float's steps are larger than what the board resolves."""
_KIND = ConfigKind(
    name="file of servo settings",
    error=SettingsError,
    meaning=NOTHING_CHANGED,
    cure=Advice("For a file to start from: ", NextStep("upload-servos", ("--show", "--out", "servos.toml"))),
    format=("format", FORMAT),
    codes={Fault.NOT_TEXT: Fault.UNREADABLE},
    bytes_max=1_000_000,
)


def read_settings_file(path: Path) -> tuple[ServoSettings, list[str]]:
    """Reads and checks a settings' file; also what was rounded, one sentence each.

    Raises:
        SettingsError: the file cannot be read or understood, or no servo can follow it; names file, line
            and cure.
    """
    return _settings(read_config(path, _KIND))


def parse_settings(text: str, *, source: str = "settings") -> tuple[ServoSettings, list[str]]:
    """Parse the settings in a file's text, and list what was rounded; errors name the file `source`.

    Raises:
        SettingsError: syntax, format, keys, types, joints, or a rule of the board's.
    """
    return _settings(parse_config(text, source, _KIND))


def format_settings(settings: ServoSettings) -> str:
    """Format a settings file's text; `parse_settings` gives the same settings back."""
    servos = [
        {
            "joint": joint,
            "zero_us": servo.zero_us,
            "us_per_deg": servo.ns_per_deg / NS_PER_US,
            "reversed": bool(servo.reversed),
            "limits_deg": [servo.min_cdeg / CDEG_PER_DEG, servo.max_cdeg / CDEG_PER_DEG],
        }
        for joint, servo in enumerate(settings.servos, 1)
    ]
    return format_config(
        {
            "format": FORMAT,
            "frame_ms": settings.frame_us / _US_PER_MS,
            "moving_at_once": settings.moving_at_once,
            "servo": servos,
        },
        heading="tfsat servo settings: how the joints' servos turn pulses into angles",
        comments={
            "frame_ms": "from pulse to pulse",
            "moving_at_once": "joints that the supply can move at the same time",
            "zero_us": "pulse that holds 0 deg",
            "us_per_deg": "change of the pulse for each degree",
            "reversed": "true: shorter pulses open the joint",
            "limits_deg": "what may be commanded",
        },
    )


def _settings(top: Table) -> tuple[ServoSettings, list[str]]:
    top.only("format frame_ms moving_at_once servo")
    notices: list[str] = []
    (frame_us,) = _whole(top, "", "frame_ms", notices)
    # Files of 0.2.0 have no such entry: one joint at a time.
    moving_at_once = limits.MOVING_AT_ONCE
    if top.has("moving_at_once"):
        moving_at_once = top.integer("moving_at_once", requirement="a number of joints: 1, 2 or 3")
    keys = "joint zero_us us_per_deg reversed limits_deg"
    entries = top.tables_by_number(
        "servo", "joint", limits.JOINT_COUNT, keys, code=SettingsDefect.FILE_JOINTS
    )
    servos = [_servo(entry, f"joint {joint}: ", notices) for joint, entry in entries.items()]
    settings = ServoSettings(frame_us, tuple(servos), moving_at_once)
    finding = find_defect(settings)
    # From the board's index back to the entry of the file, whose line the error names.
    if finding is not None:
        entry = top if finding.index >= FRAME else entries[finding.index + 1]
        entry.fail(finding.key, finding.problem, finding.cure, finding.code)
    return settings, notices


def _servo(entry: Table, place: str, notices: list[str]) -> ServoSetting:
    (zero_us,) = _whole(entry, place, "zero_us", notices)
    (ns_per_deg,) = _whole(entry, place, "us_per_deg", notices)
    reversed_ = entry.flag("reversed", "false, or true where shorter pulses open the joint")
    low_cdeg, high_cdeg = _whole(entry, place, "limits_deg", notices, 2)
    return ServoSetting(zero_us, ns_per_deg, int(reversed_), low_cdeg, high_cdeg)


def _whole(entry: Table, place: str, key: str, notices: list[str], *shape: int) -> list[int]:
    """Numbers in what the board resolves, to the nearest whole (half to even), with a notice of what was rounded."""
    scale, unit, expected_format = _RESOLVED[key]
    whole_numbers = []
    for value in entry.numbers(key, *shape, requirement=expected_format):
        if abs(value) > _MAX_VALUE:
            entry.fail(key, f"{value:g} is beyond every servo", f"Give `{key}` {expected_format}.")
        # In exact decimals: 11.111 us/deg are 11111 ns/deg, and nothing is said to be rounded.
        exactly = exact(value) * scale
        whole_numbers.append(round(exactly))
        if whole_numbers[-1] != exactly:
            notices.append(
                f"{place}{key} was rounded from {value} to {whole_numbers[-1] / scale:g} {unit}: "
                f"the board resolves {1 / scale:g} {unit}."
            )
    return whole_numbers
