from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial.tools.list_ports

from tests.flashing.desk import Desk

# Keeps its arguments and plays a failure: the real one is used where a board answers.
AVRDUDE = """#!{python}
import json, os, sys
with open({log!r}, "w") as log:
    json.dump(sys.argv[1:], log)
sys.stderr.write(os.environ.get("FAKE_AVRDUDE_SAYS", ""))
sys.exit(int(os.environ.get("FAKE_AVRDUDE_EXIT", "0")))
"""


def hex_text(data: bytes) -> str:
    """Intel HEX with 16 bytes a record."""
    lines = []
    for address in range(0, len(data), 16):
        chunk = data[address : address + 16]
        # Length, address, type 0 (data); the last byte makes the sum of all bytes 0.
        record = bytes([len(chunk), address >> 8, address & 0xFF, 0]) + chunk
        lines.append(f":{(record + bytes([-sum(record) & 0xFF])).hex().upper()}")
    return "\n".join([*lines, ":00000001FF"]) + "\n"


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    """Yield a desk with one Arduino Micro, whose sketch is not the image."""
    desk = Desk()
    monkeypatch.setattr(serial.tools.list_ports, "comports", desk.comports)
    yield desk
    desk.close()


@pytest.fixture
def image(tmp_path: Path) -> Path:
    """1000 bytes: not a whole number of pages."""
    path = tmp_path / "image.hex"
    path.write_text(hex_text(bytes(range(250)) * 4))
    return path


@pytest.fixture
def fake_avrdude(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install a fake avrdude as the only program on the PATH, and return the file for its arguments."""
    folder, log = tmp_path / "bin", tmp_path / "avrdude.json"
    folder.mkdir()
    program = folder / "avrdude"
    program.write_text(AVRDUDE.format(python=sys.executable, log=str(log)))
    program.chmod(0o755)
    # Nothing else is found there: an installed avrdude cannot be called by accident.
    monkeypatch.setenv("PATH", str(folder))
    return log
