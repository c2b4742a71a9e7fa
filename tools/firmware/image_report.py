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

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host"))

from tfsat_host.flashing.image import FLASH_BYTES, read_hex

RAM_BYTES = 2560
RAM_SECTIONS = (".data", ".bss", ".noinit")

FLASH_BUDGET_PERCENT = 85
FLASH_BUDGET_BYTES = FLASH_BYTES * FLASH_BUDGET_PERCENT // 100
STACK_SPARE_BYTES = 512
"""Never touched by the stack, whatever the board does."""
STACK_USED_BYTES = 416
"""Room for the deepest stack: docs/sequencer-proof.md tells what was measured."""
RAM_BUDGET_BYTES = RAM_BYTES - STACK_SPARE_BYTES - STACK_USED_BYTES


class OverBudgetError(ValueError):
    """The image works today and leaves no room for tomorrow, or for the stack."""


def ram_bytes(path: Path) -> int:
    """Static RAM of a 32-bit little endian ELF file (System V ABI, section headers)."""
    elf = path.read_bytes()
    # ELF magic number, 32-bit class, little endian.
    if elf[:6] != b"\x7fELF\x01\x01":
        raise ValueError(f"{path}: not a 32-bit little endian ELF file")
    (table,) = struct.unpack_from("<I", elf, 32)
    entry_size, count, names_index = struct.unpack_from("<HHH", elf, 46)
    # Of each section: 0 is its name's offset, 4 its place in the file, 5 its size.
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
    """Size and identity of the image.

    Raises:
        OverBudgetError: flash or static RAM is over its budget.
        ValueError: a file is damaged.
    """
    image = read_hex(hex_path)
    ram = ram_bytes(elf_path)
    if len(image) > FLASH_BUDGET_BYTES:
        raise OverBudgetError(
            f"{hex_path} takes {len(image)} bytes of flash, {len(image) - FLASH_BUDGET_BYTES} more than its budget "
            f"of {FLASH_BUDGET_BYTES} ({FLASH_BUDGET_PERCENT}% of {FLASH_BYTES}). Make it smaller"
        )
    if ram > RAM_BUDGET_BYTES:
        raise OverBudgetError(
            f"{hex_path} takes {ram} bytes of static RAM, {ram - RAM_BUDGET_BYTES} more than its budget of "
            f"{RAM_BUDGET_BYTES}: of {RAM_BYTES} bytes the stack needs {STACK_USED_BYTES}, and {STACK_SPARE_BYTES} "
            "must stay untouched. Make its variables smaller"
        )
    return {
        "hex": hex_path.name,
        "sha256": hashlib.sha256(image).hexdigest(),
        "image_crc32": f"{zlib.crc32(image):08x}",
        "flash_bytes": len(image),
        "flash_percent": round(100 * len(image) / FLASH_BYTES, 1),
        "ram_bytes": ram,
        "ram_free_for_stack_bytes": RAM_BYTES - ram,
        "flash_budget_bytes": FLASH_BUDGET_BYTES,
        "ram_budget_bytes": RAM_BUDGET_BYTES,
        "stack_spare_bytes": STACK_SPARE_BYTES,
    }


def main(hex_path: str, elf_path: str, report_path: str) -> int:
    """Writes the report and prints it in a line; 1 when the image must not be flashed."""
    try:
        report = describe(Path(hex_path), Path(elf_path))
    except OverBudgetError as error:
        print(f"{error}. Nothing must be flashed.", file=sys.stderr)
        return 1
    except (ValueError, OSError) as error:
        print(f"{error}. Nothing must be flashed; delete the build folder and build again.", file=sys.stderr)
        return 1
    # Only an image within its budgets gets a report.
    Path(report_path).write_text(json.dumps(report, indent=2) + "\n")
    print(
        f"{hex_path}: flash {report['flash_bytes']} of {FLASH_BYTES} bytes ({report['flash_percent']}%, "
        f"budget {FLASH_BUDGET_BYTES}), RAM {report['ram_bytes']} of {RAM_BYTES} bytes (budget {RAM_BUDGET_BYTES}), "
        f"image {report['image_crc32']}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
