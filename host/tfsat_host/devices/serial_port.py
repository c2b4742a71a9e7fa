"""Opening a serial port: exclusive, with bounded reads and writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tfsat_host.devices.port_errors import PortError, open_error

if TYPE_CHECKING:
    import serial

BAUDRATE = 115_200  # USB CDC ignores it, but 1200 would send an Arduino Micro into its bootloader


def open_serial(path: str, *, read_timeout_s: float = 0.05, write_timeout_s: float = 1.0) -> serial.Serial:
    """Opens the port for this program alone; a write that nobody takes ends after `write_timeout_s`.

    Pseudo-terminals work too: they have no modem lines, so DTR and RTS are left as opening sets them.

    Raises:
        PortError: missing, busy, not permitted, or no serial port; told apart by `code`.
    """
    import serial

    try:
        return serial.Serial(
            path, BAUDRATE, timeout=read_timeout_s, write_timeout=write_timeout_s, exclusive=True
        )
    except (OSError, ValueError) as error:  # SerialException is an OSError
        raise _port_error(path, error) from error


def _port_error(path: str, error: Exception) -> PortError:
    """The errno of a failed configuration is dropped by pyserial, but still in what it was handling."""
    cause: BaseException | None = error
    while cause is not None:
        number = getattr(cause, "errno", None)
        if number is None and cause.args and type(cause).__module__ == "termios":
            number = cause.args[0]
        if isinstance(number, int):
            return open_error(path, number, str(error))
        cause = cause.__context__
    return open_error(path, None, str(error))
