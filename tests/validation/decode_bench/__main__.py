"""`make bench-decode`: our decoder and four others on the same samples, each in its own format.

Every decoder is asked for the same numpy columns and has to give the right ones. Run in an environment
of its own (build/bench-decode/venv), where the others are installed.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import version as installed
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.validation.decode_bench import formats, readers
from tests.validation.decode_bench.formats import Samples


class Decoder(NamedTuple):
    """What is measured; `checks` says which of the log's own checksums it verifies."""

    name: str
    write: Callable[[Samples, Path], None]
    read: Callable[[Path], Samples]
    checks: str


DECODERS = (
    Decoder("tfsat", formats.write_tfsat, readers.read_tfsat, "CRC-32 a block"),
    Decoder("pyulog", formats.write_ulog, readers.read_ulog, "none in format"),
    Decoder("mcap", formats.write_mcap, readers.read_mcap, "CRC-32 a chunk"),
    Decoder("DFReader", formats.write_dataflash, readers.read_dataflash, "none in format"),
    Decoder("Kaitai", formats.write_tfsat, readers.read_kaitai, "none"),
)
LARGE_BYTES = 512 << 20
_SLOW_S = 5.0


def main() -> int:
    """Prints the table; exit code 1 if a decoder gives other values than were written."""
    parser = argparse.ArgumentParser(prog="make bench-decode", description=__doc__)
    parser.add_argument("--samples", type=int, default=168_000, help="10 minutes at 280 Hz")
    parser.add_argument("--rounds", type=int, default=5, help="the best one counts")
    parser.add_argument("--json", type=Path, help="put the figures into this file too")
    arguments = parser.parse_args()
    samples = formats.make_samples(arguments.samples)
    with tempfile.TemporaryDirectory(prefix="tfsat-bench-") as folder:
        rows = [_measure(decoder, samples, Path(folder), arguments.rounds) for decoder in DECODERS]
        # A large recording tells the rate without the costs of the start.
        large = Path(folder) / "large.bin"
        _repeat(samples, large)
        large_s = _best(lambda: readers.read_tfsat(large), arguments.rounds)
        large_mb = large.stat().st_size / 1e6
    print(
        f"{len(samples.t_us)} samples, each decoder's own format, to the same columns; best of up to "
        f"{arguments.rounds}\n"
    )
    print(f"{'decoder':<10}{'checks':<16}{'file':>9}{'time':>11}{'MB/s':>9}{'samples/s':>13}{'tfsat is':>11}")
    # The first decoder is tfsat: the others' times are given as multiples of its own.
    ours = rows[0][2]
    for decoder, (mb, _, taken_s) in zip(DECODERS, rows, strict=True):
        rate = len(samples.t_us) / taken_s
        print(
            f"{decoder.name:<10}{decoder.checks:<16}{mb:>6.1f} MB{taken_s * 1e3:>8.1f} ms{mb / taken_s:>9.0f}"
            f"{rate:>13,.0f}{taken_s / ours:>9.0f} x"
        )
    print(
        f"\ntfsat on {large_mb:.0f} MB: {large_s:.3f} s, {large_mb / large_s:.0f} MB/s, every block's CRC checked"
    )
    if arguments.json:
        table = [
            {
                "decoder": decoder.name,
                "version": version(decoder.name),
                "checks": decoder.checks,
                "mb": mb,
                "taken_s": taken_s,
            }
            for decoder, (mb, _, taken_s) in zip(DECODERS, rows, strict=True)
        ]
        figures = {"samples": len(samples.t_us), "rounds": arguments.rounds, "decoders": table}
        arguments.json.write_text(json.dumps(figures | {"large_mb": large_mb, "large_s": large_s}))
    # A fast decoder that gives other values than were written proves nothing: exit 1.
    wrong = [decoder.name for decoder, (_, right, _) in zip(DECODERS, rows, strict=True) if not right]
    if wrong:
        print(f"Error: wrong values from {', '.join(wrong)}", file=sys.stderr)
    return int(bool(wrong))


def version(decoder: str) -> str:
    """Return the version of the package that provides the decoder."""
    package = {"DFReader": "pymavlink", "Kaitai": "kaitaistruct"}.get(decoder, decoder)
    if package != "tfsat":
        return installed(package)
    from tfsat_host import __version__

    return __version__


def _measure(decoder: Decoder, samples: Samples, folder: Path, rounds: int) -> tuple[float, bool, float]:
    """Size in MB, whether the values are right, and the best time in s."""
    path = folder / decoder.name
    decoder.write(samples, path)
    decoded_samples = decoder.read(path)
    right = all(
        np.array_equal(getattr(decoded_samples, name), getattr(samples, name))
        for name in ("t_us", "imu", "angle")
    )
    # Freed before the timed reads, which then have the same memory as the first one.
    del decoded_samples
    return path.stat().st_size / 1e6, right, _best(lambda: decoder.read(path), rounds)


def _best(work: Callable[[], object], rounds: int) -> float:
    best_s = float("inf")
    for _ in range(rounds):
        # The minimum of several rounds: other processes only ever make a run longer.
        started_s = time.perf_counter()
        work()
        best_s = min(best_s, time.perf_counter() - started_s)
        # A decoder that takes so long is not measured again.
        if best_s > _SLOW_S:
            break
    return best_s


def _repeat(samples: Samples, path: Path) -> None:
    """Write a recording of LARGE_BYTES that repeats the same counts at continuing times."""
    # Ceiling division; a block of 512 bytes holds six samples.
    times = -(-LARGE_BYTES * 6 // (512 * len(samples.t_us)))
    count = times * len(samples.t_us)
    # Full blocks only, as write_tfsat expects.
    count -= count % 6
    t_us = formats.START_US + np.arange(count) * formats.INTERVAL_US
    imu, angle = (np.concatenate([column] * times)[:count] for column in (samples.imu, samples.angle))
    formats.write_tfsat(Samples(t_us, imu, angle), path)


if __name__ == "__main__":
    sys.exit(main())
