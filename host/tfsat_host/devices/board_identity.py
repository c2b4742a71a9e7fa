"""Which board answers at a port: its kind, serial number, firmware, image and protocol."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import Column, Columns, columns_of, fields


@dataclass(frozen=True, slots=True)
class BoardIdentity:
    """What HELLO says.

    Attributes:
        board: Kind of board.
        serial: Serial number, hexadecimal; empty where the chip has none.
        firmware: Version, such as 0.1.0.
        image_crc: CRC-32/ISO-HDLC of the flashed image, 8 hexadecimal digits; zeros where a core runs natively.
        protocol_hash: Of the specification that the firmware was built with, hexadecimal.
    """

    board: Board
    serial: str
    firmware: str
    image_crc: str
    protocol_hash: str

    @classmethod
    def from_reply(cls, reply: msg.HelloReply) -> BoardIdentity:
        """Build the identity from the board's answer to HELLO."""
        return cls(
            board=reply.board,
            serial=reply.board_serial.hex() if any(reply.board_serial) else "",
            firmware=".".join(str(part) for part in reply.firmware_version),
            image_crc=f"{reply.image_crc:08x}",
            protocol_hash=reply.protocol_hash.hex(),
        )

    @property
    def speaks_this_protocol(self) -> bool:
        """Whether the firmware was built with this program's specification."""
        return self.protocol_hash == PROTOCOL_HASH.hex()

    @property
    def runs_natively(self) -> bool:
        """Whether this is no board but the firmware's core on a computer, as emulated robots have."""
        return int(self.image_crc, 16) == 0

    def describe(self) -> str:
        """Describe the board for people: firmware, image and serial number, as far as they exist."""
        parts = [f"{self.board.name.lower()} firmware {self.firmware}"]
        parts.append("core run natively, no image" if self.runs_natively else f"image {self.image_crc}")
        if self.serial:
            parts.append(f"serial number {self.serial}")
        return ", ".join(parts)


@dataclass(frozen=True, slots=True)
class Device:
    """A board at a port."""

    port: str
    identity: BoardIdentity

    def describe(self) -> str:
        """Describe port and board for people."""
        return f"{self.port}, {self.identity.describe()}"


IDENTITY: Columns = (
    *fields("board serial firmware"),
    Column("image_crc", of=lambda identity: None if identity.runs_natively else identity.image_crc),
    *fields("protocol_hash"),
)
DEVICE: Columns = (*fields("port"), *columns_of("identity", IDENTITY))
"""Under `device` of `--json`."""
