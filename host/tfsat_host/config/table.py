"""Typed access to a TOML file's entries, with errors that name file, line, entry, what was expected and the cure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from enum import StrEnum
from typing import TYPE_CHECKING, NoReturn, TypeVar, cast

from tfsat_host.config.places import Path, line_of
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_SHOWN_CHARACTERS = 60
MAX_NUMBER = 1e12
"""In magnitude, of any number in a file, in the file's units: nothing that a lab has is greater, and squares of it and
products stay far inside the range of floats."""
_Choice = TypeVar("_Choice", str, int)


class Fault(StrEnum):
    """What can be wrong with any file."""

    UNREADABLE = "file-unreadable"
    NOT_TEXT = "file-not-text"
    SYNTAX = "file-syntax"
    FORMAT = "file-format"
    UNKNOWN_KEY = "file-unknown-key"
    MISSING_KEY = "file-missing-key"
    WRONG_TYPE = "file-wrong-type"


@dataclass(frozen=True)
class ConfigKind:
    """One kind of file, and the words of its errors.

    Attributes:
        name: Such as `robot file`.
        error: Made of `what`, `meaning` and `next_step`; of `code` too, where there are `codes`.
        meaning: What follows from a file that cannot be used.
        cure: What to do about a file that is wrong as a whole.
        format: Key and number that say which format the file has; None: such files do not say.
        codes: The error's own names of `Fault`s, where they differ; None: its errors have no codes.
        computed: A program writes such files: the cure of a wrong entry is `cure`, not another value.
        bytes_max: A larger file is something else.
    """

    name: str
    error: Callable[..., TfsatError]
    meaning: str
    cure: str
    format: tuple[str, int] | None = ("format", 1)
    codes: Mapping[StrEnum, StrEnum] | None = None
    computed: bool = False
    bytes_max: int = 4_000_000

    def refusal(self, what: str, code: StrEnum, cure: str = "") -> TfsatError:
        """Build the error of a file of this kind."""
        coded = {} if self.codes is None else {"code": self.codes.get(code, code)}
        return self.error(what=what, meaning=self.meaning, next_step=cure or self.cure, **coded)


class Table:
    """One table of a file.

    Args:
        kind: Of the file.
        source: The file, as errors name it.
        text: All of it.
        path: Of the table in it; empty for the entries above all tables.
        values: What was parsed.

    Attributes:
        source, file_text: Likewise.

    Every method that reads an entry raises the kind's error where the entry is missing or is not what it should be.
    """

    def __init__(
        self, kind: ConfigKind, source: str, text: str, path: Path, values: Mapping[str, object]
    ) -> None:
        self._kind = kind
        self.source = source
        self.file_text = text
        self._path = path
        self._values = values
        self._known_as: tuple[int, str] = (0, "")  # so many parts of the path, in words

    def fail(self, key: str, problem: str, cure: str = "", code: StrEnum = Fault.WRONG_TYPE) -> NoReturn:
        """Raises the error of `key`, which may have dots for what lies inside; no cure: the kind's."""
        path = (*self._path, *key.split("."))
        # Call a numbered table by its number; only what lies inside it is spelled out as a path.
        parts, words = self._known_as
        place = ", ".join(filter(None, (words, _in_words(path[parts:]))))
        where = f"{self.source}:{line_of(self.file_text, path)}: {place}"
        raise self._kind.refusal(f"{where}: {problem}.", code, cure)

    def only(self, keys: str) -> None:
        """Refuses every key but these, with spaces between them: a misspelt one must not be silently ignored."""
        for key in self._values:
            if key not in keys.split():
                cure = f"Remove it or correct its name; known are: {', '.join(keys.split())}."
                self.fail(_shorten_text(key), "is not known here", cure, Fault.UNKNOWN_KEY)

    def has(self, key: str) -> bool:
        """Return whether the table has this entry."""
        return key in self._values

    def value(self, key: str, requirement: str) -> object:
        """Return the parsed entry; `requirement` says in words what it should be, for the error if it is missing."""
        if key not in self._values:
            self.fail(key, "is missing", self._cure(f"Add `{key}`: {requirement}."), Fault.MISSING_KEY)
        return self._values[key]

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        above: float = -math.inf,
        least: float = -math.inf,
        most: float = math.inf,
        finite: bool = True,
        requirement: str = "",
    ) -> float:
        """Return a number within limits; `default` if the entry is missing.

        Without `finite`, infinity and NaN are accepted as well.
        """
        limits = (
            ("above", above, -math.inf),
            ("of at least", least, -math.inf),
            ("of at most", most, math.inf),
        )
        limited = " and".join(f" {words} {limit:g}" for words, limit, none in limits if limit != none)
        requirement = requirement or f"a{' finite' * (finite and not limited)} number{limited}"
        if default is not None and not self.has(key):
            return default
        number = _number(self.value(key, requirement))
        if number is None or (
            finite and not (math.isfinite(number) and above < number and least <= number <= most)
        ):
            self._wrong(key, requirement)
        return number

    def integer(
        self, key: str, least: float = -math.inf, most: float = math.inf, requirement: str = ""
    ) -> int:
        """Return an integer from `least` to `most`."""
        requirement = (
            requirement or f"a whole number{'' if math.isinf(least) else f' from {least} to {most}'}"
        )
        value = self.value(key, requirement)
        # Python's bool is an int: true must not pass for 1.
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            self._wrong(key, requirement)
        return value

    def choice(self, key: str, choices: Sequence[_Choice]) -> _Choice:
        """Return the entry if it is one of `choices`, else raise the kind's error."""
        requirement = " or ".join(shorten_value(choice) for choice in choices) or "one of none"
        value = self.value(key, requirement)
        # Compare types too: 1.0 and true equal 1 in Python.
        if not any(type(value) is type(choice) and value == choice for choice in choices):
            self._wrong(key, requirement)
        return cast(_Choice, value)

    def text(self, key: str, default: str | None = None, *, empty: bool = False) -> str:
        """Return a text; it must have at least one character unless `empty` is allowed."""
        if default is not None and not self.has(key):
            return default
        value = self.value(key, "a text in quotes")
        if not isinstance(value, str) or not (value or empty):
            self._wrong(key, "a text in quotes")
        unseen = next((sign for sign in value if not sign.isprintable() and sign not in "\n\t"), None)
        if unseen is not None:
            self.fail(
                key,
                f"holds U+{ord(unseen):04X}, a character that cannot be seen",
                "Write the text again, without control characters.",
            )
        return value

    def flag(self, key: str, requirement: str = "true or false") -> bool:
        """True or false."""
        value = self.value(key, requirement)
        if not isinstance(value, bool):
            self._wrong(key, requirement)
        return value

    def time(self, key: str) -> datetime:
        """Return a time in UTC; the entry must state its time zone."""
        requirement = "a time with its zone, such as 2026-07-01T09:30:00Z"
        value = self.value(key, requirement)
        if not isinstance(value, datetime) or value.tzinfo is None:
            self._wrong(key, requirement)
        return value.astimezone(UTC)

    def numbers(self, key: str, *shape: int, requirement: str = "") -> list[float]:
        """Finite numbers in rows, as many as `shape` says, row by row; -1: one at least."""
        requirement = (
            requirement or f"{' x '.join('n' if size < 0 else str(size) for size in shape)} finite numbers"
        )
        numbers = _flat(self.value(key, requirement), shape)
        if numbers is None:
            self._wrong(key, requirement)
        return numbers

    def array(self, key: str, *shape: int, requirement: str = "") -> NDArray[np.float64]:
        """Return the numbers as `numbers` reads them, as an array of that shape."""
        import numpy as np  # an upload must not wait for it

        return np.reshape(
            np.array(self.numbers(key, *shape, requirement=requirement), dtype=np.float64), shape
        )

    def table(self, key: str, keys: str = "", requirement: str = "a table of named values") -> Table:
        """Return a table inside this one that holds no entries but `keys`; without `keys`, any."""
        value = self.value(key, requirement)
        if not isinstance(value, dict):
            self._wrong(key, requirement)
        return self._inside((key,), value, keys)

    def tables(self, key: str, keys: str = "", *, needed: bool = False) -> list[Table]:
        """Return all `[[key]]` tables, each holding no entries but `keys`; without `keys`, any.

        Unless they are `needed`, there may be none.
        """
        requirement = f"tables, each below its own line [[{key}]]"
        value = self.value(key, requirement) if needed or self.has(key) else []
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self._wrong(key, requirement)
        return [self._inside((key, index), item, keys) for index, item in enumerate(value)]

    def tables_by_number(
        self,
        key: str,
        of: str,
        count: int,
        keys: str = "",
        *,
        code: StrEnum = Fault.WRONG_TYPE,
        require_all: bool = True,
    ) -> dict[int, Table]:
        """Return all `[[key]]` tables by the number in their entry `of`, sorted: each of 1 to `count` once.

        Without `require_all`, some may be missing. `code` is the error code for a missing or duplicate number.
        """
        tables: dict[int, Table] = {}
        for table in self.tables(key, keys):
            number = table.integer(of, 1, count)
            if number in tables:
                table.fail(of, f"{of} {number} is described twice", "Keep one of them.", code)
            tables[number] = table
            # From here on its errors name it by this number.
            table._known_as = (len(table._path), f"{'' if key == of else f'{key} of '}{of} {number}")
        missing = [str(number) for number in range(1, count + 1) if require_all and number not in tables]
        if missing:
            cure = self._cure(f"Describe each of {of} 1 to {count} below its own line [[{key}]].")
            self.fail(key, f"there is no [[{key}]] of {of} {' and '.join(missing)}", cure, code)
        return dict(sorted(tables.items()))

    def _inside(self, path: Path, values: Mapping[str, object], keys: str) -> Table:
        table = Table(self._kind, self.source, self.file_text, (*self._path, *path), values)
        table._known_as = self._known_as
        if keys:
            table.only(keys)
        return table

    def _wrong(self, key: str, requirement: str) -> NoReturn:
        value = self._values[key]
        problem = (
            f"is beyond {MAX_NUMBER:g}: no number here is so large"
            if _is_huge(value)
            else f"is not {requirement}"
        )
        self.fail(key, f"{shorten_value(value)} {problem}", self._cure(f"Give `{key}` {requirement}."))

    def _cure(self, cure: str) -> str:
        return "" if self._kind.computed else cure


def _in_words(path: Path) -> str:
    """Format a path in words, such as `joint 3, servo.start_deg`."""
    words = ""
    for part in path:
        words += f" {part + 1}, " if isinstance(part, int) else f".{part}"
    return words.replace(", .", ", ").removeprefix(".")


def _is_huge(value: object) -> bool:
    """Return whether a number, or one inside a list, exceeds the allowed magnitude."""
    if isinstance(value, list):
        return any(map(_is_huge, value))
    return isinstance(value, int | float) and MAX_NUMBER < abs(value) < math.inf


def _number(value: object) -> float | None:
    """Convert a value to a float; None if it is no number or implausibly large.

    Infinite numbers are left to the caller.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    # NaN, unequal to itself, and infinities pass: the caller decides about them.
    return float(value) if abs(value) <= MAX_NUMBER or value != value or abs(value) == math.inf else None


def _flat(value: object, shape: tuple[int, ...]) -> list[float] | None:
    """Row by row; None if one is no finite number, or they are too few or too many."""
    if not shape:
        number = _number(value)
        return None if number is None or not math.isfinite(number) else [number]
    # A size below 0 takes rows of any number but zero.
    if not isinstance(value, list) or not value or len(value) != (shape[0] if shape[0] >= 0 else len(value)):
        return None
    numbers: list[float] = []
    for item in value:
        row = _flat(item, shape[1:])
        if row is None:
            return None
        numbers += row
    return numbers


def shorten_value(value: object) -> str:
    """Format a value for a message, shortened if it is long."""
    try:
        text = str(value).lower() if isinstance(value, bool) else repr(value)
        text = value.isoformat() if isinstance(value, date) else text
    except (ValueError, RecursionError):  # an integer of thousands of digits; lists hundreds deep
        return "what stands there"
    return _shorten_text(text)


def _shorten_text(text: str) -> str:
    return text if len(text) <= _SHOWN_CHARACTERS else text[:_SHOWN_CHARACTERS] + "…"
