"""Intel HEX, as objcopy and the Arduino IDE write it.

`tools/firmware/image_report.py` reads with this too, by a plain interpreter: nothing but Python is needed here.
"""

from __future__ import annotations

from pathlib import Path

_DATA, _END = 0, 1
_EXTENDED_SHIFTS = {2: 4, 4: 16}
"""Of the address that such a record gives to all that follow."""
_START_ADDRESSES = (3, 5)


def read_hex(path: Path, base: int = 0, most_bytes: int = 1 << 16) -> bytes:
    """The image from address `base` on; gaps are 0xFF.

    Raises:
        ValueError: a record is damaged, unknown, not within `most_bytes` from `base` on, or the last one is missing.
        OSError: the file cannot be read.
    """
    image = bytearray()
    extended = 0
    for number, line in enumerate(path.read_text(encoding="ascii", errors="replace").split(), start=1):
        kind, address, data = _record(line, f"{path}:{number}")
        if kind == _END:
            return bytes(image)
        if kind == _DATA:
            start = extended + address - base
            end = start + len(data)
            if start < 0 or end > most_bytes:
                raise ValueError(f"{path}:{number}: the image reaches beyond {_span(base, most_bytes)}")
            image.extend(b"\xff" * (end - len(image)))
            image[start:end] = data
        elif kind in _EXTENDED_SHIFTS:
            extended = int.from_bytes(data, "big") << _EXTENDED_SHIFTS[kind]
        elif kind not in _START_ADDRESSES:
            raise ValueError(f"{path}:{number}: unknown Intel HEX record")
    raise ValueError(f"{path}: the file was cut short: it has no end record")


def _span(base: int, most_bytes: int) -> str:
    return f"{most_bytes >> 10} KiB" + (f" from 0x{base:08x} on" if base else "")


def _record(line: str, place: str) -> tuple[int, int, bytes]:
    """Kind, address and data."""
    try:
        record = bytes.fromhex(line.removeprefix(":"))
    except ValueError as error:
        raise ValueError(f"{place}: not an Intel HEX record") from error
    if not line.startswith(":") or len(record) < 5 or len(record) != record[0] + 5 or sum(record) & 0xFF:
        raise ValueError(f"{place}: damaged Intel HEX record")
    return record[3], int.from_bytes(record[1:3], "big"), record[4:-1]
