"""Pages of the guide that say something checkable."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.evaluation.run_folder import run_folder
from tests.guide.documents import GUIDE, ROOT


def _text(name: str) -> str:
    return (GUIDE / name).read_text(encoding="utf-8")


def test_the_runbook_is_a_list_to_tick() -> None:
    lines = [line for line in _text("runbook.md").splitlines() if line]
    assert len(lines) <= 50
    assert max(len(line) for line in lines) <= 130
    assert sum(line.startswith("- [ ] ") for line in lines) >= 0.7 * len(lines)


@pytest.mark.parametrize(
    "order",
    [
        ("status", "calibrate misalignment", "upload-sequence", "calibrate bias", "calibrate show"),
        ("calibrate show", "preflight", "record start", "arm", "disarm", "log fetch"),
        ("log fetch", "decode", "evaluate", "campaign add", "bundle", "log erase", "reproduce"),
    ],
)
def test_the_runbook_keeps_the_order_of_the_day(order: tuple[str, ...]) -> None:
    places = [_text("runbook.md").index(f"`tfsat-host {command}") for command in order]
    assert places == sorted(places)


def test_the_python_example_runs(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", _text("python-api.md"), re.DOTALL)
    run_folder(tmp_path / "run")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    angle_rad, std_rad = map(float, done.stdout.split())
    assert angle_rad == pytest.approx(0.48, abs=0.1)
    assert 0.0 < std_rad < 0.02


def test_the_sketches_need_what_the_flashing_page_says() -> None:
    """The page promises that nothing is to be installed beside the board's core."""

    def included(sketch: str) -> set[str]:
        sources = [
            *(ROOT / "firmware" / sketch).rglob("*.[hc]*"),
            *(ROOT / "firmware" / sketch).glob("*.ino"),
        ]
        text = "\n".join(path.read_text(encoding="utf-8") for path in sources)
        return set(re.findall(r"^#include <([A-Za-z/]+\.h)>", text, re.MULTILINE))

    system = {"stdint.h", "stddef.h", "string.h", "math.h", "setjmp.h"}
    assert {
        name for name in included("arduino_sequencer") - system if not name.startswith(("avr/", "util/"))
    } == {"Arduino.h"}
    assert included("teensy_logger") - system - {"avr/eeprom.h"} == {"Arduino.h", "SdFat.h", "Wire.h"}
    for name in ("`SdFat`", "`Wire`"):
        assert name in _text("flashing.md")


def test_porting_names_the_counts_of_the_specification() -> None:
    specification = (ROOT / "protocol" / "tfsat.toml").read_text(encoding="utf-8")
    counts = [
        re.search(rf"^{name}_count = {{ value = (\d+)", specification, re.MULTILINE)
        for name in ("joint", "imu", "angle_sensor", "switch")
    ]
    assert f"| {', '.join(found[1] for found in counts if found)}: fixed" in _text("porting.md")


def test_files_that_the_guide_names_are_there() -> None:
    named = {
        path
        for page in GUIDE.glob("*.md")
        for path in re.findall(
            r"`((?:robots|firmware|tools|protocol|host|docs)/[\w/.-]+\.\w+)`",
            page.read_text(encoding="utf-8"),
        )
    }
    assert len(named) >= 6
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []
