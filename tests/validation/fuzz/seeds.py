"""What a fuzzer should know from the start: the golden frames, and how a board is used.

Made again for each build, so that the frames always speak the protocol of today.
"""

from __future__ import annotations

import json
from enum import IntEnum
from pathlib import Path

from tests.paths import REPOSITORY

GOLDEN = REPOSITORY / "protocol" / "golden_vectors.json"


class Step(IntEnum):
    """What a script for the board does next: kSteps of fuzz_board.cpp."""

    GARBAGE = 0
    SEND_ANY = 1
    ARM = 2
    MANEUVER = 3
    SETTINGS = 4
    JOG = 5
    PLUG = 6
    SWITCHES = 7
    RESTART = 8
    TURN = 9


SECOND = bytes([Step.TURN, 5 << 5 | 24, Step.TURN, 5 << 5 | 24])  # 50 turns of 20 ms
QUARTER = bytes([Step.TURN, 5 << 5 | 12])  # 13 turns of 20 ms
TURN = bytes([Step.TURN, 2 << 5])  # one of 1 ms
DEBOUNCE = bytes([Step.TURN, 2 << 5 | 7])  # eight of 1 ms
STORE = bytes([Step.TURN, 4 << 5 | 31]) * 9  # as long as a maneuver takes to store
ARM = bytes([Step.ARM, 0]) + TURN
OPEN, CLOSE = bytes([Step.SWITCHES, 0b1111]), bytes([Step.SWITCHES, 0b1100])
OPEN_ONE = bytes([Step.SWITCHES, 0b0101])
WATCHDOG, POWER_CUT = bytes([Step.RESTART, 0]), bytes([Step.RESTART, 3])
UNPLUG, PLUG = bytes([Step.PLUG, 0]), bytes([Step.PLUG, 3])
MANEUVER = bytes([Step.MANEUVER, 3, 0, 0]) + bytes(4 * 5) + b"\0"  # four strokes, nothing wrong
BEGUN = MANEUVER[:-1] + b"\1"  # the commit's CRC is wrong
LEAVES_START = bytes([Step.MANEUVER, 0, 0, 0, 0, 16, 0, 0, 0, 0])  # one stroke, to 10.16 deg
SETTINGS = bytes([Step.SETTINGS, 0])
JOG = bytes([Step.JOG, 0]) + bytes(2) + (1000).to_bytes(2, "little") + b"\0"
DISARM = bytes([Step.SEND_ANY, 11, 0])

SCRIPTS = {
    "Drop": ARM + OPEN + SECOND * 3 + ARM,
    "Knock": ARM + OPEN + TURN + CLOSE + DEBOUNCE + OPEN_ONE + SECOND,
    "Jolt": ARM + OPEN + DEBOUNCE + CLOSE + QUARTER + OPEN + SECOND * 3,
    "ClosedInTheRun": ARM + OPEN + SECOND + CLOSE + QUARTER + DISARM + TURN,
    "ArmedAndUnplugged": ARM + UNPLUG + SECOND + PLUG + DISARM + TURN,
    "ResetWhileArmed": ARM + WATCHDOG + DEBOUNCE + OPEN + DEBOUNCE,
    "OpenedInReset": ARM + OPEN_ONE + WATCHDOG + DEBOUNCE + DISARM + TURN,
    "ResetWhileRunning": ARM + OPEN + SECOND + WATCHDOG + TURN + DISARM + TURN,
    "Upload": MANEUVER + STORE + ARM + OPEN + SECOND * 2,
    "LeftFarFromStart": LEAVES_START + STORE + ARM + OPEN + SECOND * 3 + CLOSE + DEBOUNCE + ARM,
    "CutWhileStoring": MANEUVER + STORE[:4] + POWER_CUT + ARM,
    "CutWhenBegun": BEGUN + STORE[:4] + POWER_CUT + ARM + MANEUVER + STORE + ARM,
    "Settings": SETTINGS + STORE + JOG + TURN + UNPLUG + TURN,
    "Jog": JOG + SECOND + JOG + SECOND + DISARM + TURN,
}


def golden_frames() -> dict[str, bytes]:
    """Read every frame of the golden vectors, with the final zero, by its payload's name."""
    frames = json.loads(GOLDEN.read_text())["frames"]
    return {frame["payload_name"]: bytes.fromhex(frame["frame"]) for frame in frames}


def streams() -> dict[str, bytes]:
    """Return each frame alone, all of them in a row, and the same after garbage."""
    # A frame alone teaches the fuzzer its bytes, a row of frames their boundaries.
    frames = golden_frames()
    together = b"".join(frames.values())
    # Garbage ends with a zero: the receiver resynchronizes there.
    garbage = bytes(range(255, 200, -1)) + b"\0"
    return {**frames, "AllFrames": together, "AfterGarbage": garbage + together}


def write_seeds(folder: Path, inputs: dict[str, bytes]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in inputs.items():
        (folder / name).write_bytes(data)


def write_dictionary(path: Path) -> None:
    """Write the frames as a libFuzzer dictionary."""
    lines = ["# The golden frames, of tests/validation/fuzz/seeds.py."]
    for name, frame in golden_frames().items():
        lines.append(f'{name}="' + "".join(f"\\x{byte:02X}" for byte in frame) + '"')
    path.write_text("\n".join(lines) + "\n")
