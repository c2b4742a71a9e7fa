"""An Arduino Micro on a desk without one: a sketch and a bootloader, each at a pseudo-terminal.

The sketch's port goes when it was closed at 1200 baud, the bootloader's comes; the bootloader speaks AVR109 as
Caterina does (LUFA's Bootloader/CDC, Arduino's Caterina.c), keeps what is written, and starts it as the new sketch.
"""

from __future__ import annotations

import os
import termios
import threading
import tty
import zlib
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

from tests.devices.scripted import hello, refusal, reply
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import FrameReceiver

# ATmega32U4: flash is written in pages of 64 words.
PAGE_BYTES = 128
_END = b"\xffend of the test\xff"


class Pty:
    """A pseudo-terminal whose other end `answer` plays, in a thread."""

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self._master, self._slave = os.openpty()
        # Raw: a terminal would turn line feeds and control characters of the protocol into others.
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        self._answer = answer
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        while (data := os.read(self._master, 4096)) != _END:
            answer = self._answer(data)
            if answer:
                os.write(self._master, answer)

    @property
    def touched(self) -> bool:
        """It was last set to 1200 baud."""
        # Index 4 is the input speed.
        return bool(termios.tcgetattr(self._slave)[4] == termios.B1200)

    def close(self) -> None:
        # The thread waits in read(): only bytes from this side end it.
        os.write(self._slave, _END)
        self._thread.join(10)
        os.close(self._slave)
        os.close(self._master)


class Sketch:
    """Answers HELLO, STATUS and DISARM."""

    def __init__(self) -> None:
        self.identity = hello()
        self.state = SequencerState.SAFE
        self.silent = False
        self.requests: list[int] = []
        self._receiver = FrameReceiver()

    def answer(self, data: bytes) -> bytes:
        response = b""
        for frame in self._receiver.feed(data):
            self.requests.append(frame.type)
            if self.silent:
                continue
            if frame.type == msg.HelloRequest.TYPE:
                response += reply(frame, self.identity)
            elif frame.type == msg.DisarmRequest.TYPE:
                self.state = SequencerState.SAFE
                response += reply(frame, msg.DisarmReply(self.state))
            elif frame.type == msg.SequencerStatusRequest.TYPE:
                empty = msg.SequencerStatusReply.decode(bytes(msg.SequencerStatusReply.SIZE))
                response += reply(frame, replace(empty, state=self.state))
            else:
                response += refusal(frame, ErrorCode.UNKNOWN_MESSAGE)
        return response


class Caterina:
    """AVR109, as much as avrdude uses: blocks of flash with an address that counts words."""

    def __init__(self, started: Callable[[bytes], None]) -> None:
        # 32 KiB, erased.
        self.flash = bytearray(b"\xff" * 32768)
        self.end = 0
        self.damage = False
        self._started = started
        self._pending = b""
        self._address = 0

    def answer(self, data: bytes) -> bytes:
        self._pending += data
        response = b""
        while self._pending:
            size = self._size()
            if len(self._pending) < size:
                break
            command, self._pending = self._pending[:size], self._pending[size:]
            response += self._do(command)
        return response

    def _size(self) -> int:
        """Bytes of the command that stands first."""
        kind = self._pending[:1]
        if kind == b"B":
            return 4 + int.from_bytes(self._pending[1:3], "big") if len(self._pending) >= 4 else 4
        return {b"A": 3, b"T": 2, b"x": 2, b"y": 2, b"g": 4}.get(kind, 1)

    def _do(self, command: bytes) -> bytes:
        kind = command[:1]
        # Addresses count words of two bytes.
        if kind == b"A":
            self._address = 2 * int.from_bytes(command[1:3], "big")
        # The head has the size in two bytes and the kind of memory in one; then the data.
        elif kind == b"B":
            self._write(command[4:])
        elif kind == b"g":
            return self._read(int.from_bytes(command[1:3], "big"))
        # Leave the bootloader: whatever is in the flash becomes the sketch.
        elif kind == b"E":
            self._started(bytes(self.flash[: self.end]))
        # Escape: avrdude sends it to synchronize, and expects no answer.
        elif kind == b"\x1b":
            return b""
        # Name, version, serial programmer, address counts itself, device codes;
        # the ATmega32U4's signature 1E 95 87 backwards; block size.
        fixed = {b"S": b"CATERIN", b"V": b"10", b"p": b"S", b"a": b"Y", b"t": b"\x44\0", b"s": b"\x87\x95\x1e",
                 b"b": b"Y" + PAGE_BYTES.to_bytes(2, "big")}  # fmt: skip
        is_known = kind in (b"A", b"B", b"E", b"T", b"P", b"L", b"x", b"y", b"e")
        return fixed.get(kind, b"\r" if is_known else b"?")

    def _write(self, data: bytes) -> None:
        self.flash[self._address : self._address + len(data)] = data
        self._address += len(data)
        self.end = max(self.end, self._address)

    def _read(self, size: int) -> bytes:
        data = bytearray(self.flash[self._address : self._address + size])
        self._address += size
        # One wrong bit: a cell of the flash that did not keep what was written.
        if self.damage:
            data[0] ^= 1
        return bytes(data)


class Desk:
    """The computer's ports: the board in one of its two modes.

    Attributes:
        written: What the bootloader started; None before.
        wakes: A touch brings the bootloader.
        image_bytes: Size of the image, where it is known: the last page's padding is not part of it.
    """

    def __init__(self) -> None:
        self.sketch = Sketch()
        self.bootloader = Caterina(self._start)
        self.sketch_pty = Pty(self.sketch.answer)
        self.bootloader_pty = Pty(self.bootloader.answer)
        self.written: bytes | None = None
        self.wakes = True
        self.waits = False
        self.image_bytes: int | None = None
        self.listed_devices: list[str] = []

    def _start(self, flash: bytes) -> None:
        # Leaving before anything was written starts no new sketch.
        if self.written is None and flash:
            self.written = flash[: self.image_bytes]
            self.become(zlib.crc32(self.written))

    def become(self, image_crc: int) -> None:
        """Leave the bootloader with a sketch of this image CRC."""
        self.waits, self.wakes = False, False
        self.sketch.silent = False
        self.sketch.state = SequencerState.SAFE
        self.sketch.identity = replace(hello(), image_crc=image_crc)

    def comports(self) -> list[SimpleNamespace]:
        """Return the ports in place of pyserial's `comports`."""
        if self.wakes and self.sketch_pty.touched:
            self.waits = True
        # USB ids of Arduino's boards.txt: 0x0037 is the Micro's bootloader, 0x8037 its sketch.
        pty, pid = (self.bootloader_pty, 0x0037) if self.waits else (self.sketch_pty, 0x8037)
        self.listed_devices.append("bootloader" if self.waits else "sketch")
        return [
            SimpleNamespace(device=pty.name, vid=0x2341, pid=pid, serial_number=None, description="Micro")
        ]

    def close(self) -> None:
        self.sketch_pty.close()
        self.bootloader_pty.close()
