"""The emulated robot's card: its files, and what a person or a bad card does."""

from __future__ import annotations

import ctypes
from enum import IntEnum

NO_FOREIGN_FILES = 2**32 - 1


class CardDefect(IntEnum):
    """What can be wrong with a card, as api.h numbers it."""

    NONE = 0
    WRITE_PROTECTED = 1
    UNREADABLE = 2
    FAILING = 3


class CardSlot:
    """The logger's card slot. Valid as long as the robot is."""

    def __init__(self, library: ctypes.CDLL, robot: int) -> None:
        self._library = library
        self._robot = robot

    def files(self) -> dict[int, bytes]:
        """The recordings by number, as a reader would find them now, whatever is wrong with the card."""
        files = {}
        number = 0
        while number := self._library.tfsat_card_next_file(self._robot, number + 1):
            size = self._library.tfsat_card_file_size(self._robot, number)
            data = (ctypes.c_uint8 * size)()
            self._library.tfsat_card_file_read(self._robot, number, data, size)
            files[number] = bytes(data)
        return files

    def put(self, number: int, data: bytes) -> None:
        """A recording of whole blocks, as another computer would put it there."""
        self._library.tfsat_card_put_file(self._robot, number, data, len(data))

    def remove(self) -> None:
        """Takes the card out, a recording in full swing included."""
        self._library.tfsat_card_set_present(self._robot, 0)

    def insert(self, *, mount_us: int = 0) -> None:
        """Pushes a card with the same recordings in, with nothing else on it and nothing wrong with it.

        Counting its free room takes `mount_us`.
        """
        self._library.tfsat_card_set_mount(self._robot, mount_us)
        self.spoil(CardDefect.NONE)
        self.fill(NO_FOREIGN_FILES)
        self._library.tfsat_card_set_present(self._robot, 1)

    def spoil(self, defect: CardDefect) -> None:
        """From now on that is wrong with the card."""
        self._library.tfsat_card_set_defect(self._robot, defect)

    def fill(self, free_blocks: int) -> None:
        """Files of others leave it so many free blocks, or as many as there are."""
        self._library.tfsat_card_fill(self._robot, free_blocks)
