"""The sequencer's build: the same bytes anywhere, and errors that say what to do."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

from tests.emulator_avr.conftest import REPOSITORY, build_sketch

REPORT = REPOSITORY / "tools" / "firmware" / "image_report.py"


def test_another_folder_gives_the_same_bytes(sequencer_hex: Path, tmp_path: Path) -> None:
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
    assert report["flash_bytes"] < 0.75 * 28672
    assert report["ram_free_for_stack_bytes"] > 768


def test_a_missing_tool_names_the_installer(tmp_path: Path) -> None:
    make = shutil.which("make")
    assert make is not None
    result = subprocess.run(
        [make, "-f", "tools/firmware/sequencer.mk", f"BUILD={tmp_path}", "SHELL=/bin/sh"],
        cwd=REPOSITORY, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode != 0
    assert "avr-gcc is missing" in result.stderr
    assert "tools/install-toolchain.sh" in result.stderr


def test_a_damaged_image_is_refused(sequencer_hex: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.hex"
    damaged.write_text(sequencer_hex.read_text().replace(":10001000", ":10001100", 1))
    elf, report = sequencer_hex.with_suffix(".elf"), tmp_path / "report.json"
    result = subprocess.run(
        [sys.executable, str(REPORT), str(damaged), str(elf), str(report)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode == 1
    assert "damaged.hex:2: damaged Intel HEX record. Nothing must be flashed" in result.stderr
    assert not report.exists()
