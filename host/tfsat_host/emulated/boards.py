"""The emulated robot's boards, and what can restart one."""

from __future__ import annotations

from enum import IntEnum


class BoardIndex(IntEnum):
    """Boards as api.h numbers them."""

    SEQUENCER = 0
    LOGGER = 1


class Reset(IntEnum):
    """Restarts of the sequencer with its supply on, as api.h numbers them."""

    WATCHDOG = 0
    BROWN_OUT = 1
    BUTTON = 2
