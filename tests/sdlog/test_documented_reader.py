"""The short reader that docs/log-format.md prints reads what ours reads."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from tests.sdlog.encoder import recording
from tfsat_host.sdlog import load

PAGE = Path(__file__).parents[2] / "docs" / "log-format.md"


def test_it_prints_every_sample(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "SD.bin"
    path.write_bytes(recording().image())
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    log = load(path)
    lines = [list(map(int, line.split())) for line in done.stdout.splitlines()]
    assert [line[0] for line in lines] == log.t_us.tolist()
    assert [line[2:30] for line in lines] == log.imu_counts.reshape(len(log), 28).tolist()
    assert [line[30:] for line in lines] == log.angle_counts.tolist()
