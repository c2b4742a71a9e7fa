"""Which port is the bootloader's, and which the sketch's afterwards, on a clock that only waiting moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from tests.devices.scripted import ScriptedTransport, hello, reply
from tfsat_host.devices.serial_ports import PortError, PortInfo, open_error
from tfsat_host.devices.transport import Transport
from tfsat_host.flashing.board_flashers import BOOTLOADER_TIMEOUT_S, SequencerFlasher, wake
from tfsat_host.flashing.loader import Computer, FlashError
from tfsat_host.protocol.enums import Board

# USB ids: Arduino's Micro in both modes, the bootloader of Arduino srl, PJRC's Teensy.
SKETCH, BOOTLOADER, NEWER, TEENSY = (0x2341, 0x8037), (0x2341, 0x0037), (0x2A03, 0x0037), (0x16C0, 0x0483)


class FakeComputer(Computer):
    """Ports by time after the touch: {seconds: {name: USB ids}}."""

    def __init__(self, story: dict[float, dict[str, tuple[int, int]]], boards: dict[str, Board]) -> None:
        self.story = story
        self.boards = boards
        self.t_s = 0.0
        self.touched: list[str] = []

    def _now(self) -> dict[str, tuple[int, int]]:
        return self.story[max(at_s for at_s in self.story if at_s <= self.t_s)]

    def ports(self) -> list[PortInfo]:
        return [PortInfo(name, *ids) for name, ids in self._now().items()]

    def touch(self, path: str, baudrate: int = 1200) -> None:
        assert baudrate == 1200
        self.touched.append(path)
        self.t_s += 0.01

    def connect(self, path: str) -> Transport:
        if path not in self._now():
            raise open_error(path, 2, "No such file or directory")
        # Listed, but not yet to be opened: udev sets permissions a moment later.
        if path not in self.boards:
            raise open_error(path, 13, "Permission denied")
        board = self.boards[path]
        return ScriptedTransport(lambda frame: [reply(frame, hello(board=board))])

    def find_program(self, name: str) -> str | None:
        raise AssertionError(name)

    def run(self, command: Sequence[str], output: Callable[[str], None], timeout_s: float) -> int | None:
        raise AssertionError(command, output, timeout_s)

    def now_s(self) -> float:
        return self.t_s

    def sleep(self, duration_s: float) -> None:
        self.t_s += duration_s


def expect_no_hint(_hint: str) -> None:
    raise AssertionError("no hint is due")


@pytest.mark.parametrize("ids", [BOOTLOADER, NEWER, (0x2341, 0x0237)])
@pytest.mark.parametrize("name", ["/dev/ttyACM0", "/dev/ttyACM3", "COM6"])
def test_the_bootloader_may_have_another_name(name: str, ids: tuple[int, int]) -> None:
    # The port goes for a second, as USB enumerates anew; any name may come back.
    computer = FakeComputer({0: {"/dev/ttyACM0": SKETCH}, 0.5: {}, 1.5: {name: ids}}, {})
    assert wake(computer, "/dev/ttyACM0", expect_no_hint) == name
    assert computer.touched == ["/dev/ttyACM0"]
    assert computer.t_s < 2.5


def test_a_bootloader_that_was_there_before_is_another_board() -> None:
    other = {"/dev/ttyACM7": BOOTLOADER}
    # ttyACM7 waits in its bootloader all the time: only what is new can be the touched board.
    story = {0.0: {"/dev/ttyACM0": SKETCH, **other}, 1.0: other, 2.0: {"/dev/ttyACM0": BOOTLOADER, **other}}
    assert wake(FakeComputer(story, {}), "/dev/ttyACM0", expect_no_hint) == "/dev/ttyACM0"


def test_two_bootloaders_at_once_are_one_too_many() -> None:
    story = {0.0: {"a": SKETCH, "b": SKETCH}, 1.0: {"a": BOOTLOADER, "b": BOOTLOADER}}
    # To guess would put the image on a board that may be armed.
    with pytest.raises(FlashError, match="2 bootloaders appeared at once: a, b") as caught:
        wake(FakeComputer(story, {}), "a", expect_no_hint)
    assert caught.value.code == "ambiguous"


def test_no_bootloader_within_eight_seconds() -> None:
    computer = FakeComputer({0: {"a": SKETCH}}, {})
    hints: list[str] = []
    with pytest.raises(FlashError, match="within 8 s after the 1200-baud touch of a") as caught:
        wake(computer, "a", hints.append)
    assert caught.value.code == "bootloader-not-seen"
    assert "reset button twice" in caught.value.next_step
    assert len(hints) == 1 and "reset button twice" in hints[0]
    # The Micro's bootloader itself goes back to its sketch after 8 s.
    assert BOOTLOADER_TIMEOUT_S < computer.t_s < BOOTLOADER_TIMEOUT_S + 0.5


def test_the_sketch_may_come_back_under_another_name() -> None:
    others = {"/dev/ttyACM5": SKETCH}
    story = {0.0: {"/dev/ttyACM0": BOOTLOADER, **others}, 2.0: {"/dev/ttyACM1": SKETCH, **others}}
    boards = {"/dev/ttyACM1": Board.SEQUENCER, "/dev/ttyACM5": Board.SEQUENCER}
    # ttyACM5 was there while the board was in its bootloader: it is another sequencer.
    device = SequencerFlasher(FakeComputer(story, boards)).ask_again("/dev/ttyACM0", {"/dev/ttyACM5"})
    assert (device.port, device.identity.image_crc) == ("/dev/ttyACM1", "00c0ffee")


def test_a_link_that_is_not_listed_is_tried_all_the_same() -> None:
    # A link of /dev/serial/by-id, whose device has other USB ids than a Micro's.
    computer = FakeComputer(
        {0: {"boot": BOOTLOADER}, 2: {"by-id/micro": TEENSY}}, {"by-id/micro": Board.SEQUENCER}
    )
    assert SequencerFlasher(computer).ask_again("by-id/micro", set()).port == "by-id/micro"


def test_the_logger_at_the_old_name_is_not_taken_for_the_board() -> None:
    # Windows gives freed names away: COM5 now answers as the logger.
    story = {0.0: {"COM5": TEENSY}, 3.0: {"COM5": TEENSY, "COM8": SKETCH}}
    computer = FakeComputer(story, {"COM5": Board.LOGGER, "COM8": Board.SEQUENCER})
    assert SequencerFlasher(computer).ask_again("COM5", set()).port == "COM8"


@pytest.mark.parametrize(
    ("after", "reason"),
    [({}, "No port that looks like"), ({"a": SKETCH}, "You are not permitted to open a")],
)
def test_a_sketch_that_does_not_answer(after: dict[str, tuple[int, int]], reason: str) -> None:
    with pytest.raises(FlashError, match=reason) as caught:
        SequencerFlasher(FakeComputer({0.0: {}, 1.0: after}, {})).ask_again(None, set())
    assert caught.value.code == "silent"
    assert "Do not fly this board yet" in caught.value.meaning


def test_a_port_that_cannot_be_touched_is_told() -> None:
    class Busy(FakeComputer):
        def touch(self, path: str, baudrate: int = 1200) -> None:
            # 16 is EBUSY: a serial monitor has the port.
            raise open_error(path, 16, f"busy at {baudrate}")

    with pytest.raises(PortError, match="in use by another program"):
        wake(Busy({0: {"a": SKETCH}}, {}), "a", expect_no_hint)
