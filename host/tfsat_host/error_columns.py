"""An error as `--json` has it: what happened, what it means, what to type next, and what else the error knows."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from tfsat_host.errors import TfsatError
from tfsat_host.quantity import Column, Columns, fields

_ERROR = fields("what meaning next_step")
_CODE: Columns = (Column("code", of=lambda error: str(error.code)),)
_REFUSAL: Columns = (Column("code"), Column("number", of=lambda error: int(error.code)))


def error_columns(error: TfsatError) -> Columns:
    """Return the columns of an error for `--json`, its own `columns` among them.

    `code` is a stable name where the error has one, `number` that of a board's refusal.
    """
    code = () if error.code is None else _REFUSAL if isinstance(error.code, IntEnum) else _CODE
    return (*_ERROR, *error.columns, *code)


def or_error(columns: Columns) -> Callable[[Any], Columns]:
    """Choose the columns for what may be an error instead of a result: `error` then."""
    failed = (Column("error", of=lambda error: error, columns=error_columns),)
    return lambda row: failed if isinstance(row, TfsatError) else columns
