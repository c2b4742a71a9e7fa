"""The sequencer's native board in Python: power, switches, cable, pins, EEPROM, in virtual time."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from itertools import pairwise
from pathlib import Path

from tests.fixtures.cpp.compiling import build_shared
from tests.paths import REPOSITORY
from tfsat_host.devices.client import Client
from tfsat_host.devices.ports import PortError, PortProblem
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.maneuver import Schedule, four_stroke, schedule_maneuver
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import SERVO_FACTORY_NS_PER_DEG, SERVO_FACTORY_ZERO_US

EEPROM_BYTES = 1024
ERASED = bytes([0xFF]) * EEPROM_BYTES
STROKE_LINE = 3
JOINTS = 3
USB_FRAME_US = 1000
OLD = schedule_maneuver(four_stroke(59, 70))
NEW = schedule_maneuver(four_stroke(41.5, 33.25))


class Reset(IntEnum):
    """ResetCause of sequencer_board.h."""

    WATCHDOG = 0
    BROWN_OUT = 1
    EXTERNAL = 2


class PinHold(IntEnum):
    """PinHold of sequencer_board.h."""

    FREE = 0
    LOW = 1
    HIGH = 2


@dataclass(frozen=True)
class Pulse:
    """One servo pulse, nanoseconds of virtual time."""

    rise_ns: int
    width_ns: int


def build_board(folder: Path) -> ctypes.CDLL:
    """The library with the board, compiled from the firmware's core and the emulator's ports."""
    return load_board(build_board_library(folder))


def build_board_library(folder: Path) -> Path:
    """As `build_board`, for other processes to load."""
    emulator = REPOSITORY / "tools" / "emulator" / "src"
    sources = [Path(__file__).with_name("board_bridge.cpp"), *(emulator / "boards").glob("native_*.cpp")]
    sources += (REPOSITORY / "firmware" / "arduino_sequencer" / "src" / "core").glob("*.cpp")
    return build_shared(sources, folder / "board.so", [emulator])


def load_board(path: Path) -> ctypes.CDLL:
    """The functions of a library that `build_board_library` made."""
    library = ctypes.CDLL(str(path))
    board, u64, size, text = ctypes.c_void_p, ctypes.c_uint64, ctypes.c_size_t, ctypes.c_char_p
    signatures: dict[str, tuple[object, list[object]]] = {
        "board_new": (board, []),
        "board_free": (None, [board]),
        "board_now_us": (u64, [board]),
        "board_set_power": (None, [board, ctypes.c_int]),
        "board_reset": (None, [board, ctypes.c_int]),
        "board_advance_to": (None, [board, u64]),
        "board_set_switch": (None, [board, ctypes.c_int, ctypes.c_int]),
        "board_hold_pin": (None, [board, ctypes.c_int, ctypes.c_int]),
        "board_set_cable": (None, [board, ctypes.c_int]),
        "board_write": (size, [board, text, size]),
        "board_read": (size, [board, text, size, u64]),
        "board_edges": (size, [board, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, size]),
        "board_eeprom_get": (None, [board, text, size]),
        "board_eeprom_set": (None, [board, text, size]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


class Board:
    """One sequencer: powered, cable in, both switches closed. Closes with its last reference.

    Unless told what its EEPROM holds, it holds the factory's maneuver, uploaded: it would arm.
    """

    def __init__(self, library: ctypes.CDLL, eeprom: bytes | None = None) -> None:
        if eeprom is None:
            eeprom = uploaded_eeprom(library)
        self._library = library
        self._handle = library.board_new()
        self.opened = {0: False, 1: False}
        self.set_eeprom(eeprom)
        library.board_set_power(self._handle, 1)
        self.advance(1000)

    def __del__(self) -> None:
        self._library.board_free(self._handle)

    @property
    def now_us(self) -> int:
        return int(self._library.board_now_us(self._handle))

    def advance(self, duration_us: int) -> None:
        self.advance_to(self.now_us + duration_us)

    def advance_to(self, t_us: int) -> None:
        self._library.board_advance_to(self._handle, t_us)

    def power(self, on: bool) -> None:
        self._library.board_set_power(self._handle, int(on))

    def power_cycle(self, eeprom: bytes | None = None) -> None:
        """With another EEPROM, if one is given."""
        self.power(False)
        self.advance(50_000)
        if eeprom is not None:
            self.set_eeprom(eeprom)
        self.power(True)
        self.advance(1000)

    def reset(self, cause: Reset) -> None:
        self._library.board_reset(self._handle, int(cause))

    def switch(self, index: int, *, opened: bool) -> None:
        """Opens or closes release switch 0 or 1, now."""
        self.opened[index] = opened
        self._library.board_set_switch(self._handle, index, int(not opened))

    def hold_pin(self, joint: int, hold: PinHold) -> None:
        """Holds the servo pin of joint 1 to 3, or lets it go."""
        self._library.board_hold_pin(self._handle, joint - 1, int(hold))

    def cable(self, plugged: bool) -> None:
        self._library.board_set_cable(self._handle, int(plugged))

    def write(self, data: bytes) -> int:
        return int(self._library.board_write(self._handle, data, len(data)))

    def read(self, timeout_us: int = 0) -> bytes:
        buffer = ctypes.create_string_buffer(4096)
        size = self._library.board_read(self._handle, buffer, 4096, self.now_us + timeout_us)
        return buffer.raw[:size]

    def eeprom(self) -> bytes:
        buffer = ctypes.create_string_buffer(EEPROM_BYTES)
        self._library.board_eeprom_get(self._handle, buffer, EEPROM_BYTES)
        return buffer.raw

    def set_eeprom(self, image: bytes) -> None:
        """Only while the board has no power."""
        self._library.board_eeprom_set(self._handle, image, len(image))

    def edges(self) -> list[tuple[int, int, bool]]:
        """(t_ns, pin, high) of the output edges since the last call."""
        capacity = 4096
        t_ns, pin = (ctypes.c_uint64 * capacity)(), (ctypes.c_uint8 * capacity)()
        high = (ctypes.c_uint8 * capacity)()
        found: list[tuple[int, int, bool]] = []
        while count := self._library.board_edges(self._handle, t_ns, pin, high, capacity):
            found += [(t_ns[i], pin[i], bool(high[i])) for i in range(count)]
        return found

    def ask(self, frame: Frame, timeout_us: int = 20_000) -> list[Frame]:
        """Sends one frame as it is and returns what the board answers; nothing is repeated."""
        self.read()
        self.write(b"\0" + encode_frame(frame))
        receiver, deadline_us = FrameReceiver(), self.now_us + timeout_us
        while self.now_us < deadline_us:
            frames = list(receiver.feed(self.read(deadline_us - self.now_us)))
            if frames:
                return frames
        return []


class Cable:
    """A `Transport` to a board in virtual time; an answer takes a USB frame, 1 ms, at least."""

    name = "native sequencer"

    def __init__(self, board: Board) -> None:
        self.board = board

    def now_s(self) -> float:
        return self.board.now_us / 1e6

    def write(self, data: bytes) -> None:
        deadline_us = self.board.now_us + 1_000_000
        while data:
            data = data[self.board.write(data) :]
            if data:
                if self.board.now_us > deadline_us:
                    raise PortError(
                        PortProblem.OTHER, what="Nobody takes the bytes.", next_step="Plug it in."
                    )
                self.board.advance(1000)

    def read(self, timeout_s: float) -> bytes:
        self.board.advance(USB_FRAME_US)
        return self.board.read(max(0, round(timeout_s * 1e6) - USB_FRAME_US))

    def close(self) -> None:
        pass


def connect(board: Board) -> SequencerClient:
    return SequencerClient.connect(Cable(board))


def client(board: Board) -> Client:
    return Client(Cable(board))


@cache
def uploaded_eeprom(library: ctypes.CDLL) -> bytes:
    """What a board holds that was fresh until OLD was uploaded."""
    board = Board(library, ERASED)
    connect(board).upload(OLD)
    return board.eeprom()


def rows(schedule: Schedule) -> tuple[tuple[int, int, int], ...]:
    """A schedule as the board holds it: joint, angle_cdeg, start_us."""
    return tuple((stroke.joint, stroke.angle_cdeg, stroke.t_us) for stroke in schedule.strokes)


def release(board: Board) -> int:
    """Both switches open without bounce, 100 us apart; returns the release, us."""
    board.switch(0, opened=True)
    board.advance(100)
    board.switch(1, opened=True)
    return board.now_us


def pulses(edges: Iterable[tuple[int, int, bool]], pin: int) -> list[Pulse]:
    """The complete pulses of a pin; its edges must alternate."""
    found: list[Pulse] = []
    rise_ns: int | None = None
    for t_ns, edge_pin, high in edges:
        if edge_pin != pin:
            continue
        assert high == (rise_ns is None), f"pin {pin}: two edges of the same kind at {t_ns} ns"
        if rise_ns is not None:
            found.append(Pulse(rise_ns, t_ns - rise_ns))
        rise_ns = t_ns if high else None
    return found


def assert_servo_signal(train: list[Pulse]) -> None:
    """No pulse out of 500 to 2500 us, none cut short, no gap that a servo or a 16-bit timer cannot bear."""
    for pulse in train:
        assert 500_000 <= pulse.width_ns <= 2_500_000, pulse
    for before, after in pairwise(train):
        assert 5_000_000 <= after.rise_ns - before.rise_ns <= 32_700_000, (before, after)


def width_ns(angle_cdeg: int) -> float:
    """Pulse width that holds an angle, by the specification: linear between 0 and 90 deg."""
    return 1000 * SERVO_FACTORY_ZERO_US + SERVO_FACTORY_NS_PER_DEG * angle_cdeg / 100
