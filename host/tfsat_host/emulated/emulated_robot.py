"""One emulated robot, in virtual time: its boards' cables and what a person can do to it."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.build import Progress, Variant, ensure_built
from tfsat_host.emulated.fault_injection import CardSlot, Faults
from tfsat_host.emulated.imperfections import Imperfections, draw
from tfsat_host.emulated.library import (
    TRUTH_COLUMNS,
    interface,
    load_library,
    read_bytes,
    require_pulses,
    robot_config,
    vector,
)
from tfsat_host.emulated.library import BoardIndex as BoardIndex
from tfsat_host.emulated.library import EmulationError as EmulationError
from tfsat_host.emulated.library import Reset as Reset
from tfsat_host.emulated.manual_motion import OperatorMotion
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT, SWITCH_COUNT
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.robot.absent_parts import fill_places

EEPROM_BYTES = 1024
US_PER_S = 1_000_000
DEFAULT_SEED = 1
SETTLE_US = 300_000
"""After power-up: both boards have started, the gyros are awake, USB is enumerated."""
_READ_BYTES = 4096
FALL_S = 2.5
"""Free fall of the drop tower (paper, tab. cosmotorre)."""
PUSH_OFF_M_S = (0.0, 0.0, -0.04)
"""The switches push the robot off (paper, sec. release): its center of mass, in the world."""


class EmulatedRobot:
    """The robot on the bench: powered, cables plugged, hanging in the releaser.

    Time is virtual, in microseconds since the robot was made, and passes only in `advance`.

    Attributes:
        card_slot: The logger's card, and what a person can do to it.
        faults: What can break, and heal, at any time.
        operator: What an operator can do to the robot beyond `hold` and the exact `swing`.

    Args:
        model: The bodies; the drop tower robot by default.
        imperfections: The sensors' hidden errors; drawn from `seed` by default.
        seed: For noise and contact bounce; None is DEFAULT_SEED.
        session_seed: For the logger's session ids, which tell recordings apart. By default a number of
            the operating system's, unless a `seed` asks for what can be repeated.
        hex_path: The sequencer's image to run in an emulated ATmega32U4; None runs its core natively.
        eeprom: The sequencer's EEPROM; erased by default.
        logger_memory: The logger's stored settings, as `logger_memory()` gave them; none by default.
        variant: Which build of the library to use.
        progress: Hears that the library is being built.

    Raises:
        BuildError: the library cannot be built.
        EmulationError: the image, the model or the imperfections are refused.
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        imperfections: Imperfections | None = None,
        seed: int | None = None,
        session_seed: int | None = None,
        hex_path: Path | None = None,
        eeprom: bytes | None = None,
        logger_memory: bytes | None = None,
        variant: Variant | None = None,
        progress: Progress = lambda _: None,
    ) -> None:
        self.model = fill_places(model or load_robot())
        require_pulses(self.model)
        # Only an image needs the emulated ATmega32U4, and with it libsimavr.
        chosen = variant or Variant(avr=hex_path is not None)
        self._library = load_library(ensure_built(chosen, progress))
        # Session ids tell recordings apart: repeat them only for a caller who asked for a repeatable run.
        if session_seed is None:
            session_seed = secrets.randbits(64) if seed is None else seed
        drawn_from = DEFAULT_SEED if seed is None else seed
        self.imperfections = imperfections or draw(drawn_from)
        config = robot_config(self.model, self.imperfections, drawn_from, session_seed)
        error = interface().new("char[512]")
        path = interface().NULL if hex_path is None else str(hex_path).encode()
        self._robot = self._library.tfsat_robot_new(config, path, error, len(error))
        if not self._robot:
            raise EmulationError(
                what=f"The emulated robot cannot start: {_text(error)}.",
                meaning="Nothing was run.",
                next_step="Check the image (make firmware), the robot file or the imperfections.",
            )
        if eeprom is not None:
            self._library.tfsat_eeprom_set(self._robot, eeprom, len(eeprom))
        if logger_memory is not None:
            self._library.tfsat_logger_memory_set(self._robot, logger_memory, len(logger_memory))
        # One buffer for good: reads are short and come with each step of virtual time.
        self._buffer = interface().new("uint8_t[]", _READ_BYTES)
        self.card_slot = CardSlot(self._library, self._robot)
        self.faults = Faults(self._library, self._robot, self.model)
        self.operator = OperatorMotion(self._library, self._robot)
        # Boards are off until they get power; both have started after SETTLE_US of virtual time.
        for board in BoardIndex:
            self.set_power(board, True)
            self.set_cable(board, True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Frees the robot; it cannot be used afterwards."""
        if self._robot:
            self._library.tfsat_robot_free(self._robot)
            self._robot = None

    @property
    def now_us(self) -> int:
        """Virtual time."""
        return int(self._library.tfsat_now_us(self._robot))

    def advance(self, duration_us: int) -> None:
        """Lets virtual time pass. Raises EmulationError if the emulated processor crashes."""
        if self._library.tfsat_advance_to(self._robot, self.now_us + duration_us) != 0:
            raise self._crash()

    def wait(self, duration_s: float) -> None:
        """Minutes in which nothing happens, compressed: the dies get warmer and the gyros' biases wander on.

        Virtual time stands and neither firmware runs: the next sample shows what changed. ValueError below zero.
        """
        if not duration_s >= 0.0:
            raise ValueError(f"{duration_s} s cannot be waited")
        self._library.tfsat_pass_slowly(self._robot, duration_s)

    def write(self, board: BoardIndex, data: bytes) -> int:
        """Offers bytes to a board; returns how many it took."""
        return int(self._library.tfsat_write(self._robot, board, data, len(data)))

    def read(self, board: BoardIndex) -> bytes:
        """Takes what a board has sent."""
        size = self._library.tfsat_read(self._robot, board, self._buffer, len(self._buffer))
        return bytes(interface().buffer(self._buffer, size))

    def read_by(self, board: BoardIndex, t_us: int, step_us: int) -> bytes:
        """Read what a board has sent, advancing time in steps until a byte arrives or `t_us` is reached.

        Raises EmulationError if the emulated sequencer crashes.
        """
        buffer = self._buffer
        size = self._library.tfsat_read_by(self._robot, board, t_us, step_us, buffer, len(buffer))
        # The library has no exceptions: a negative size says that the processor crashed.
        if size < 0:
            raise self._crash()
        return bytes(interface().buffer(buffer, size))

    def _crash(self) -> EmulationError:
        return EmulationError(
            what=f"The emulated sequencer crashed: {_text(self._library.tfsat_crash(self._robot))}.",
            meaning="The real board would have hung or reset here.",
            next_step="This is a bug of the firmware: keep the command line and report it.",
        )

    def set_power(self, board: BoardIndex, on: bool) -> None:
        """Switches a board's supply. The logger's takes its card's with it."""
        self._library.tfsat_set_power(self._robot, board, int(on))

    def set_cable(self, board: BoardIndex, plugged: bool) -> None:
        """Plugs or pulls a USB cable; the boards have their own supply."""
        self._library.tfsat_set_cable(self._robot, board, int(plugged))

    def set_port(self, is_open: bool) -> None:
        """Opens or closes the sequencer's serial port as a program on the host does (DTR); open at first."""
        self._library.tfsat_set_port(self._robot, int(is_open))

    def reset(self, cause: Reset) -> None:
        """Restarts the sequencer with its supply on; nothing happens to a board without power."""
        self._library.tfsat_reset(self._robot, cause)

    def eeprom(self) -> bytes:
        """Return the contents of the sequencer's EEPROM."""
        return read_bytes(EEPROM_BYTES, self._library.tfsat_eeprom_get, self._robot)

    @property
    def eeprom_writes(self) -> int:
        """Changes of the EEPROM by the board since the robot was made."""
        return int(self._library.tfsat_eeprom_writes(self._robot))

    def logger_memory(self) -> bytes:
        """Return the logger's nonvolatile memory: its stored settings."""
        size = self._library.tfsat_logger_memory_bytes(self._robot)
        return read_bytes(size, self._library.tfsat_logger_memory_get, self._robot)

    def card(self) -> bytes:
        """Return the newest recording on the card, as a reader would find it now."""
        size = self._library.tfsat_card_size(self._robot)
        return read_bytes(size, self._library.tfsat_card_read, self._robot)

    def seat(self) -> None:
        """Hangs the robot in the releaser: held by body 1, both switches closed."""
        self._library.tfsat_seat(self._robot)

    def hold(self, bodies: Sequence[int]) -> None:
        """Fixes bodies (1 to 4) on the bench where they are; the others follow the joints.

        Raises:
            EmulationError: no body is named, or one that does not exist.
        """
        if not bodies or any(not 1 <= body <= IMU_COUNT for body in bodies):
            raise EmulationError(
                what=f"Bodies {list(bodies)} cannot be held: there are bodies 1 to {IMU_COUNT}.",
                meaning="Nothing was changed.",
                next_step="Name at least one of them, such as: hold 2 3 4",
            )
        # Bit i stands for body i + 1; a body named twice counts once, or its bit would carry into the next.
        self._library.tfsat_hold(self._robot, sum(1 << (body - 1) for body in set(bodies)))

    def swing(self, joint: int, amplitude_deg: float, period_s: float, cycles: int) -> None:
        """Moves a limp joint (1 to 3) by hand, `cycles` times out by `amplitude_deg` and back.

        Raises:
            EmulationError: its servo holds the joint, or the joint would leave its range.
        """
        # Check the number here: the library indexes its arrays with it.
        moved = 1 <= joint <= JOINT_COUNT and self._library.tfsat_swing(
            self._robot, joint - 1, np.deg2rad(amplitude_deg), period_s, cycles
        )
        if not moved:
            raise EmulationError(
                what=f"Joint {joint} cannot be swung by {amplitude_deg:g} deg.",
                meaning="Its servo holds it, it would leave its range, or there is no such joint.",
                next_step="Disarm the sequencer first, or swing less.",
            )

    @property
    def swinging(self) -> bool:
        """A hand still moves a joint or turns the robot."""
        return bool(self._library.tfsat_swinging(self._robot))

    def set_switch(self, index: int, closed: bool) -> None:
        """Presses or lets go a release switch (1 or 2)."""
        self._library.tfsat_set_switch(self._robot, _switch(index), int(closed))

    def knock(self, index: int, open_us: int) -> None:
        """Opens a release switch (1 or 2) for a while, as a blow would."""
        self._library.tfsat_knock(self._robot, _switch(index), open_us)

    def drop(
        self,
        residual_rate_rad_s: Sequence[float] = (0.0, 0.0, 0.0),
        fall_s: float = FALL_S,
        com_velocity_m_s: Sequence[float] = PUSH_OFF_M_S,
    ) -> None:
        """Lets go now: both switches open with bounce, free fall, landing after `fall_s`.

        The rate is the base body's in its frame, the velocity the center of mass's in the world, both at release.
        """
        rate, velocity = vector(residual_rate_rad_s), vector(com_velocity_m_s)
        self._library.tfsat_drop(self._robot, rate, velocity, round(fall_s * US_PER_S))

    @property
    def falling(self) -> bool:
        """In free fall."""
        return bool(self._library.tfsat_falling(self._robot))

    @property
    def released_us(self) -> int:
        """When both switches first were open in the last drop."""
        return int(self._library.tfsat_released_us(self._robot))

    def joint_angles_deg(self) -> tuple[float, ...]:
        """True joint angles, deg."""
        angles = [self._library.tfsat_joint_angle_rad(self._robot, joint) for joint in range(JOINT_COUNT)]
        return tuple(float(np.rad2deg(angle)) for angle in angles)

    def com_position_m(self) -> FloatArray:
        """(3,) true center of mass in the world: z up, the global frame of the robot as it first hung."""
        position = vector((0.0, 0.0, 0.0))
        self._library.tfsat_com_position(self._robot, position)
        return np.array(list(position))

    def record_truth(self, period_us: int) -> None:
        """Keeps the truth each `period_us` from now on."""
        self._library.tfsat_record_truth(self._robot, period_us)

    def truth(self) -> FloatArray:
        """(n, 32): t_s, joint angles (3) rad, attitudes (4 x xyzw, to world), rates (4 x 3) rad/s in body frames."""
        n_rows = self._library.tfsat_truth_rows(self._robot)
        # C order, as the library copies it: one block of n rows with 32 doubles each.
        rows = np.empty((n_rows, TRUTH_COLUMNS))
        self._library.tfsat_truth_read(self._robot, interface().from_buffer("double[]", rows), n_rows)
        return rows


def _switch(index: int) -> int:
    if not 1 <= index <= SWITCH_COUNT:
        raise EmulationError(
            what=f"There is no release switch {index}.",
            meaning="Nothing was changed.",
            next_step=f"Use 1 to {SWITCH_COUNT}.",
        )
    return index - 1


def _text(characters: Any) -> str:
    """Decode a C string of the library."""
    return bytes(interface().string(characters)).decode()
