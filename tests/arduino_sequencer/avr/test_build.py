"""The sequencer's build: the same bytes anywhere, and errors that say what to do."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fixtures.sequencer.building import build_changed_sequencer, build_sketch
from tests.paths import REPOSITORY

REPORT = REPOSITORY / "tools" / "firmware" / "image_report.py"


def test_another_folder_gives_the_same_bytes(sequencer_hex: Path, tmp_path: Path) -> None:
    # An absolute path in the image would differ here.
    again = build_changed_sequencer([], tmp_path, sequencer_hex)
    assert again.read_bytes() == sequencer_hex.read_bytes()


@pytest.mark.prove
def test_and_with_the_arduino_core_compiled_there(sequencer_hex: Path, tmp_path: Path) -> None:
    sketch = tmp_path / "elsewhere" / "arduino_sequencer"
    shutil.copytree(REPOSITORY / "firmware" / "arduino_sequencer", sketch)
    again = build_sketch(str(sketch), tmp_path / "build")
    assert again.read_bytes() == sequencer_hex.read_bytes()


def test_the_report_describes_the_image(sequencer_hex: Path) -> None:
    report = json.loads(sequencer_hex.with_suffix(".json").read_text())
    image = b"".join(
        bytes.fromhex(line[9:-2]) for line in sequencer_hex.read_text().split() if line[7:9] == "00"
    )
    assert report["flash_bytes"] == len(image)
    assert report["sha256"] == hashlib.sha256(image).hexdigest()
    # 85 % of the flash that the bootloader leaves.
    assert report["flash_bytes"] < 0.85 * 28672
    assert report["ram_free_for_stack_bytes"] > 768


def test_a_missing_tool_names_the_installer(tmp_path: Path) -> None:
    make = shutil.which("make")
    assert make is not None
    result = subprocess.run(
        [make, "-f", "tools/firmware/sequencer.mk", f"BUILD={tmp_path}", "SHELL=/bin/sh"],
        # An empty PATH: no tool is there.
        cwd=REPOSITORY, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode != 0
    assert "avr-gcc is missing" in result.stderr
    assert "tools/install-toolchain.sh" in result.stderr


def test_a_damaged_image_is_refused(sequencer_hex: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.hex"
    # One digit of an address: the record's checksum is then wrong.
    damaged.write_text(sequencer_hex.read_text().replace(":10001000", ":10001100", 1))
    elf, report = sequencer_hex.with_suffix(".elf"), tmp_path / "report.json"
    result = subprocess.run(
        [sys.executable, str(REPORT), str(damaged), str(elf), str(report)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode == 1
    assert "damaged.hex:2: damaged Intel HEX record. Nothing must be flashed" in result.stderr
    assert not report.exists()


def test_an_image_over_its_flash_budget_is_refused(sequencer_hex: Path, tmp_path: Path) -> None:
    """It would still fit the board."""
    budget = json.loads(sequencer_hex.with_suffix(".json").read_text())["flash_budget_bytes"]
    assert budget == 28672 * 85 // 100
    elf, image = sequencer_hex.with_suffix(".elf"), tmp_path / "large.hex"

    def report_on(size: int) -> subprocess.CompletedProcess[str]:
        image.write_text(intel_hex(bytes(size)))
        command = [sys.executable, str(REPORT), str(image), str(elf), str(tmp_path / "report.json")]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    # Exactly the budget is accepted, a byte more is not.
    assert report_on(budget).returncode == 0
    refused = report_on(budget + 1)
    assert refused.returncode == 1
    assert f"{budget + 1} bytes of flash, 1 more than its budget of {budget} (85% of 28672)" in refused.stderr


def intel_hex(image: bytes) -> str:
    """Records of 16 bytes."""
    lines = []
    for address in range(0, len(image), 16):
        data = image[address : address + 16]
        record = bytes((len(data), address >> 8, address & 0xFF, 0)) + data
        # Two's complement of the sum of all bytes, as the format demands.
        lines.append(f":{(record + bytes((-sum(record) & 0xFF,))).hex().upper()}")
    return "\n".join([*lines, ":00000001FF", ""])
