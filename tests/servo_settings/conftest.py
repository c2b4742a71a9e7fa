"""The native board, to hear from the firmware itself what it takes."""

from __future__ import annotations

from tests.arduino_sequencer.conftest import board, board_library, new_board

__all__ = ["board", "board_library", "new_board"]
