"""An IMU as a part: what its data sheet says of its errors, from a file, and robots that have it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.config import ConfigKind, read_config
from tfsat_host.emulated.imperfections import Imperfections, draw, skewed
from tfsat_host.emulated.library import EmulationError
from tfsat_host.protocol.limits import GYRO_RANGE_FACTORY_DEG_S
from tfsat_host.units import STANDARD_GRAVITY_M_S2

_SHIPPED = {file.stem: file for file in sorted(Path(__file__).with_name("imus").glob("*.toml"))}
_KIND = ConfigKind(
    name="IMU file",
    error=EmulationError,
    meaning="No robot with that IMU was made.",
    cure=f"Name a file, or an IMU that tfsat knows: {', '.join(_SHIPPED)}.",
    format=None,
)
_TABLES = ("gyro", "accel", "die")
_MAX_DEVIATION = 0.618
"""Of the Allan deviation of a first-order Gauss-Markov process, over its standard deviation: at 1.89 correlation times
0.437 q sqrt(T) with q = std sqrt(2 / T) (IEEE Std 952-1997, annex C)."""


@dataclass(frozen=True, slots=True)
class ImuPart:
    """One kind of IMU. `..._std` are standard deviations from part to part and from axis to axis.

    The emulated chip stays a MPU-6050 at its registers, whatever part this is: what a part's errors make of the truth
    goes through that chip's range, resolution and low-pass, which `logger-settings` chooses. So ranges, resolutions and
    bandwidths stand here to be read, and a part with finer resolution than 16 bits shows no finer.

    Attributes:
        name: Maker and type.
        gyro_range_deg_s: Full scale; at least the emulated chip's, which is what saturates.
        gyro_lsb_per_deg_s: Resolution; not emulated.
        gyro_bandwidth_hz: Of the part without filters; not emulated.
        gyro_noise_deg_s_rthz: White noise density.
        gyro_bias_stability_deg_h: Least Allan deviation.
        gyro_bias_std_deg_s: Bias at power-up.
        gyro_bias_slope_std_deg_s_c: Change of the bias with the die's temperature.
        gyro_scale_std: Scale factor, reading over truth, about 1.
        gyro_misalignment_std_deg: Of each axis in the housing, towards each of the others; the housing's mounting
            comes on top.
        gyro_g_sensitivity_std_deg_s_g: Of each axis to the force along each.
        gyro_shock_limit_g: A harder blow drives the proof masses against their stops.
        accel_range_g: Full scale; not emulated.
        accel_lsb_per_g: Resolution; not emulated.
        accel_noise_g_rthz: White noise density.
        die_warming_c: By how much the die gets warmer in the end than at power-up.
        die_warming_s: Time constant of that.
        sources: Where each figure is from, by the attribute's name.
    """

    name: str
    gyro_range_deg_s: float
    gyro_lsb_per_deg_s: float
    gyro_bandwidth_hz: float
    gyro_noise_deg_s_rthz: float
    gyro_bias_stability_deg_h: float
    gyro_bias_std_deg_s: float
    gyro_bias_slope_std_deg_s_c: float
    gyro_scale_std: float
    gyro_misalignment_std_deg: float
    gyro_g_sensitivity_std_deg_s_g: float
    gyro_shock_limit_g: float
    accel_range_g: float
    accel_lsb_per_g: float
    accel_noise_g_rthz: float
    die_warming_c: float
    die_warming_s: float
    sources: Mapping[str, str]


def load_imu(name_or_path: str | Path) -> ImuPart:
    """Load an IMU that tfsat brings along by its name, or any from a file.

    Raises:
        EmulationError: there is no such IMU or file, or the file has missing, unknown or invalid entries.
    """
    top = read_config(_SHIPPED.get(str(name_or_path), Path(name_or_path)), _KIND)
    top.only(" ".join(("name", *_TABLES)))
    figures: dict[str, float] = {}
    sources: dict[str, str] = {}
    for name in _TABLES:
        # An attribute's prefix names its table: gyro_noise_... stands in [gyro] as noise_...
        keys = [
            field.name.removeprefix(f"{name}_") for field in fields(ImuPart) if field.name.startswith(name)
        ]
        table = top.table(name, " ".join(keys))
        for key in keys:
            # Each figure must name its source: a data sheet's section can then be checked.
            figure = table.table(key, "value source", '{ value = ..., source = "..." }')
            least, above = (0.0, -math.inf) if _may_be_zero(key) else (-math.inf, 0.0)
            figures[f"{name}_{key}"] = figure.number("value", least=least, above=above)
            sources[f"{name}_{key}"] = figure.text("source")
    part = ImuPart(name=top.text("name"), **figures, sources=sources)
    if part.gyro_range_deg_s < GYRO_RANGE_FACTORY_DEG_S:
        raise EmulationError(
            what=f"{part.name} shows {part.gyro_range_deg_s:g} deg/s at most (range_deg_s of [gyro]).",
            meaning=f"The emulated chip shows {GYRO_RANGE_FACTORY_DEG_S} deg/s: it would not saturate where that IMU "
            "does. No robot with it was made.",
            next_step="Name an IMU with that range at least; a drop reaches 200 deg/s.",
        )
    return part


def imperfections_with(part: ImuPart, seed: int, robot: Imperfections | None = None) -> Imperfections:
    """Return a robot whose four IMUs are this part; all else, including their mounting, is unchanged.

    Two parts with the same seed get the same random draws, each scaled by its own standard deviations, so two
    such robots differ in nothing but the part.

    Args:
        part: The IMU part to use.
        seed: For the parts' errors.
        robot: The robot to fit them to; None: `draw(seed)`.
    """
    as_it_comes = draw(seed) if robot is None else robot
    random = np.random.default_rng([seed, 6])
    # Unit normals, always as many, each (4 IMUs, 3 axes): two parts of a seed differ by their scales alone.
    bias, slope, scale, axes = random.standard_normal((4, 4, 3))
    sensitivity = random.standard_normal((4, 3, 3))
    skew = random.standard_normal((4, 3))
    # Half of how the axes lie in the housing turns all of them, half skews them against each other.
    half_rad = np.deg2rad(part.gyro_misalignment_std_deg) / 2.0**0.5
    turned = Rotation.from_rotvec(half_rad * axes).as_matrix()
    return replace(
        as_it_comes,
        mounting=as_it_comes.mounting @ turned,
        gyro_bias_rad_s=np.deg2rad(part.gyro_bias_std_deg_s) * bias,
        gyro_bias_slope_rad_s_c=np.deg2rad(part.gyro_bias_slope_std_deg_s_c) * slope,
        gyro_scale=1.0 + part.gyro_scale_std * scale,
        gyro_cross_axis=skewed(half_rad * skew),
        gyro_noise_rad_s_rthz=float(np.deg2rad(part.gyro_noise_deg_s_rthz)),
        gyro_g_sensitivity_rad_s_g=np.deg2rad(part.gyro_g_sensitivity_std_deg_s_g) * sensitivity,
        gyro_wander_rad_s=float(np.deg2rad(wander_std_deg_s(part))),
        gyro_shock_limit_g=part.gyro_shock_limit_g,
        accel_noise_m_s2_rthz=part.accel_noise_g_rthz * STANDARD_GRAVITY_M_S2,
        warming_c=part.die_warming_c,
        warming_s=part.die_warming_s,
    )


def wander_std_deg_s(part: ImuPart) -> float:
    """Standard deviation of the wandering whose greatest Allan deviation is the part's bias stability."""
    return part.gyro_bias_stability_deg_h / 3600.0 / _MAX_DEVIATION


def _may_be_zero(key: str) -> bool:
    """Return whether a value of the part may be zero.

    An error may; a range, a resolution or a time constant may not.
    """
    return key.endswith(("_std", "warming_c")) or "_std_" in key or key.startswith(("noise", "bias", "shock"))
