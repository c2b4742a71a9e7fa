"""Whether host and boards are of one release: protocol and images."""

from __future__ import annotations

from tfsat_host.preflight.check import Check, go, no_go, not_made
from tfsat_host.preflight.evidence import BoardEvidence, Evidence, Missing
from tfsat_host.protocol.limits import FIRMWARE_VERSION, PROTOCOL_HASH

_FLASH = {
    "sequencer": "make firmware, then: tfsat-host flash sequencer",
    "logger": "flash firmware/teensy_logger of this release onto the Teensy (docs/logger.md)",
}
_IMAGE = "{name}-image"


def check_protocol(evidence: Evidence) -> Check:
    """Both boards' firmware was built with this program's specification, of the same version."""
    name = "protocol"
    boards = (evidence.sequencer_board, evidence.logger_board)
    unreached = [(board.name, board.identity) for board in boards if isinstance(board.identity, Missing)]
    if unreached:
        said = " ".join(f"The {who} did not say who it is: {missing.reason}" for who, missing in unreached)
        return not_made(name, said, " ".join(dict.fromkeys(missing.next_step for _, missing in unreached)))
    ours = ".".join(map(str, FIRMWARE_VERSION))
    for board in boards:
        identity = board.identity
        if isinstance(identity, Missing) or (identity.speaks_this_protocol and identity.firmware == ours):
            continue
        other = "another protocol than" if not identity.speaks_this_protocol else "another version than"
        return no_go(
            name,
            f"The {board.name}'s firmware {identity.firmware} is of {other} this program's {ours}.",
            f"{_FLASH[board.name]}; or install the host package of the boards' release.",
            board=board.name,
            firmware=identity.firmware,
            protocol_hash=identity.protocol_hash,
            expected_protocol_hash=PROTOCOL_HASH.hex(),
        )
    return go(
        name,
        f"Both boards speak this program's protocol, firmware {ours}.",
        protocol_hash=PROTOCOL_HASH.hex(),
    )


def check_image(board: BoardEvidence) -> Check:
    """The board runs the image that it should, byte for byte, by the CRC that it computes over its own flash."""
    name = _IMAGE.format(name=board.name)
    identity = board.identity
    if isinstance(identity, Missing):
        return not_made(name, f"The {board.name} did not say what it runs.", "See protocol.")
    if identity.runs_natively:
        return go(
            name,
            f"No board: the emulated robot runs the {board.name}'s sources natively, without an image.",
            natively=True,
        )
    if isinstance(board.image, Missing):
        return not_made(
            name,
            f"The {board.name} runs image {identity.image_crc}; which it should run is not known: "
            f"{board.image.reason}",
            board.image.next_step,
            image_crc=identity.image_crc,
        )
    wanted = board.image
    numbers = {
        "image_crc": identity.image_crc,
        "expected_image_crc": wanted.crc,
        "source": wanted.source,
        "calibrated": wanted.calibrated,
    }
    runs = f"The {board.name} runs image {identity.image_crc}"
    if identity.image_crc == wanted.crc:
        whose = "as when it was calibrated" if wanted.calibrated else f"that of {wanted.source}"
        return go(name, f"{runs}, {whose}.", **numbers)
    if wanted.calibrated:
        return no_go(
            name,
            f"{runs}; when it was calibrated it ran {wanted.crc} ({wanted.source}).",
            f"If it was flashed since, name what it runs now: --logger-image {identity.image_crc}. If not, "
            f"{_FLASH[board.name]}.",
            **numbers,
        )
    return no_go(
        name,
        f"{runs}, not {wanted.crc} of {wanted.source}.",
        f"To run that one: {_FLASH[board.name]}. If what it runs is right, as the Arduino IDE made it, name that: "
        f"--{name} {identity.image_crc}",
        **numbers,
    )
