"""Size and identity of a board image: `image_report.py IMAGE.hex IMAGE.elf REPORT.json`.

The image CRC is CRC-32/ISO-HDLC over flash from address 0 to the last byte of the HEX, which the
firmware computes over itself at boot and reports in HELLO.
"""

from __future__ import annotations

import hashlib
import json
import struct
import sys
import zlib
from pathlib import Path

FLASH_BYTES = 28672  # ATmega32U4: 32 KiB less the bootloader's 4 KiB
RAM_BYTES = 2560
RAM_SECTIONS = (".data", ".bss", ".noinit")


def read_hex(path: Path) -> bytes:
    """The image from address 0 on; gaps are 0xFF. Raises ValueError on a record that is not Intel HEX."""
    image = bytearray()
    for number, line in enumerate(path.read_text().split(), start=1):
        try:
            record = bytes.fromhex(line.removeprefix(":"))
        except ValueError as error:
            raise ValueError(f"{path}:{number}: not an Intel HEX record") from error
        if not line.startswith(":") or len(record) != record[0] + 5 or sum(record) & 0xFF:
            raise ValueError(f"{path}:{number}: damaged Intel HEX record")
        address, kind, data = int.from_bytes(record[1:3], "big"), record[3], record[4:-1]
        if kind == 1:
            break
        if kind in (2, 3, 4, 5):
            if kind in (2, 4) and any(data):
                raise ValueError(f"{path}:{number}: the image reaches beyond 64 KiB")
            continue
        image.extend(b"\xff" * (address + len(data) - len(image)))
        image[address : address + len(data)] = data
    return bytes(image)


def ram_bytes(path: Path) -> int:
    """Static RAM of a 32-bit little endian ELF file (System V ABI, section headers)."""
    elf = path.read_bytes()
    if elf[:6] != b"\x7fELF\x01\x01":
        raise ValueError(f"{path}: not a 32-bit little endian ELF file")
    (table,) = struct.unpack_from("<I", elf, 32)
    entry_size, count, names_index = struct.unpack_from("<HHH", elf, 46)
    sections = [struct.unpack_from("<10I", elf, table + i * entry_size) for i in range(count)]
    names = sections[names_index][4]
    total = 0
    for section in sections:
        start = names + section[0]
        name = elf[start : elf.index(b"\0", start)].decode()
        if name in RAM_SECTIONS:
            total += section[5]
    return total


def describe(hex_path: Path, elf_path: Path) -> dict[str, str | int | float]:
    """Size and identity of the image. Raises ValueError when a file is damaged or does not fit the board."""
    image = read_hex(hex_path)
    ram = ram_bytes(elf_path)
    if len(image) > FLASH_BYTES or ram > RAM_BYTES:
        raise ValueError(
            f"{hex_path} does not fit the board: flash {len(image)} of {FLASH_BYTES} bytes, "
            f"RAM {ram} of {RAM_BYTES} bytes"
        )
    return {
        "hex": hex_path.name,
        "sha256": hashlib.sha256(image).hexdigest(),
        "image_crc32": f"{zlib.crc32(image):08x}",
        "flash_bytes": len(image),
        "flash_percent": round(100 * len(image) / FLASH_BYTES, 1),
        "ram_bytes": ram,
        "ram_free_for_stack_bytes": RAM_BYTES - ram,
    }


def main(hex_path: str, elf_path: str, report_path: str) -> int:
    """Writes the report and prints it in a line; 1 when the image must not be flashed."""
    try:
        report = describe(Path(hex_path), Path(elf_path))
    except (ValueError, OSError) as error:
        print(f"{error}. Nothing must be flashed; delete the build folder and build again.", file=sys.stderr)
        return 1
    Path(report_path).write_text(json.dumps(report, indent=2) + "\n")
    print(
        f"{hex_path}: flash {report['flash_bytes']} of {FLASH_BYTES} bytes ({report['flash_percent']}%), "
        f"RAM {report['ram_bytes']} of {RAM_BYTES} bytes, image {report['image_crc32']}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
