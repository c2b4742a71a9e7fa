"""When the fall began and ended, as the accelerometers show it.

They feel the capsule let go, where the switches feel the robot leave the magnet: the paper's electromagnet controller
waits for micro-gravity in between. At the end they feel the shock, long before anyone reads the logger's note of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.apply import CalibratedSamples
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.protocol.limits import FALL_US, LANDING_EARLIEST_US
from tfsat_host.sdlog import DropLog
from tfsat_host.units import STANDARD_GRAVITY_M_S2

SHOCK_G = 3.0
"""No stroke of the robot is felt so strongly (170 deg/s, 0.2 m: 0.2 g, its start 1.5 g), and every landing is."""
AROUND_RELEASE_S = 0.5
"""The fall begins this near to the switches' release, or it is another event."""
HELD_S = 0.05
"""The magnet may hold the robot so long after the fall began; and the logger's landing may lie so far from the felt."""
# The level at rest is read clear of the time in which the fall may have begun.
_AT_REST_S = (-1.5, -0.6)
_IN_FALL_S = (0.1, 0.6)
_MIN_FORCE_DROP = 0.5
"""Of the force before the release, at least this part must be gone in the fall."""
_UNKNOWN_SHAPE = 0.3
"""Part of the low-pass's delay by which a step's middle may lie elsewhere: 1 - ln 2 for a single pole."""
LATEST_LANDING_S = FALL_US / 1e6 + 2.5


@dataclass(frozen=True, slots=True)
class Instant:
    """A moment that several accelerometers felt, less the delay of their low-pass.

    Attributes:
        t_s: Median of the bodies, after the release by the switches.
        std_s: Sampling, and the low-pass whose form is not known.
        by_body_s: (4,) NaN where a body did not feel it.
    """

    t_s: float
    std_s: float
    by_body_s: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class FallInstants:
    """Beginning and end of the fall, as felt and as logged, after the release by the switches.

    Attributes:
        release: Felt by the accelerometers; None if they felt no fall begin.
        release_std_s: Of zero, the switches' release: 0 if its edges tell it.
        landing: Felt; None if they felt none.
        landing_logged_s: As the logger has it, by a shock; None without.
        findings: What does not agree, one sentence each.
    """

    release: Instant | None
    release_std_s: float
    landing: Instant | None
    landing_logged_s: float | None
    findings: tuple[str, ...]


def fall_instants(log: DropLog, samples: CalibratedSamples) -> FallInstants:
    """Find release and landing in the felt forces, compared with the switches and the logger's note.

    The log has a release; its samples may come through any calibration.
    """
    force, low_pass = samples.specific_force_m_s2, LowPass.of(log.header)
    release = release_felt(log.t_s, force, low_pass)
    landing = landing_felt(log.t_s, force, samples.clipped, low_pass)
    logged = [log.seconds(event.t_us) for event in log.events if event.name == "landing" and event.arg == 1]
    logged_s = next((t_s for t_s in logged if t_s > 0.0), None)
    # The stated uncertainty is the greatest error: a uniform distribution's deviation is that over sqrt(3).
    release_std_s = (log.release_uncertainty_us or 0) / 1e6 / 3**0.5
    findings = []
    if release is None:
        findings.append(
            "The accelerometers felt no fall begin near the release: the robot was not let go into one."
        )
    # The magnet may hold on for HELD_S after the capsule fell: beyond that the two disagree.
    elif abs(release.t_s) > HELD_S + 3.0 * float(np.hypot(release.std_s, release_std_s)):
        findings.append(
            f"The accelerometers felt the fall begin {1e3 * abs(release.t_s):.0f} ms "
            f"{'before' if release.t_s < 0.0 else 'after'} the switches opened: "
            + ("the magnet held the robot so long." if release.t_s < 0.0 else "the robot hung on after that.")
        )
    if landing is None:
        findings.append(f"The accelerometers felt no landing, no force above {SHOCK_G:g} g.")
    elif logged_s is not None and abs(logged_s - landing.t_s) > HELD_S:
        findings.append(
            f"The landing was felt at {landing.t_s:.3f} s, but the logger noted it at {logged_s:.3f} s."
        )
    return FallInstants(release, release_std_s, landing, logged_s, tuple(findings))


def release_felt(t_s: FloatArray, force_m_s2: FloatArray, low_pass: LowPass) -> Instant | None:
    """Find when the force fell to the middle between its levels before and in the fall; None if never.

    Times (n,) ascend, after the release; specific forces (n, 4, 3) are NaN where invalid.
    """
    magnitude = np.linalg.norm(force_m_s2, axis=2)
    return _median([_fell(t_s, body) for body in magnitude.T], t_s, low_pass)


def landing_felt(
    t_s: FloatArray, force_m_s2: FloatArray, clipped: BoolArray, low_pass: LowPass
) -> Instant | None:
    """Find when the force first exceeded `SHOCK_G` once a landing was possible; None if it never did.

    A soft cushion takes some milliseconds to push so hard. Times (n,) ascend, after the release; specific
    forces (n, 4, 3) are NaN where invalid; `clipped` (n, 4) is True where the force may exceed full scale,
    which counts as a shock.
    """
    magnitude = np.linalg.norm(force_m_s2, axis=2)
    felt = [_find_shock(t_s, body, full) for body, full in zip(magnitude.T, clipped.T, strict=True)]
    return _median(felt, t_s, low_pass)


def _fell(t_s: FloatArray, magnitude: FloatArray) -> float:
    """Find the last time near the release that the force fell through the middle; NaN if it did not."""
    is_finite = np.isfinite(magnitude)
    t_s, magnitude = t_s[is_finite], magnitude[is_finite]
    before, after = (magnitude[(t_s >= a) & (t_s < b)] for a, b in (_AT_REST_S, _IN_FALL_S))
    if not len(before) or not len(after):
        return float("nan")
    # Medians: neither a knock at rest nor a stroke in the fall moves a level.
    high, low = float(np.median(before)), float(np.median(after))
    # The force stayed: this body felt no fall begin.
    if low > (1.0 - _MIN_FORCE_DROP) * high:
        return float("nan")
    middle = (high + low) / 2.0
    near = np.abs(t_s) <= AROUND_RELEASE_S
    down = np.flatnonzero((magnitude[:-1] >= middle) & (magnitude[1:] < middle) & near[1:])
    return _crossing_time(t_s, magnitude, int(down[-1]), middle) if len(down) else float("nan")


def _find_shock(t_s: FloatArray, magnitude: FloatArray, clipped: BoolArray) -> float:
    is_finite = np.isfinite(magnitude)
    t_s, magnitude, clipped = t_s[is_finite], magnitude[is_finite], clipped[is_finite]
    level = SHOCK_G * STANDARD_GRAVITY_M_S2
    # A clipped axis is at full scale or beyond: it counts as a shock, whatever the magnitude says.
    hard = clipped | (magnitude >= level)
    first = np.flatnonzero(hard & (t_s >= LANDING_EARLIEST_US / 1e6) & (t_s <= LATEST_LANDING_S))
    if not len(first):
        return float("nan")
    row = int(first[0])
    # Without a sample below the level just before, there is no edge to interpolate on.
    if row == 0 or not magnitude[row - 1] < level <= magnitude[row]:
        return float(t_s[row])
    return _crossing_time(t_s, magnitude, row - 1, level)


def _crossing_time(t_s: FloatArray, magnitude: FloatArray, row: int, level: float) -> float:
    """Interpolate the time at which the line from a row to the next meets the level."""
    share = (magnitude[row] - level) / (magnitude[row] - magnitude[row + 1])
    return float(t_s[row] + share * (t_s[row + 1] - t_s[row]))


def _median(felt_s: list[float], t_s: FloatArray, low_pass: LowPass) -> Instant | None:
    delay_s = low_pass.accel_delay_s
    # The low-pass shows every step late by its delay: take that off.
    by_body_s = np.array(felt_s) - delay_s
    if np.isnan(by_body_s).all():
        return None
    # The median of the bodies: one that was touched, or did not feel it, does not move it.
    middle_s = float(np.nanmedian(by_body_s))
    nearby = np.abs(t_s - middle_s) <= AROUND_RELEASE_S
    # The longest step about the raw moment, as seen before the delay came off: a sample may be lost there.
    step_s = float(np.max(np.diff(t_s[nearby]), initial=0.0, where=_around(t_s[nearby], middle_s + delay_s)))
    # Uniform within a sampling step, and a low-pass whose shape is not known.
    std_s = float(np.hypot(step_s / 12**0.5, _UNKNOWN_SHAPE * delay_s))
    return Instant(middle_s, std_s, tuple(by_body_s.tolist()))


def _around(t_s: FloatArray, moment_s: float) -> BoolArray:
    """(n - 1,) the step between two samples that holds a moment, and its neighbours."""
    after = int(np.searchsorted(t_s, moment_s))
    return np.abs(np.arange(len(t_s) - 1) - (after - 1)) <= 1
