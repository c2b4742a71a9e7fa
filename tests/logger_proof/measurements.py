"""What the campaign does not show, on emulated buses and boards that take their time.

One failed transfer with an IMU; how much later than the sample's time each IMU is read; blocks of RAM to spare while a
file is filled with zeros, where sampling and the card share the processor.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from tests.cpp.compiling import EMULATOR_SOURCES, build_program, compile_objects, compiler, run
from tests.evaluation.drops import Drop, drop
from tests.logger_proof.building import BOARD, PORTABLE, SOURCES
from tests.proof.campaign import Broken, paragraph, table
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.protocol.limits import FILE_FACTORY_MIB, RING_BLOCKS
from tfsat_host.robot import load_robot


@dataclass(frozen=True, slots=True)
class Glitches:
    """Of one kind at one rate.

    Attributes:
        kind: `nack` or `timeout`.
        rate_hz: Sampling rate; the buses run at 400 kHz.
        count: How many.
        lost, most: Samples of the struck IMU that they cost, in all and at most by one of them.
        others: Samples of the other IMUs that they cost.
    """

    kind: str
    rate_hz: int
    count: int
    lost: int
    most: int
    others: int


def run_glitches(folder: Path, rates_hz: Sequence[int]) -> list[Glitches]:
    """Of both kinds at each rate. Raises Broken if one costs more than the sample that it hit."""
    program = _built(folder)
    found = []
    for rate_hz in rates_hz:
        said = subprocess.run([program, str(rate_hz)], capture_output=True, text=True, check=True).stdout
        for line in said.splitlines():
            kind, *numbers = line.split()
            found.append(Glitches(kind, rate_hz, *map(int, numbers)))
    for one in found:
        if one.most > 1 or one.others:
            raise Broken(
                f"one {one.kind} costs {one.most} samples at {one.rate_hz} Hz, and others {one.others}"
            )
    return found


def _built(folder: Path) -> Path:
    sources = [BOARD / "glitches.cpp"]
    sources += [SOURCES / "core" / f"{name}.cpp" for name in ("settings", "mpu6050", "sampler")]
    sources += [EMULATOR_SOURCES / "sensors" / f"{name}.cpp" for name in ("mpu6050", "low_pass")]
    folder.mkdir(parents=True, exist_ok=True)
    return build_program(sources, folder / "glitches")


BUSES_KHZ = (400, 100)
FALL_S = (0.3, 2.2)
"""After the release: strokes, and nothing of the landing."""
MOST_DELAY_S = 0.02
MOST_OFF_US = 100
"""A chip renews its registers each 1000 us, and 280 Hz meets seven phases of that, 143 us apart."""


@dataclass(frozen=True, slots=True)
class Offset:
    """Of one IMU at one clock of the buses, in microseconds.

    Attributes:
        told: By the log's header.
        measured: By how much earlier than IMU 1's its readings show the motion, as they stand in their samples.
    """

    bus_khz: int
    imu: int
    told: int
    measured: float


def measure_offsets(folder: Path, buses_khz: tuple[int, ...] = BUSES_KHZ) -> list[Offset]:
    """Of all IMUs at each clock. Raises Broken if the log tells another one."""
    found = []
    model = load_robot()
    for bus_khz in buses_khz:
        one = drop(folder / str(bus_khz), model, model, ideal(), seed=1, bus_khz=bus_khz)
        delays_us = [1e6 * _delay_s(one, body) for body in range(4)]
        for i, told in enumerate(one.log.header.imu_offset_us):
            found.append(Offset(bus_khz, i + 1, told, delays_us[0] - delays_us[i]))
    for offset in found:
        if abs(offset.told - offset.measured) > MOST_OFF_US:
            raise Broken(
                f"IMU {offset.imu} is read {offset.measured:.0f} us after the sample's time at {offset.bus_khz} kHz, "
                f"the log says {offset.told}"
            )
    return found


def _delay_s(one: Drop, body: int) -> float:
    """From the true angular speed to the one that a body's gyro shows, the low-pass and half a reading's age in it."""
    true_s = one.truth[:, 0]
    attitudes = Rotation.from_quat(one.truth[:, 4 + 4 * body : 8 + 4 * body])
    speeds = (attitudes[:-1].inv() * attitudes[1:]).magnitude() / np.diff(true_s)
    middles_s = (true_s[:-1] + true_s[1:]) / 2
    rows = (one.log.t_s > FALL_S[0]) & (one.log.t_s < FALL_S[1])
    t_s, shown = one.log.t_s[rows], np.linalg.norm(one.log.rate_rad_s[rows, body], axis=1)

    def off(delay_s: float) -> float:
        return float(np.sum((shown - np.interp(t_s - delay_s, middles_s, speeds)) ** 2))

    found = minimize_scalar(off, bounds=(0.0, MOST_DELAY_S), method="bounded", options={"xatol": 1e-7})
    return float(found.x)


SPARE_RATES_HZ = (280, 850, 900, 1000)
TRANSFERS_NS = (20_700, 23_000, 30_000)
"""Of the processor for a block: the clock's limit, SdFat's maintainer's figure, and a dear one."""
STALLS_ONE_IN = (0, 100)
RUN_LIMIT_S = 300
_EMULATOR = (
    "sensors/mpu6050",
    "sensors/low_pass",
    "sensors/angle_sensor",
    "card/block_device",
    "boards/logger_board",
)


@dataclass(frozen=True, slots=True)
class Spare:
    """Of the ring's blocks, the fewest that were free.

    Attributes:
        rate_hz: Of sampling.
        transfer_ns: Processor time that a block takes on its way to the card.
        stall_one_in: Writes, of which one keeps the card busy for 50 to 500 ms; 0: none.
        at_start: In the first 30 s of a recording with the factory's file.
        at_change: Since the next file began, when the first was full.
    """

    rate_hz: int
    transfer_ns: int
    stall_one_in: int
    at_start: int
    at_change: int


def build_shared_processor(folder: Path) -> Path:
    """The emulated logger board, optimized."""
    sources = [path for name in PORTABLE for path in sorted((SOURCES / name).glob("*.cpp"))]
    sources += [EMULATOR_SOURCES / f"{name}.cpp" for name in _EMULATOR]
    flags = ("-std=c++17", "-O2")
    objects = compile_objects([Path(__file__).with_name("shared_processor.cpp"), *sources], (), flags)
    program = folder / "shared_processor"
    run([compiler(), *objects, "-o", program])
    return program


def measure_spares(
    program: Path, rates_hz: Sequence[int] = SPARE_RATES_HZ, transfers_ns: Sequence[int] = TRANSFERS_NS
) -> list[Spare]:
    """Each rate with each cost, without and with stalls. Raises Broken: a sample was lost."""
    cases = [(rate, cost, stalls) for rate in rates_hz for cost in transfers_ns for stalls in STALLS_ONE_IN]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda case: _measured(program, *case), cases))


def _measured(program: Path, rate_hz: int, transfer_ns: int, stall_one_in: int) -> Spare:
    command = [str(program), str(rate_hz), str(transfer_ns), str(stall_one_in)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=RUN_LIMIT_S)
    if done.returncode != 0:
        raise Broken(f"{' '.join(command[1:])}: exit code {done.returncode}\n{done.stderr}")
    spare = Spare(rate_hz, transfer_ns, stall_one_in, *map(int, done.stdout.split()))
    if min(spare.at_start, spare.at_change) < 0:
        raise Broken(f"samples were lost: {spare}")
    return spare


def spares_page(spares: Sequence[Spare]) -> str:
    cases = sorted({(spare.rate_hz, spare.transfer_ns) for spare in spares})
    by_case = {(spare.rate_hz, spare.transfer_ns, spare.stall_one_in): spare for spare in spares}
    stalls = sorted({spare.stall_one_in for spare in spares})
    rows = []
    for rate_hz, transfer_ns in cases:
        chosen = [by_case[rate_hz, transfer_ns, one_in] for one_in in stalls]
        figures = [figure for spare in chosen for figure in (spare.at_start, spare.at_change)]
        rows.append((rate_hz, f"{transfer_ns / 1000:g}", *figures))
    header = ["Hz", "µs a block"]
    for one_in in stalls:
        card = f"1 write in {one_in} stalls" if one_in else "takes what comes"
        header += [f"{card}: at the start", "at the next file"]
    text = paragraph(
        "SdFat's programmed transfers take the processor for each block, 20.7 µs at the clock's limit and 22 to 23 µs "
        "by its maintainer's figure; the sampling interrupt keeps it for two bursts, 780 µs. The emulated board shares "
        f"its processor so. Of the {RING_BLOCKS} blocks of RAM, the fewest that were free while the factory's file of "
        f"{FILE_FACTORY_MIB} MiB was filled in turns with the recording, from `record start` on and again when the "
        "robot had waited until the file was full. No sample was dropped."
    )
    return f"## 6. A processor that is shared\n\n{text}\n\n{table(header, rows)}"


def glitches_page(glitches: Sequence[Glitches]) -> str:
    named = {"nack": "one NACK", "timeout": "one timeout, the bus clocked free"}
    rows = [
        (named[one.kind], one.rate_hz, one.count, f"{one.lost / one.count:.2f}", one.most, one.others)
        for one in glitches
    ]
    header = ("what fails", "Hz", "times", "samples lost, mean", "most", "of other IMUs")
    text = paragraph(
        "One transfer of a running IMU fails. Its settings are read back behind the bursts of that instant or of the "
        "next one; if they are as they were, it goes on. The buses run at 400 kHz and take their time, as on the board."
    )
    return f"## 7. One failed transfer\n\n{text}\n\n{table(header, rows)}"


def offsets_page(offsets: Sequence[Offset]) -> str:
    rows = [(one.bus_khz, one.imu, one.told, f"{one.measured:.0f}") for one in offsets]
    header = ("buses, kHz", "IMU", "told by the log, µs", "measured, µs")
    text = paragraph(
        "When each IMU of a sample is read after the sample's time: what the log's header tells, and by how much "
        "earlier than IMU 1's its readings show the motion. For each body of an emulated robot without imperfections "
        "the delay is taken at which its gyro's angular speed fits the true one best, in least squares, from "
        f"{FALL_S[0]:g} to {FALL_S[1]:g} s after the release. A chip renews its registers each 1000 µs, which is what "
        "the difference comes from."
    )
    return f"## 8. When a sensor is read\n\n{text}\n\n{table(header, rows)}"
