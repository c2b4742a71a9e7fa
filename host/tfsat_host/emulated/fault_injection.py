"""What can break on the emulated robot, where it breaks, at any virtual time; and how it heals."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, Literal, get_args

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.library import EmulationError, read_bytes, vector
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, IMUS_PER_BUS, JOINT_COUNT, SWITCH_COUNT
from tfsat_host.robot import RobotModel

ImuFault = Literal["dead", "frozen", "saturated", "swapped"]
"""An IMU does not answer; its registers stand still; its gyros fill their converters at a tenth of the range (the
drive loop has lost its gain control: rates come ten times too large); its plug is exchanged with another's."""
AngleSensorFault = Literal["dead", "frozen", "turned"]
"""A wire is open, and a pull-down makes it read 0; the output stands still; the magnet has slipped on its axis."""
ServoFault = Literal["dead", "slow", "reversed"]
"""Its motor does not turn; it reaches a quarter of its rate; its pulses mean the angle mirrored at the reference."""
SwitchFault = Literal["stuck-closed", "stuck-open"]
"""What its wire shows both boards, whatever the releaser does."""
ClockedBoard = Literal["sequencer", "logger"]

WirePart = Literal["angle", "servo", "sequencer-switch", "logger-switch", "stroke-line"]
"""Wires of one kind, as api.h numbers them: which source each pin of theirs is connected to."""
_PINS = (ANGLE_SENSOR_COUNT, JOINT_COUNT, SWITCH_COUNT, SWITCH_COUNT, 1)

BUS_COUNT = IMU_COUNT // IMUS_PER_BUS
MAX_PPM = 20_000.0
"""A board's clock is off by no more (board_clock.h)."""
MAX_BATTERY_OHM = 10.0
_IMU_KINDS = ("dead", "frozen", "saturated")  # from 1 on as api.h numbers them, like all of these
_ANGLE_SENSOR_KINDS = ("dead", "frozen")


class Faults:
    """Breaks and heals one robot. Valid as long as the robot is.

    Each call takes effect at the present virtual time and replaces what the same part had before; None heals it.
    Every method raises EmulationError, and changes nothing, for a part or a kind that does not exist.
    """

    def __init__(self, library: Any, robot: Any, model: RobotModel) -> None:
        self._library = library
        self._robot = robot
        self._model = model
        self._swapped: dict[int, int] = {}
        self._unplug_absent()

    def imu(self, body: int, kind: ImuFault | None, other: int | None = None) -> None:
        """Set or clear (None) a fault of the IMU of a body (1 to 4).

        "swapped" exchanges its plug with that of body `other`.
        """
        _require("body", body, IMU_COUNT)
        _require_kind("IMUs", kind, get_args(ImuFault))
        # A swap takes another body, every other kind none.
        if (kind == "swapped") != (other is not None) or other == body:
            raise _refusal(
                "An IMU is swapped with that of another body, and nothing else takes a second body"
            )
        if other is not None:
            _require("body", other, IMU_COUNT)
        # One fault at a time: undo an earlier swap, then set the new number, of which 0 heals.
        self._plug_back(body)
        self._library.tfsat_fault_imu(
            self._robot, body - 1, 1 + _IMU_KINDS.index(kind) if kind in _IMU_KINDS else 0
        )
        if other is not None:
            # The other plug may be swapped with a third: start from plugs in their own places.
            self._plug_back(other)
            self._library.tfsat_swap_imus(self._robot, body - 1, other - 1)
            self._swapped |= {body: other, other: body}

    def glitch(self, body: int) -> None:
        """Disturb the next transfer with the IMU of a body (1 to 4), so that it is not acknowledged."""
        _require("body", body, IMU_COUNT)
        self._library.tfsat_glitch_imu(self._robot, body - 1)

    def bus(self, bus: int, stuck: bool) -> None:
        """Hold an I2C bus low by a slave, or release it (bus 1: IMUs 1 and 2; bus 2: IMUs 3 and 4).

        The nine clocks that usually free a bus do not free this one. The logger's next power-up does.
        """
        _require("bus", bus, BUS_COUNT)
        self._library.tfsat_fault_bus(self._robot, bus - 1, int(stuck))

    def angle_sensor(
        self, index: int, kind: AngleSensorFault | None, turned_deg: float | None = None
    ) -> None:
        """Set or clear (None) a fault of an angle sensor (1 to 6, in the log's order: two per joint).

        For "turned": `turned_deg` is the angle by which the magnet has slipped, in the sensor's sense.
        """
        _require("angle sensor", index, ANGLE_SENSOR_COUNT)
        _require_kind("angle sensors", kind, get_args(AngleSensorFault))
        if (kind == "turned") != (turned_deg is not None) or not math.isfinite(turned_deg or 0.0):
            raise _refusal("A turned magnet has an angle, and nothing else takes one")
        # Set both number and slip each time, so that one kind of fault clears the other.
        number = 1 + _ANGLE_SENSOR_KINDS.index(kind) if kind in _ANGLE_SENSOR_KINDS else 0
        self._library.tfsat_fault_angle_sensor(self._robot, index - 1, number)
        self._library.tfsat_slip_magnet(self._robot, index - 1, math.radians(turned_deg or 0.0))

    def gyro_bias_step(self, body: int, step_rad_s: FloatArray) -> None:
        """Add a permanent bias step to the gyro of a body (1 to 4): (3,), in the gyro's own axes."""
        _require("body", body, IMU_COUNT)
        self._library.tfsat_step_gyro_bias(self._robot, body - 1, vector(step_rad_s))

    def servo(self, joint: int, kind: ServoFault | None) -> None:
        """Set or clear a fault of the servo of a joint (1 to 3)."""
        _require("joint", joint, JOINT_COUNT)
        self._library.tfsat_fault_servo(self._robot, joint - 1, _number("servos", kind, get_args(ServoFault)))

    def battery(self, resistance_ohm: float | None) -> None:
        """Set the resistance of the battery that servos and sequencer share; None: a sound one's (supply.h)."""
        if resistance_ohm is not None and not 0.0 <= resistance_ohm <= MAX_BATTERY_OHM:
            raise _refusal(f"No battery has {resistance_ohm:g} ohm: 0 to {MAX_BATTERY_OHM:g}")
        self._library.tfsat_set_battery_resistance(
            self._robot, -1.0 if resistance_ohm is None else resistance_ohm
        )

    def switch(self, index: int, kind: SwitchFault | None) -> None:
        """Set or clear a fault of a release switch (1 or 2)."""
        _require("release switch", index, SWITCH_COUNT)
        self._library.tfsat_fault_switch(
            self._robot, index - 1, _number("switches", kind, get_args(SwitchFault))
        )

    def connect(self, part: WirePart, pin: int, source: int | None) -> None:
        """Connect a pin to a source of its kind, both numbered from 1, or to nothing (None)."""
        _require_kind("wires", part, get_args(WirePart))
        wires = get_args(WirePart).index(part)
        for number in (pin, source):
            if number is not None:
                _require(f"{part} wire", number, _PINS[wires])
        self._library.tfsat_connect(self._robot, wires, pin - 1, -1 if source is None else source - 1)

    def bounce(self, duration_us: int | None) -> None:
        """Set how long both switches' contacts bounce at the next release.

        The default, None, is about the data sheet's 1.5 ms.
        """
        if duration_us is not None and not 0 < duration_us <= 1_000_000:
            raise _refusal(f"Contacts do not bounce for {duration_us} us: more than 0, at most 1,000,000")
        self._library.tfsat_set_bounce(self._robot, duration_us or 0)

    def card_stalls(self, stall_us: int | None, every_us: int = 2_000_000) -> None:
        """Make the card stall: single blocks keep it busy for `stall_us` now and then; None ends the stalls.

        The ring buffer bridges `ring_blocks`; the logger takes a card that is busy for more than 1 s for
        gone. `every_us` is the mean interval between stalls, varied by half of it; at 0 every block stalls.
        """
        if stall_us is not None and not (0 < stall_us <= 100_000_000 and 0 <= every_us <= 1_000_000_000):
            raise _refusal(f"A card does not stall for {stall_us} us each {every_us} us")
        self._library.tfsat_card_stalls(self._robot, stall_us or 0, every_us)

    def clock(self, board: ClockedBoard, ppm: float) -> None:
        """Set a board's clock error from now on: positive runs fast, up to 20,000 ppm (2 %) either way.

        It replaces the error that the robot's imperfections state.
        """
        boards = get_args(ClockedBoard)
        if board not in boards:
            raise _refusal(f"There is no board {board!r}: {', '.join(boards)}")
        if self._library.tfsat_set_clock(self._robot, boards.index(board), ppm) != 0:
            raise _refusal(f"A board's clock cannot be off by {ppm:g} ppm, only by {MAX_PPM:g} either way")

    def heal(self) -> None:
        """Everything that these methods break is well again; the clocks stay as they are, and biases that stepped."""
        for body in range(1, IMU_COUNT + 1):
            self.imu(body, None)
        for bus in range(1, BUS_COUNT + 1):
            self.bus(bus, False)
        for index in range(1, ANGLE_SENSOR_COUNT + 1):
            self.angle_sensor(index, None)
        for joint in range(1, JOINT_COUNT + 1):
            self.servo(joint, None)
        self.battery(None)
        for index in range(1, SWITCH_COUNT + 1):
            self.switch(index, None)
        for part, count in zip(get_args(WirePart), _PINS, strict=True):
            for pin in range(1, count + 1):
                self.connect(part, pin, pin)
        self.bounce(None)
        self.card_stalls(None)
        self._unplug_absent()

    def _unplug_absent(self) -> None:
        """Silence the IMUs that the robot does not have; a pin without an angle sensor reads anything."""
        for body, imu in enumerate(self._model.imus, 1):
            if imu.absent:
                self.imu(body, "dead")

    def _plug_back(self, body: int) -> None:
        other = self._swapped.pop(body, None)
        if other is not None:
            del self._swapped[other]
            # Exchange twice and each plug is back in its place.
            self._library.tfsat_swap_imus(self._robot, body - 1, other - 1)


def _number(parts: str, kind: str | None, kinds: tuple[str, ...]) -> int:
    """Return the number of a fault kind as api.h counts them: 0 means no fault."""
    _require_kind(parts, kind, kinds)
    return 0 if kind is None else 1 + kinds.index(kind)


def _require(part: str, number: int, count: int) -> None:
    if not 1 <= number <= count:
        raise _refusal(f"There is no {part} {number}: 1 to {count}")


def _require_kind(parts: str, kind: str | None, kinds: tuple[str, ...]) -> None:
    if kind is not None and kind not in kinds:
        raise _refusal(f"There is no such fault of {parts} as {kind!r}: {', '.join(kinds)}")


def _refusal(what: str) -> EmulationError:
    return EmulationError(
        what=f"{what}.", meaning="Nothing was changed.", next_step="docs/emulator.md, Faults."
    )


# The greatest uint32, more free blocks than any card has: the card's own room is what limits.
NO_FOREIGN_FILES = 2**32 - 1


class CardDefect(IntEnum):
    """What can be wrong with a card, as api.h numbers it."""

    NONE = 0
    WRITE_PROTECTED = 1
    UNREADABLE = 2
    FAILING = 3


class CardSlot:
    """The logger's card slot. Valid as long as the robot is."""

    def __init__(self, library: Any, robot: Any) -> None:
        self._library = library
        self._robot = robot

    def files(self) -> dict[int, bytes]:
        """Return the card's recordings by number, as a reader would find them now, even on a defective card."""
        files = {}
        number = 0
        # Gives the first number from there on; 0 ends the list.
        while number := self._library.tfsat_card_next_file(self._robot, number + 1):
            size = self._library.tfsat_card_file_size(self._robot, number)
            files[number] = read_bytes(size, self._library.tfsat_card_file_read, self._robot, number)
        return files

    def put(self, number: int, data: bytes) -> None:
        """Put a recording of whole blocks on the card, as another computer would."""
        self._library.tfsat_card_put_file(self._robot, number, data, len(data))

    def remove(self) -> None:
        """Takes the card out, a recording in full swing included."""
        self._library.tfsat_card_set_present(self._robot, 0)

    def insert(self, *, mount_us: int = 0) -> None:
        """Pushes a card with the same recordings in, with nothing else on it and nothing wrong with it.

        Counting its free room takes `mount_us`.
        """
        self._library.tfsat_card_set_mount(self._robot, mount_us)
        self.spoil(CardDefect.NONE)
        self.fill(NO_FOREIGN_FILES)
        self._library.tfsat_card_set_present(self._robot, 1)

    def spoil(self, defect: CardDefect) -> None:
        """Give the card a defect from now on."""
        self._library.tfsat_card_set_defect(self._robot, defect)

    def fill(self, free_blocks: int) -> None:
        """Files of others leave it so many free blocks, or as many as there are."""
        self._library.tfsat_card_fill(self._robot, free_blocks)
