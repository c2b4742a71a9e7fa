"""`make decode-report`: the decoder's times and memory, and four decoded drops, in docs/decode-report.md."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.paths import REPOSITORY
from tests.sdlog.test_memory import above_output
from tests.validation.decode_bench import formats
from tests.validation.decode_bench.scenarios import make

REPORT = REPOSITORY / "docs" / "decode-report.md"
BENCH_PYTHON = REPOSITORY / "build" / "bench-decode" / "venv" / "bin" / "python"
FUZZED = REPOSITORY / "build" / "fuzz-decode" / "summary"
TEN_MINUTES = 168_000
ROUNDS = 5
_FILL_BYTES = 512 << 20
_FILL = f"""
import time, numpy as np
column = np.empty({_FILL_BYTES}, np.uint8)
for _ in range(2):
    started_s = time.perf_counter()
    column.fill(1)
    print({_FILL_BYTES} / 1e9 / (time.perf_counter() - started_s))
"""

HEAD = """\
# What the decoder was measured to do

Written by `make decode-report`; do not edit. Times are of one computer and are worth their ratios; the verdicts, the
counts and the sizes below are the same everywhere.

| | |
|---|---|
| tfsat-host | {version} |
| Python, numpy | {python}, {numpy} |
| processor cores | {cores} |

## 1. Next to other decoders

The same {samples} samples (10 minutes at 280 Hz) in each decoder's own format, decoded to the same numpy columns; every
one gave the right values. Best of up to {rounds} in one process, page cache warm.

| decoder | version | checks | file | time | MB/s | samples/s | time / tfsat's |
|---|---|---|---|---|---|---|---|
"""

FIGURES = """
tfsat on a recording of {large_mb:.0f} MB: {large_s:.2f} s, {large_rate:.0f} MB/s, every block's CRC checked;
best of {rounds}, page cache warm.

The first load of a fresh process waits for memory: `np.empty` is filled for the first time at {first:.1f} GB/s here, at
{again:.1f} GB/s the second time. Columns are about 1.3 times as large as their blocks.

## 2. A whole recording, from the command line

| | |
|---|---|
| `tfsat-host decode` of 10 minutes to NPZ, from the start of the process to its end | {npz_s:.2f} s, best of {rounds} |
| most memory of the decoding process above its output, interpreter included | {above_mb:.0f} MB |
{fuzzed}
## 3. Four drops of the emulated robot

`tfsat-host rehearse 59 70 --as-filed --seed 1` (and 2) made the cards; each row links to what `decode` prints.

| log | what was done to it | exit code | verdict | samples | samples lost | blocks lost | blocks set aside |
|---|---|---|---|---|---|---|---|
"""


def main() -> int:
    """Exit code 0, or 1 and no new report if a decoder gives wrong values."""
    parser = argparse.ArgumentParser(prog="make decode-report", description=__doc__)
    parser.add_argument("--out", type=Path, default=REPORT)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tfsat-report-") as name:
        folder = Path(name)
        bench = _bench(folder / "bench.json")
        if bench is None:
            print(f"Error: the benchmark failed; {arguments.out.name} is as it was.", file=sys.stderr)
            return 1
        text = "".join(
            [_head(bench), _figures(bench, folder), *_drops(folder, arguments.out.with_suffix(""))]
        )
    arguments.out.write_text(text, encoding="utf-8")
    print(f"Written to {arguments.out}")
    return 0


def _bench(figures: Path) -> dict[str, Any] | None:
    paths = os.pathsep.join((str(REPOSITORY / "host"), str(REPOSITORY)))
    command = [
        str(BENCH_PYTHON),
        "-m",
        "tests.validation.decode_bench",
        "--rounds",
        str(ROUNDS),
        "--json",
        str(figures),
    ]
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, cwd=REPOSITORY, check=False)
    if done.returncode:
        return None
    bench: dict[str, Any] = json.loads(figures.read_text())
    return bench


def _head(bench: dict[str, Any]) -> str:
    from tfsat_host import __version__

    samples, ours = bench["samples"], bench["decoders"][0]["taken_s"]
    rows = [
        f"| {one['decoder']} | {one['version']} | {one['checks']} | {one['mb']:.1f} MB | "
        f"{one['taken_s'] * 1e3:.1f} ms | {one['mb'] / one['taken_s']:.0f} | "
        f"{samples / one['taken_s']:,.0f} | {one['taken_s'] / ours:.0f} |\n"
        for one in bench["decoders"]
    ]
    head = HEAD.format(
        version=__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        cores=os.cpu_count(),
        samples=samples,
        rounds=bench["rounds"],
    )
    return head + "".join(rows)


def _figures(bench: dict[str, Any], folder: Path) -> str:
    filled = subprocess.run([sys.executable, "-c", _FILL], capture_output=True, text=True, check=True)
    first, again = map(float, filled.stdout.split())
    recording = folder / "ten-minutes.bin"
    formats.write_tfsat(formats.make_samples(TEN_MINUTES), recording)
    above_bytes, _ = above_output(recording)
    fuzzed = ""
    if FUZZED.exists():
        fuzzed = (
            f"| damaged logs judged against the truth (`make fuzz-decode`) | {FUZZED.read_text().strip()} |\n"
        )
    return FIGURES.format(
        **{name: bench[name] for name in ("large_mb", "large_s", "rounds")},
        large_rate=bench["large_mb"] / bench["large_s"],
        first=first,
        again=again,
        npz_s=min(_npz_s(recording) for _ in range(ROUNDS)),
        above_mb=above_bytes / 1e6,
        fuzzed=fuzzed,
    )


def _npz_s(recording: Path) -> float:
    started_s = time.perf_counter()
    _decode(recording, "--format", "npz")
    taken_s = time.perf_counter() - started_s
    recording.with_suffix(".npz").unlink()
    return taken_s


def _drops(folder: Path, printed: Path) -> Iterator[str]:
    """Rows of the table; what `decode` prints goes to a file each in `printed`."""
    printed.mkdir(exist_ok=True)
    for scenario in make(folder):
        done, name = _decode(scenario.path), scenario.path.name
        lines = [f"$ tfsat-host decode {name}", *done.stderr.splitlines(), *done.stdout.splitlines()]
        (printed / f"{name}.txt").write_text(
            "".join(f"{line.rstrip()}\n" for line in lines), encoding="utf-8"
        )
        facts = json.loads(_decode(scenario.path, "--json").stdout)
        aside = ", ".join(
            f"{count} {reason.replace('_', ' ')}" for reason, count in facts["set_aside"].items() if count
        )
        numbers = " | ".join(str(facts[key]) for key in ("verdict", "samples", "samples_lost", "blocks_lost"))
        link = f"[{name}]({printed.name}/{name}.txt)"
        yield f"| {link} | {scenario.what} | {done.returncode} | {numbers} | {aside or 'none'} |\n"


def _decode(path: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """In the file's own folder, as a person does it."""
    command = [sys.executable, "-m", "tfsat_host", "decode", path.name, *options]
    environment = {**os.environ, "NO_COLOR": "1"}
    return subprocess.run(
        command, cwd=path.parent, env=environment, capture_output=True, text=True, check=False
    )


if __name__ == "__main__":
    sys.exit(main())
