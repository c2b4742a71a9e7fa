"""One table of the settings' file: hands out numbers in the board's units, and says where an entry stands."""

from __future__ import annotations

from collections.abc import Mapping

from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.servo_settings.errors import SettingsDefect, SettingsError
from tfsat_host.toml_lines import line_of
from tfsat_host.toml_values import shortened, shown
from tfsat_host.units import exact

_LARGEST = 1e9
"""Beyond every unit's range, and far from where a float's steps are larger than what the board resolves."""
_WANTED = {
    "frame_ms": "Give milliseconds as a number, such as frame_ms = 20.",
    "zero_us": "Give the pulse width at 0 deg in microseconds, such as zero_us = 1000.",
    "us_per_deg": "Give microseconds for each degree, such as us_per_deg = 11.111.",
    "reversed": "Write reversed = false, or true where shorter pulses open the joint.",
    "limits_deg": "Give two numbers in degrees, such as limits_deg = [0, 90].",
    "servo": "Describe each joint's servo below its own line [[servo]].",
    "joint": f"Give a joint's number, 1 to {JOINT_COUNT}.",
}
_UNITS = {"frame_ms": "ms", "zero_us": "us", "us_per_deg": "us per deg", "limits_deg": "deg"}


class Entries:
    """The entries of one table.

    Args:
        source: The file, as errors name it.
        text: All of the file.
        table: The table's name; empty for what stands above all tables.
        index: Which one of that name, from 0.
        values: What was parsed.
    """

    def __init__(self, source: str, text: str, table: str, index: int, values: Mapping[str, object]) -> None:
        self._source = source
        self._text = text
        self._table = table
        self._index = index
        self._values = values

    def error(self, code: SettingsDefect, key: str, problem: str, cure: str) -> SettingsError:
        """The error for the entry `key`, with file and line."""
        line = line_of(self._text, self._table, self._index, key)
        where = self._source if line is None else f"{self._source}:{line}"
        entry = f"{self._table} {self._index + 1}, {key}" if self._table else key
        return SettingsError(code, what=f"{where}: {entry}: {problem}.", next_step=cure)

    def allow(self, keys: tuple[str, ...]) -> None:
        """Refuses every other key."""
        for key in self._values:
            if key not in keys:
                raise self.error(
                    SettingsDefect.FILE_UNKNOWN_KEY,
                    shortened(key),
                    "is not known here",
                    f"Remove it or correct its name; known are: {', '.join(keys)}.",
                )

    def require(self, key: str, cure: str) -> object:
        """The raw value of an entry that must be there."""
        if key not in self._values:
            raise self.error(SettingsDefect.FILE_MISSING_KEY, key, "is missing", cure)
        return self._values[key]

    def tables(self, key: str) -> list[Entries]:
        """All `[[key]]` tables; none is an empty list."""
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self._wrong_type(key, value)
        return [Entries(self._source, self._text, key, index, item) for index, item in enumerate(value)]

    def joint(self) -> int:
        """The joint's number."""
        value = self.require("joint", _WANTED["joint"])
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= JOINT_COUNT:
            raise self._wrong_type("joint", value)
        return value

    def flag(self, key: str) -> bool:
        """True or false."""
        value = self.require(key, _WANTED[key])
        if not isinstance(value, bool):
            raise self._wrong_type(key, value)
        return value

    def scaled(self, key: str, scale: int, notices: list[str]) -> int:
        """A number times `scale`, to the nearest whole (half to even); what was rounded is noted."""
        return self._to_whole(key, self.require(key, _WANTED[key]), scale, notices)

    def scaled_pair(self, key: str, scale: int, notices: list[str]) -> tuple[int, int]:
        """Two numbers, likewise."""
        value = self.require(key, _WANTED[key])
        if not isinstance(value, list) or len(value) != 2:
            raise self._wrong_type(key, value)
        first, second = (self._to_whole(key, item, scale, notices) for item in value)
        return first, second

    def _to_whole(self, key: str, value: object, scale: int, notices: list[str]) -> int:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong_type(key, value)
        if not abs(value) <= _LARGEST:  # nan is not, either
            raise self._wrong_type(key, value)
        wanted = exact(value) * scale
        whole = round(wanted)
        if whole != wanted:
            place = f"{self._table} {self._index + 1}: {key}" if self._table else key
            notices.append(
                f"{place} was rounded from {value} to {whole / scale:g} {_UNITS[key]}: "
                f"the board resolves {1 / scale:g} {_UNITS[key]}."
            )
        return whole

    def _wrong_type(self, key: str, value: object) -> SettingsError:
        return self.error(SettingsDefect.FILE_WRONG_TYPE, key, f"{shown(value)} cannot be", _WANTED[key])
