"""What a power cut leaves on the card of a served robot."""

from __future__ import annotations

from pathlib import Path

from tests.emulated.test_control import Person
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.server import RobotServer
from tfsat_host.protocol.limits import BLOCK_BYTES, CARD_SYNC_MS, SAMPLE_RATE_HZ
from tfsat_host.sdlog import load


def test_without_power_the_card_holds_all_but_the_last_moments(server: RobotServer, tmp_path: Path) -> None:
    person = Person(server)
    server.robot.advance(SETTLE_US)
    started = LoggerClient.connect(EmulatedTransport(server.robot, BoardIndex.LOGGER)).start_recording()
    assert person("wait 2s") == "ok"
    assert person("power logger off") == "ok"
    # The card's contents without power.
    off = person("card " + str(tmp_path / "off.bin"))
    assert person("power logger on") == "ok"
    assert person("wait 1s") == "ok"
    on = person("card " + str(tmp_path / "on.bin"))
    assert off.split()[1] == on.split()[1]
    # Coming back, the logger must not touch the recording that was cut.
    assert (tmp_path / "off.bin").read_bytes() == (tmp_path / "on.bin").read_bytes()

    log = load(tmp_path / "on.bin")
    assert log.session == started.session
    assert log.verdict == "truncated"
    lost = 2.0 * SAMPLE_RATE_HZ - log.t_us.size
    # At least the last samples, and no more than since the last sync.
    assert 0 < lost < (CARD_SYNC_MS / 1000 + 0.1) * SAMPLE_RATE_HZ


def test_a_recording_after_the_power_cut_is_another_and_whole(server: RobotServer, tmp_path: Path) -> None:
    person = Person(server)
    server.robot.advance(SETTLE_US)
    first = LoggerClient.connect(EmulatedTransport(server.robot, BoardIndex.LOGGER)).start_recording()
    for line in ("wait 500ms", "power logger off", "wait 100ms", "power logger on"):
        assert person(line) == "ok"
    server.robot.advance(SETTLE_US)
    logger = LoggerClient.connect(EmulatedTransport(server.robot, BoardIndex.LOGGER))
    second = logger.start_recording()
    server.robot.advance(500_000)
    logger.stop_recording()
    person("card " + str(tmp_path / "second.bin"))
    log = load(tmp_path / "second.bin")
    assert (log.session, log.verdict) == (second.session, "complete")
    # A new session: the old recording is another one.
    assert second.session != first.session


def test_what_the_card_had_not_programmed_goes_with_its_power() -> None:
    """Lose the blocks in the card's own RAM, those written since the last sync, with its power.

    The card is told to sync every 250 ms. Blocks are not lost while the file is still being filled: then they
    are zeros.
    """
    lost = []
    # Every 50 ms across one interval of the card's syncs.
    for delay_us in range(10_000_000, 10_250_000, 50_000):
        with EmulatedRobot(seed=3) as robot:
            robot.advance(SETTLE_US)
            LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER)).start_recording()
            robot.advance(delay_us)
            before = written_blocks(robot.card())
            robot.set_power(BoardIndex.LOGGER, False)
            lost.append(before - written_blocks(robot.card()))
    assert min(lost) >= 0
    # A quarter of a second is 12 blocks at 280 Hz; most of them were synced.
    assert 0 < max(lost) <= 8


def written_blocks(card: bytes) -> int:
    blocks = (card[start : start + BLOCK_BYTES] for start in range(0, len(card), BLOCK_BYTES))
    # Blocks that were never written are zeros.
    return sum(any(block) for block in blocks)
