"""What the campaign does not show, on emulated buses and boards that take their time.

One failed transfer with an IMU; how much later than the sample's time each IMU is read; blocks of RAM to spare while a
file is filled with zeros, where sampling and the card share the processor.
"""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from tests.fixtures.cpp.compiling import EMULATOR_SOURCES, build_program, compile_objects, compiler, run
from tests.fixtures.emulated_drop import Drop, drop
from tests.validation.campaign import Broken
from tests.validation.logger_proof.building import BOARD, PORTABLE, SOURCES
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.robot import load_robot

CHECKED_BEHIND_HZ = 935
"""Up to here a period holds two bursts on the slowest permitted bus, and the settings read back behind them."""


class Glitches(NamedTuple):
    """Of one kind at one rate.

    Attributes:
        kind: `nack` or `timeout`.
        rate_hz: Sampling rate; the buses run at 400 kHz.
        times: How many.
        lost, most: Samples of the struck IMU that they cost, in all and at most by one of them.
        others: Samples of the other IMUs that they cost.
    """

    kind: str
    rate_hz: int
    times: int
    lost: int
    most: int
    others: int


def run_glitches(folder: Path, rates_hz: Sequence[int]) -> list[Glitches]:
    """Measure the cost of glitches of both kinds at each rate.

    Raises Broken if one costs more than it may.
    """
    program = _build_bench(folder, "glitches")
    glitches = []
    for rate_hz in rates_hz:
        output = subprocess.run([program, str(rate_hz)], capture_output=True, text=True, check=True).stdout
        for line in output.splitlines():
            kind, *numbers = line.split()
            glitches.append(Glitches(kind, rate_hz, *map(int, numbers)))
    for glitch in glitches:
        # The sample that was hit may be lost, but none of another IMU. A second one only after a timeout at 1 kHz,
        # where two bursts on the slowest bus leave no time to read the settings back behind them.
        if glitch.most > allowed_cost(glitch.kind, glitch.rate_hz) or glitch.others:
            raise Broken(
                f"one {glitch.kind} costs {glitch.most} samples at {glitch.rate_hz} Hz, and others {glitch.others}"
            )
    return glitches


def allowed_cost(kind: str, rate_hz: int) -> int:
    """Return how many samples of the struck IMU one failed transfer may cost."""
    return 2 if kind == "timeout" and rate_hz > CHECKED_BEHIND_HZ else 1


def _build_bench(folder: Path, name: str) -> Path:
    sources = [BOARD / f"{name}.cpp"]
    sources += [SOURCES / "core" / f"{name}.cpp" for name in ("settings", "mpu6050", "sampler")]
    sources += [EMULATOR_SOURCES / "sensors" / f"{name}.cpp" for name in ("mpu6050", "low_pass")]
    folder.mkdir(parents=True, exist_ok=True)
    return build_program(sources, folder / name)


PERMITTED_RISE_NS = 230
"""Of the clock line, by docs/wiring.md."""
RISES_NS = (0, 115, PERMITTED_RISE_NS, 275, 426)
"""The last: 2.00 kΩ with 177 pF, which an earlier page permitted."""


class SlowBus(NamedTuple):
    """Ten seconds of sampling on buses of this rise, at 400 kHz.

    Attributes:
        rise_ns: From ground to the master's threshold.
        rate_hz: Sampling rate.
        samples: Of each IMU.
        lost: Of all four.
        longest_us: The longest sampling interrupt.
    """

    rise_ns: int
    rate_hz: int
    samples: int
    lost: int
    longest_us: int


def run_slow_buses(folder: Path, rates_hz: Sequence[int]) -> list[SlowBus]:
    """Sample on buses from fast to too slow.

    Raises Broken if a permitted bus loses a sample, or makes the next one late.
    """
    program = _build_bench(folder, "slow_bus")
    buses = []
    for rise_ns, rate_hz in product(RISES_NS, rates_hz):
        command = [str(program), str(rate_hz), str(rise_ns)]
        output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        buses.append(SlowBus(rise_ns, rate_hz, *map(int, output.split())))
    for bus in buses:
        late = bus.longest_us * bus.rate_hz >= 1_000_000
        if bus.rise_ns <= PERMITTED_RISE_NS and (bus.lost or late):
            raise Broken(f"a permitted bus: {bus}")
    return buses


BUSES_KHZ = (400, 100)
FALL_S = (0.3, 2.2)
"""After the release: strokes, and nothing of the landing."""
MAX_DELAY_S = 0.02
READ_TIME_MAX_US = 100
"""A chip renews its registers each 1000 us, and 280 Hz meets seven phases of that, 143 us apart."""


class Offset(NamedTuple):
    """Of one IMU at one clock of the buses.

    Attributes:
        logged_us: By the log's header.
        measured_us: By how much earlier than IMU 1's its readings show the motion, as they stand in their samples.
    """

    bus_khz: int
    imu: int
    logged_us: int
    measured_us: float


def measure_offsets(folder: Path, buses_khz: tuple[int, ...] = BUSES_KHZ) -> list[Offset]:
    """Measure the time offsets of all IMUs at each bus clock.

    Raises Broken if the log tells a different offset.
    """
    offsets = []
    model = load_robot()
    for bus_khz in buses_khz:
        # Ideal sensors: the delay is then the read offset and the low-pass alone.
        emulated_drop = drop(model, ideal(), seed=1, bus_khz=bus_khz)
        # Relative to IMU 1, so that the low-pass common to all cancels.
        delays_us = [1e6 * _delay_s(emulated_drop, body) for body in range(4)]
        for i, logged_us in enumerate(emulated_drop.log.header.imu_offset_us):
            offsets.append(Offset(bus_khz, i + 1, logged_us, delays_us[0] - delays_us[i]))
    for offset in offsets:
        if abs(offset.logged_us - offset.measured_us) > READ_TIME_MAX_US:
            raise Broken(
                f"IMU {offset.imu} is read {offset.measured_us:.0f} us after the sample's time, "
                f"the log says {offset.logged_us}, at {offset.bus_khz} kHz"
            )
    return offsets


def _delay_s(emulated_drop: Drop, body: int) -> float:
    """Estimate the delay, in s, of the angular speed that a body's gyro shows behind the true one.

    The low-pass and half a reading's age are included.
    """
    true_s = emulated_drop.truth[:, 0]
    attitudes = Rotation.from_quat(emulated_drop.truth[:, 4 + 4 * body : 8 + 4 * body])
    # True speed between two attitudes of the truth, at the middle of the interval.
    speeds = (attitudes[:-1].inv() * attitudes[1:]).magnitude() / np.diff(true_s)
    middles_s = (true_s[:-1] + true_s[1:]) / 2
    rows = (emulated_drop.log.t_s > FALL_S[0]) & (emulated_drop.log.t_s < FALL_S[1])
    t_s, measured_speeds = (
        emulated_drop.log.t_s[rows],
        np.linalg.norm(emulated_drop.log.rate_rad_s[rows, body], axis=1),
    )

    # Speed, not rate: a misalignment does not change the norm.
    def off(delay_s: float) -> float:
        return float(np.sum((measured_speeds - np.interp(t_s - delay_s, middles_s, speeds)) ** 2))

    # Least squares over the delay, to 0.1 us.
    optimum = minimize_scalar(off, bounds=(0.0, MAX_DELAY_S), method="bounded", options={"xatol": 1e-7})
    return float(optimum.x)


SPARES = list(product((280, 850, 900, 1000), (20_700, 23_000, 30_000), (0, 100)))
"""Rates; ns of the processor for a block: the clock's limit, SdFat's maintainer's figure, a dear one; writes of which
one stalls."""
RUN_LIMIT_S = 300
_EMULATOR = (
    "sensors/mpu6050",
    "sensors/low_pass",
    "sensors/angle_sensor",
    "card/block_device",
    "boards/logger_board",
)


class Spare(NamedTuple):
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


def compile_shared_processor(folder: Path) -> Path:
    """Build the program of shared_processor.cpp with the emulated logger board, optimized."""
    sources = [path for name in PORTABLE for path in sorted((SOURCES / name).glob("*.cpp"))]
    sources += [EMULATOR_SOURCES / f"{name}.cpp" for name in _EMULATOR]
    flags = ("-std=c++17", "-O2")
    objects = compile_objects([Path(__file__).with_name("shared_processor.cpp"), *sources], (), flags)
    program = folder / "shared_processor"
    run([compiler(), *objects, "-o", program])
    return program


def measure_spare(program: Path, rate_hz: int, transfer_ns: int, stall_one_in: int) -> Spare:
    """Runs a program of `shared`. Raises Broken: a sample was lost."""
    command = [str(program), str(rate_hz), str(transfer_ns), str(stall_one_in)]
    process = subprocess.run(command, capture_output=True, text=True, check=False, timeout=RUN_LIMIT_S)
    if process.returncode != 0:
        raise Broken(f"{' '.join(command[1:])}: exit code {process.returncode}\n{process.stderr}")
    spare = Spare(rate_hz, transfer_ns, stall_one_in, *map(int, process.stdout.split()))
    # Below zero: the program ran out of blocks.
    if min(spare.at_start, spare.at_change) < 0:
        raise Broken(f"samples were lost: {spare}")
    return spare
