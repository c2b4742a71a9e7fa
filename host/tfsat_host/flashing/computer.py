"""What flashing needs of the computer: its ports, programs and clock."""

from __future__ import annotations

import codecs
import contextlib
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Sequence

from tfsat_host.devices.ports import PortInfo, open_error, open_serial, system_ports
from tfsat_host.devices.transport import SerialTransport, Transport

_CHUNK_BYTES = 256


class Computer:
    """Serial ports, programs and time; a test plays one of its own."""

    def ports(self) -> list[PortInfo]:
        """The serial ports that there are now."""
        return system_ports()

    def connect(self, path: str) -> Transport:
        """The port, open. Raises PortError."""
        return SerialTransport(path)

    def find_program(self, name: str) -> str | None:
        """The path of an installed program."""
        return shutil.which(name)

    def now_s(self) -> float:
        """Seconds from any origin."""
        return time.monotonic()

    def sleep(self, duration_s: float) -> None:
        """Lets time pass."""
        time.sleep(duration_s)

    def touch(self, path: str, baudrate: int = 1200) -> None:
        """Opens the port at this rate and closes it, DTR low: at 1200 baud, an Arduino Micro starts its bootloader.

        Raises PortError.
        """
        import serial

        port = open_serial(path)
        try:
            port.baudrate = baudrate
            with contextlib.suppress(
                OSError
            ):  # a pseudo-terminal has no DTR; closing lowers it elsewhere too
                port.dtr = False
        except serial.SerialException as error:
            raise open_error(path, error.errno, str(error)) from error
        finally:
            port.close()

    def run(self, command: Sequence[str], output: Callable[[str], None], timeout_s: float) -> int | None:
        """Runs a program and passes on its output, as it comes; its exit code, None if it was ended for time.

        Raises OSError if it cannot be started.
        """
        # Undecoded and unbuffered: progress comes as single characters without line ends.
        with subprocess.Popen(
            list(command),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
        ) as process:
            assert process.stdout is not None
            overdue = threading.Event()

            def end() -> None:
                overdue.set()
                process.kill()

            timer = threading.Timer(timeout_s, end)
            timer.start()
            decoder = codecs.getincrementaldecoder("utf-8")(errors="replace")
            try:
                while chunk := process.stdout.read(_CHUNK_BYTES):
                    output(decoder.decode(chunk))
                code = process.wait()
            except BaseException:
                process.kill()
                raise
            finally:
                timer.cancel()
        return None if overdue.is_set() else code
