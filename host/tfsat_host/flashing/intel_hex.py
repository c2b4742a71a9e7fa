"""Intel HEX, as avr-objcopy and the Arduino IDE write it.

`tools/firmware/image_report.py` reads with this too, by a plain interpreter: nothing but Python is needed here.
"""

from __future__ import annotations

from pathlib import Path

_DATA, _END = 0, 1
_EXTENDED_ADDRESSES = (2, 4)
_START_ADDRESSES = (3, 5)


def read_hex(path: Path) -> bytes:
    """The image from address 0 on; gaps are 0xFF.

    Raises:
        ValueError: a record is damaged, unknown, beyond 64 KiB, or the last one is missing.
        OSError: the file cannot be read.
    """
    image = bytearray()
    for number, line in enumerate(path.read_text(encoding="ascii", errors="replace").split(), start=1):
        kind, address, data = _record(line, f"{path}:{number}")
        if kind == _END:
            return bytes(image)
        if kind == _DATA:
            image.extend(b"\xff" * (address + len(data) - len(image)))
            image[address : address + len(data)] = data
        elif kind in _EXTENDED_ADDRESSES and any(data):
            raise ValueError(f"{path}:{number}: the image reaches beyond 64 KiB")
        elif kind not in (*_EXTENDED_ADDRESSES, *_START_ADDRESSES):
            raise ValueError(f"{path}:{number}: unknown Intel HEX record")
    raise ValueError(f"{path}: the file was cut short: it has no end record")


def _record(line: str, place: str) -> tuple[int, int, bytes]:
    """Kind, address and data."""
    try:
        record = bytes.fromhex(line.removeprefix(":"))
    except ValueError as error:
        raise ValueError(f"{place}: not an Intel HEX record") from error
    if not line.startswith(":") or len(record) < 5 or len(record) != record[0] + 5 or sum(record) & 0xFF:
        raise ValueError(f"{place}: damaged Intel HEX record")
    return record[3], int.from_bytes(record[1:3], "big"), record[4:-1]
