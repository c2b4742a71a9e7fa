"""An IMU as a part: what its data sheet says of its errors, from a file, and robots that have it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.emulated.errors import EmulationError
from tfsat_host.emulated.imperfections import Imperfections, draw
from tfsat_host.toml_lines import line_of
from tfsat_host.toml_reading import TomlError, read_toml
from tfsat_host.toml_values import finite, shown
from tfsat_host.units import STANDARD_GRAVITY_M_S2

_FOLDER = Path(__file__).with_name("imus")
_TABLES = ("gyro", "accel", "die")
_GREATEST_DEVIATION = 0.618
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
        gyro_range_deg_s: Full scale; not emulated.
        gyro_lsb_per_deg_s: Resolution; not emulated.
        gyro_bandwidth_hz: Of the part without filters; not emulated.
        gyro_noise_deg_s_rthz: White noise density.
        gyro_bias_stability_deg_h: Least Allan deviation.
        gyro_bias_std_deg_s: Bias at power-up.
        gyro_bias_slope_std_deg_s_c: Change of the bias with the die's temperature.
        gyro_scale_std: Scale factor, reading over truth, about 1.
        gyro_misalignment_std_deg: Of the axes in the housing, beside how the housing is mounted.
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


def shipped_imus() -> tuple[str, ...]:
    """Names of the IMUs that tfsat brings along, in alphabetical order."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.toml")))


def load_imu(name_or_path: str | Path) -> ImuPart:
    """An IMU of `shipped_imus()` by name, or of a file.

    Raises:
        EmulationError: there is no such IMU or file, or the file says too little, too much or nonsense.
    """
    file = Path(name_or_path)
    if str(name_or_path) in shipped_imus():
        file = _FOLDER / f"{name_or_path}.toml"
    try:
        text, values = read_toml(file)
    except OSError as error:
        raise _refusal(
            f"The IMU {name_or_path} cannot be read: {error.strerror or error}",
            f"Name a file, or an IMU that tfsat knows: {', '.join(shipped_imus())}.",
        ) from None
    except TomlError as error:
        raise _refusal(f"{file} {error}", "Mend the file.") from None
    return _ImuFile(file, text, values).part()


def imperfections_with(part: ImuPart, seed: int, robot: Imperfections | None = None) -> Imperfections:
    """A robot whose four IMUs are such parts; all else, their mounting included, is that of another one.

    Two parts with the same seed have the same draws, each by its own standard deviations: what differs between the
    two robots is the part and nothing else.

    Args:
        part: That it gets.
        seed: Of the parts' errors.
        robot: That gets them; None: `draw(seed)`.
    """
    as_it_comes = draw(seed) if robot is None else robot
    random = np.random.default_rng([seed, 6])
    bias, slope, scale, axes = random.standard_normal((4, 4, 3))
    sensitivity = random.standard_normal((4, 3, 3))
    turned = Rotation.from_rotvec(np.deg2rad(part.gyro_misalignment_std_deg) * axes).as_matrix()
    return replace(
        as_it_comes,
        mounting=as_it_comes.mounting @ turned,
        gyro_bias_rad_s=np.deg2rad(part.gyro_bias_std_deg_s) * bias,
        gyro_bias_slope_rad_s_c=np.deg2rad(part.gyro_bias_slope_std_deg_s_c) * slope,
        gyro_scale=1.0 + part.gyro_scale_std * scale,
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
    return part.gyro_bias_stability_deg_h / 3600.0 / _GREATEST_DEVIATION


class _ImuFile:
    """Takes a file's values apart; what is wrong is told with its line."""

    def __init__(self, file: Path, text: str, values: Mapping[str, object]) -> None:
        self._file = file
        self._text = text
        self._values = values

    def part(self) -> ImuPart:
        """All that it must say, and nothing else."""
        name = self._values.get("name")
        if not isinstance(name, str) or not name:
            self._fail("", "name", "the IMU's name is missing", 'Add `name = "..."`.')
        figures: dict[str, float] = {}
        sources: dict[str, str] = {}
        for field in fields(ImuPart):
            table, _, key = field.name.partition("_")
            if table in _TABLES:
                figures[field.name], sources[field.name] = self._figure(table, key)
        self._refuse_others({"name", *_TABLES}, self._values, "")
        for table in _TABLES:
            known = {name.removeprefix(f"{table}_") for name in figures if name.startswith(f"{table}_")}
            self._refuse_others(known, self._table(table), table)
        return ImuPart(name=name, **figures, sources=sources)

    def _figure(self, table: str, key: str) -> tuple[float, str]:
        found = self._table(table).get(key)
        cure = f'Write `{key} = {{ value = ..., source = "..." }}` below [{table}].'
        if found is None:
            self._fail(table, key, "is missing", cure)
        if not isinstance(found, dict) or set(found) != {"value", "source"}:
            self._fail(table, key, f"{shown(found)} is not a value with its source", cure)
        number, source = finite(found["value"]), found["source"]
        if number is None or number < 0.0 or (number == 0.0 and not _may_be_zero(key)):
            self._fail(
                table, key, f"{shown(found['value'])} is no value of it", "Give it a number above zero."
            )
        if not isinstance(source, str) or not source:
            self._fail(table, key, "has no source", "Say where the value is from, or that it is assumed.")
        return number, source

    def _table(self, table: str) -> Mapping[str, object]:
        values = self._values.get(table)
        if not isinstance(values, dict):
            self._fail("", table, "is no table", f"Add a table [{table}].")
        return values

    def _refuse_others(self, known: set[str], values: Mapping[str, object], table: str) -> None:
        for key in values:
            if key not in known:
                self._fail(table, key, "is not known", f"Known are: {', '.join(sorted(known))}.")

    def _fail(self, table: str, key: str, problem: str, cure: str) -> NoReturn:
        line = line_of(self._text, table, 0, key) or 1
        entry = f"{table}.{key}" if table else key
        raise _refusal(f"{self._file}:{line}: {entry}: {problem}", cure)


def _may_be_zero(key: str) -> bool:
    """An error may be none; a range, a resolution or a time constant may not."""
    return key.endswith(("_std", "warming_c")) or "_std_" in key or key.startswith(("noise", "bias", "shock"))


def _refusal(what: str, cure: str) -> EmulationError:
    return EmulationError(what=f"{what}.", meaning="No robot with that IMU was made.", next_step=cure)
