"""`make decode-report`: the decoder's times and memory, and four decoded drops, for docs/decode-report.md."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tests.paths import DOCS, REPOSITORY
from tests.sdlog.test_memory import above_output
from tests.validation.decode_bench import formats
from tests.validation.decode_bench.scenarios import Scenario, make
from tests.validation.provenance import CampaignRun
from tests.validation.tables import csv_text

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


def main() -> int:
    """Exit code 0, or 1 and no new table if a decoder gives wrong values."""
    parser = argparse.ArgumentParser(prog="make decode-report", description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of the pages")
    arguments = parser.parse_args()
    run = CampaignRun("decode-report")
    with tempfile.TemporaryDirectory(prefix="tfsat-report-") as name:
        folder = Path(name)
        # In an environment of its own: the other decoders are not dependencies of tfsat.
        bench = _bench(folder / "bench.json")
        if bench is None:
            print("Error: the benchmark failed; docs/decode-report is unchanged.", file=sys.stderr)
            return 1
        tables = {
            "decoders.csv": _compare_decoders(bench),
            "figures.csv": csv_text(("of", "figure", "value"), _list_figures(bench, folder)),
            **_decode_drops(folder),
        }
    machine = {
        "Python, numpy": f"{platform.python_version()}, {np.__version__}",
        "processor cores": os.cpu_count(),
        "rounds, the best of which counts": f"{ROUNDS} at most",
    }
    run.write(tables, machine, arguments.out)
    print(f"Written: {arguments.out.name}/decode-report")
    return 0


def _bench(figures: Path) -> dict[str, Any] | None:
    # PYTHONPATH in place of an installation: the benchmark's environment has no tfsat.
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
    process = subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, cwd=REPOSITORY, check=False)
    if process.returncode:
        return None
    bench: dict[str, Any] = json.loads(figures.read_text())
    return bench


def _compare_decoders(bench: dict[str, Any]) -> str:
    samples, ours = bench["samples"], bench["decoders"][0]["taken_s"]
    columns = ("decoder", "version", "checks", "file, MB", "time, ms", "MB/s", "samples/s", "time / tfsat's")
    return csv_text(
        columns,
        [
            (
                *(decoder["decoder"], decoder["version"], decoder["checks"], f"{decoder['mb']:.1f}"),
                *(f"{decoder['taken_s'] * 1e3:.1f}", f"{decoder['mb'] / decoder['taken_s']:.0f}"),
                *(f"{samples / decoder['taken_s']:.0f}", f"{decoder['taken_s'] / ours:.0f}"),
            )
            for decoder in bench["decoders"]
        ],
    )


def _list_figures(bench: dict[str, Any], folder: Path) -> list[tuple[str, str, str]]:
    """Return section, figure and value."""
    filled = subprocess.run([sys.executable, "-c", _FILL], capture_output=True, text=True, check=True)
    first, again = map(float, filled.stdout.split())
    recording = folder / "ten-minutes.bin"
    formats.write_tfsat(formats.make_samples(TEN_MINUTES), recording)
    above_bytes, _ = above_output(recording)
    figures = [
        ("decoders", "samples", str(bench["samples"])),
        ("decoders", "a large recording", f"{bench['large_mb']:.0f} MB"),
        ("decoders", "time for it", f"{bench['large_s']:.2f} s"),
        ("decoders", "rate", f"{bench['large_mb'] / bench['large_s']:.0f} MB/s"),
        ("decoders", "memory filled for the first time", f"{first:.1f} GB/s"),
        ("decoders", "memory filled again", f"{again:.1f} GB/s"),
        (
            "commands",
            "`tfsat-host decode` of 10 minutes to NPZ",
            f"{min(_npz_s(recording) for _ in range(ROUNDS)):.2f} s",
        ),
        ("commands", "most memory of the process above its output", f"{above_bytes / 1e6:.0f} MB"),
    ]
    # `make fuzz-decode` writes its summary; without a run the row is left out.
    if FUZZED.exists():
        figures.append(("commands", "damaged logs judged (`make fuzz-decode`)", FUZZED.read_text().strip()))
    return figures


def _npz_s(recording: Path) -> float:
    started_s = time.perf_counter()
    _decode(recording, "--format", "npz")
    taken_s = time.perf_counter() - started_s
    # Each round writes a new file.
    recording.with_suffix(".npz").unlink()
    return taken_s


def _decode_drops(folder: Path) -> dict[str, str]:
    """Return what `decode` prints of each drop, by its file's name, and the table of all."""
    printed, rows = {}, []
    for scenario in make(folder):
        process, name = _decode(scenario.path), scenario.path.name
        lines = [f"$ tfsat-host decode {name}", *process.stderr.splitlines(), *process.stdout.splitlines()]
        printed[f"{name}.txt"] = "".join(f"{line.rstrip()}\n" for line in lines)
        facts = json.loads(_decode(scenario.path, "--json").stdout)
        rows.append(describe_drop(scenario, process.returncode, facts))
    return {**printed, "drops.csv": csv_text(DROP_COLUMNS, rows)}


DROP_COLUMNS = (
    "log",
    "what was done to it",
    "exit code",
    "verdict",
    "samples",
    "samples lost",
    "blocks lost",
    "blocks set aside",
)


def describe_drop(scenario: Scenario, exit_code: int, facts: dict[str, Any]) -> tuple[object, ...]:
    """Return a row of the table: what `decode --json` says of a log."""
    name, aside = scenario.path.name, facts["set_aside"]
    set_aside = ", ".join(f"{count} {reason.replace('_', ' ')}" for reason, count in aside.items() if count)
    return (
        f"[{name}](decode-report/{name}.txt)",
        scenario.what,
        exit_code,
        *(facts[key] for key in ("verdict", "samples", "samples_lost", "blocks_lost")),
        set_aside or "none",
    )


def _decode(path: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run `tfsat-host decode` in the file's own folder, as a user would."""
    command = [sys.executable, "-m", "tfsat_host", "decode", path.name, *options]
    # Colour codes would end up in the stored text files.
    environment = {**os.environ, "NO_COLOR": "1"}
    return subprocess.run(
        command, cwd=path.parent, env=environment, capture_output=True, text=True, check=False
    )


if __name__ == "__main__":
    sys.exit(main())
