"""An Arduino Micro in libsimavr, driven from Python in virtual time."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

EEPROM_BYTES = 1024
CYCLES_PER_US = 16
USB_POLL_US = 125
MOST_PATHS = 256


class ResetCause(IntEnum):
    WATCHDOG = 0
    BROWN_OUT = 1
    EXTERNAL = 2


class PinHold(IntEnum):
    """What a short makes of a servo pin (tools/emulator/src/boards/sequencer_board.h)."""

    FREE = 0
    LOW = 1
    HIGH = 2


@dataclass(frozen=True)
class Edge:
    """A change of an output pin's level: 0 to 2 are D9 to D11, 3 is D12."""

    t_ns: int
    pin: int
    high: bool


def load_library(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    board = ctypes.c_void_p
    signatures: dict[str, tuple[object, list[object]]] = {
        "board_open": (board, [ctypes.c_char_p]),
        "board_error": (ctypes.c_char_p, []),
        "board_close": (None, [board]),
        "board_set_power": (None, [board, ctypes.c_bool]),
        "board_reset": (None, [board, ctypes.c_uint8]),
        "board_advance_to_cycle": (ctypes.c_char_p, [board, ctypes.c_uint64]),
        "board_set_switch": (None, [board, ctypes.c_int, ctypes.c_bool]),
        "board_hold_pin": (None, [board, ctypes.c_int, ctypes.c_uint8]),
        "board_set_cable": (None, [board, ctypes.c_bool]),
        "board_set_port": (None, [board, ctypes.c_bool, ctypes.c_uint32]),
        "board_set_usb_stage_pause": (None, [board, ctypes.c_uint32]),
        "board_reset_usb_bus": (None, [board]),
        "board_link_ready": (ctypes.c_bool, [board]),
        "board_write": (ctypes.c_size_t, [board, ctypes.c_char_p, ctypes.c_size_t]),
        "board_read": (ctypes.c_size_t, [board, ctypes.c_char_p, ctypes.c_size_t]),
        "board_take_edge": (
            ctypes.c_bool,
            [
                board,
                ctypes.POINTER(ctypes.c_uint64),
                ctypes.POINTER(ctypes.c_uint8),
                ctypes.POINTER(ctypes.c_bool),
            ],
        ),
        "board_eeprom_get": (None, [board, ctypes.c_char_p, ctypes.c_size_t]),
        "board_eeprom_set": (None, [board, ctypes.c_char_p, ctypes.c_size_t]),
        "board_eeprom_writes": (ctypes.c_uint32, [board]),
        "board_set_serial": (None, [board, ctypes.c_char_p]),
        "board_cycles": (ctypes.c_uint64, [board]),
        "board_watch_blocking": (None, [board]),
        "board_blocked": (
            ctypes.c_size_t,
            [board, ctypes.POINTER(ctypes.c_uint16), ctypes.POINTER(ctypes.c_uint64), ctypes.c_size_t],
        ),
        "board_set_extended_fuse": (None, [board, ctypes.c_uint8]),
        "board_peek": (ctypes.c_uint8, [board, ctypes.c_uint16]),
        "board_copy": (None, [board, ctypes.c_uint16, ctypes.POINTER(ctypes.c_uint8), ctypes.c_size_t]),
        "board_poke": (None, [board, ctypes.c_uint16, ctypes.c_uint8]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


class AvrBoard:
    """One board. Times are virtual, in microseconds since it was made."""

    def __init__(self, library: ctypes.CDLL, hex_path: Path) -> None:
        self._library = library
        self._handle = library.board_open(str(hex_path).encode())
        if not self._handle:
            raise RuntimeError(library.board_error().decode())
        self.now_us = 0

    def close(self) -> None:
        self._library.board_close(self._handle)
        self._handle = None

    def run_to(self, t_us: int) -> None:
        self.run_to_cycle(t_us * CYCLES_PER_US)

    def run_to_cycle(self, cycle: int) -> None:
        """To a cycle of the CPU's clock; `now_us` is then the last whole microsecond."""
        failure = self._library.board_advance_to_cycle(self._handle, cycle)
        if failure is not None:
            raise RuntimeError(failure.decode())
        self.now_us = cycle // CYCLES_PER_US

    @property
    def cycles(self) -> int:
        """Where the processor is: the instruction that reached the last moment may have gone beyond it."""
        return int(self._library.board_cycles(self._handle))

    def run(self, duration_us: int) -> None:
        self.run_to(self.now_us + duration_us)

    def power(self, on: bool) -> None:
        self._library.board_set_power(self._handle, on)

    def reset(self, cause: ResetCause) -> None:
        self._library.board_reset(self._handle, int(cause))

    def switch(self, index: int, *, closed: bool) -> None:
        self._library.board_set_switch(self._handle, index, closed)

    def hold_pin(self, joint: int, hold: PinHold) -> None:
        """Holds the servo pin of joint 1 to 3, or lets it go."""
        self._library.board_hold_pin(self._handle, joint - 1, int(hold))

    def cable(self, plugged: bool) -> None:
        self._library.board_set_cable(self._handle, plugged)

    def port(self, is_open: bool, baud: int = 115200) -> None:
        self._library.board_set_port(self._handle, is_open, baud)

    def usb_stage_pause(self, pause_us: int) -> None:
        """A busy host: it rests this long after each stage of a control transfer."""
        if pause_us % USB_POLL_US != 0:
            raise ValueError(
                f"the host polls every {USB_POLL_US} us: a pause of {pause_us} us is none of its"
            )
        self._library.board_set_usb_stage_pause(self._handle, pause_us // USB_POLL_US)

    def reset_usb_bus(self) -> None:
        """A host that resets the bus and, against the standard, asks within 125 us."""
        self._library.board_reset_usb_bus(self._handle)

    @property
    def link_ready(self) -> bool:
        return bool(self._library.board_link_ready(self._handle))

    def connect(self, limit_us: int = 1_000_000) -> None:
        """Plugs the cable in and waits for the serial port."""
        self.cable(True)
        deadline_us = self.now_us + limit_us
        while not self.link_ready:
            if self.now_us >= deadline_us:
                raise TimeoutError(f"the board did not enumerate within {limit_us} us")
            self.run(1000)
        self.run(5000)

    def send(self, data: bytes) -> int:
        return int(self._library.board_write(self._handle, data, len(data)))

    def receive(self) -> bytes:
        """Whatever has arrived."""
        buffer = ctypes.create_string_buffer(4096)
        size = self._library.board_read(self._handle, buffer, 4096)
        return buffer.raw[:size]

    def receive_exactly(self, n: int, limit_us: int = 100_000) -> bytes:
        data = self.receive()
        deadline_us = self.now_us + limit_us
        while len(data) < n:
            if self.now_us >= deadline_us:
                raise TimeoutError(f"{len(data)} of {n} bytes within {limit_us} us: {data.hex()}")
            self.run(250)
            data += self.receive()
        if len(data) > n:
            raise ValueError(f"{len(data)} bytes where {n} were asked for: {data.hex()}")
        return data

    def edges(self) -> list[Edge]:
        """The output edges since the last call, oldest first."""
        t_ns, pin, high = ctypes.c_uint64(), ctypes.c_uint8(), ctypes.c_bool()
        found = []
        while self._library.board_take_edge(
            self._handle, ctypes.byref(t_ns), ctypes.byref(pin), ctypes.byref(high)
        ):
            found.append(Edge(t_ns.value, pin.value, high.value))
        return found

    def eeprom(self) -> bytes:
        buffer = ctypes.create_string_buffer(EEPROM_BYTES)
        self._library.board_eeprom_get(self._handle, buffer, EEPROM_BYTES)
        return buffer.raw

    def set_eeprom(self, image: bytes) -> None:
        self._library.board_eeprom_set(self._handle, image, len(image))

    @property
    def eeprom_writes(self) -> int:
        """Byte writes begun since the board was made."""
        return int(self._library.board_eeprom_writes(self._handle))

    def set_serial_number(self, serial: bytes) -> None:
        if len(serial) != 10:
            raise ValueError(f"a serial number has 10 bytes, not {len(serial)}")
        self._library.board_set_serial(self._handle, serial)

    def set_extended_fuse(self, fuse: int) -> None:
        self._library.board_set_extended_fuse(self._handle, fuse)

    def watch_blocking(self) -> None:
        """From now on, measures how long interrupts stay off; several times slower."""
        self._library.board_watch_blocking(self._handle)

    def blocked(self) -> dict[int, int]:
        """The longest they were off, cycles, by the address of the first instruction then."""
        addresses = (ctypes.c_uint16 * MOST_PATHS)()
        cycles = (ctypes.c_uint64 * MOST_PATHS)()
        count = self._library.board_blocked(self._handle, addresses, cycles, MOST_PATHS)
        return dict(zip(addresses[:count], cycles[:count], strict=True))

    def peek(self, address: int) -> int:
        """One byte of the data space, as a debugger would read it."""
        return int(self._library.board_peek(self._handle, address))

    def copy(self, addresses: range) -> bytes:
        """Bytes that follow each other."""
        out = (ctypes.c_uint8 * len(addresses))()
        self._library.board_copy(self._handle, addresses.start, out, len(out))
        return bytes(out)

    def poke(self, address: int, value: int) -> None:
        """Changes it."""
        self._library.board_poke(self._handle, address, value)
