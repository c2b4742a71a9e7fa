"""A recording fetched from the logger's RAM, or a copy of the last part of one, begins late: that is no damage."""

from __future__ import annotations

from pathlib import Path

from tests.sdlog.encoder import Recorder
from tests.sdlog.test_decode_command import decode, decode_json
from tests.sdlog.test_values import assert_values, write
from tfsat_host.sdlog import load

ZERO = bytes(512)


def made(data_blocks: int = 40, drop_after: int | None = None) -> Recorder:
    recorder = Recorder(repeat_blocks=16)
    for number in range(data_blocks):
        recorder.data()
        if number == drop_after:
            recorder.drop(7)
    return recorder


def test_everything_from_a_later_block_on_is_truncated_and_nothing_is_lost(tmp_path: Path) -> None:
    blocks = made().blocks
    log = load(write(tmp_path / "RAM.BIN", b"".join(blocks[10:])))
    assert (log.verdict, log.samples_lost, log.blocks_lost, log.header_is_copy) == ("truncated", 0, 0, True)
    (gap,) = log.gaps
    assert gap == log.late_start
    assert (gap.late_start, gap.blocks, gap.samples, gap.start_us) == (True, 10, 54, None)
    assert log.sample_index[0] == 54
    assert_values(log)


def test_with_its_end_it_is_truncated_still(tmp_path: Path) -> None:
    recorder = made()
    recorder.close()
    log = load(write(tmp_path / "RAM.BIN", b"".join(recorder.blocks[16:])))
    assert (log.verdict, log.blocks_lost) == ("truncated", 0)
    assert log.footer is not None
    shown = decode(tmp_path / "RAM.BIN", expect=3)
    assert "what came before is not in the file" in shown.stdout
    assert "no end" not in shown.stderr


def test_what_was_dropped_before_the_start_is_not_lost_inside(tmp_path: Path) -> None:
    early, late = made(drop_after=3), made(drop_after=30)
    log = load(write(tmp_path / "RAM.BIN", b"".join(early.blocks[10:])))
    assert (log.verdict, log.samples_lost) == ("truncated", 0)
    log = load(write(tmp_path / "RAM.BIN", b"".join(late.blocks[10:])))
    assert (log.verdict, log.samples_lost, len(log.gaps)) == ("damaged", 7, 2)


def test_a_hole_inside_is_damage_and_told_apart(tmp_path: Path) -> None:
    blocks = made().blocks
    path = write(tmp_path / "RAM.BIN", b"".join(blocks[10:20] + blocks[22:]))
    log = load(path)
    assert (log.verdict, log.blocks_lost, log.samples_lost) == ("damaged", 2, 12)
    assert [gap.late_start for gap in log.gaps] == [True, False]
    shown = decode(path, expect=3)
    assert "begins at block 10" in shown.stderr
    assert "(2 blocks), in 1 places" in shown.stderr


def test_a_file_whose_own_beginning_is_spoiled_is_damaged(tmp_path: Path) -> None:
    blocks = made().blocks
    for first in (ZERO, blocks[0][:500] + ZERO[:12], b"x" * 512):
        log = load(write(tmp_path / "SD.bin", first + b"".join(blocks[1:])))
        assert (log.verdict, log.blocks_lost, log.late_start) == ("damaged", 1, None)


def test_the_words_frighten_nobody(tmp_path: Path) -> None:
    blocks = made().blocks
    shown = decode(write(tmp_path / "RAM.BIN", b"".join(blocks[10:])), expect=3)
    assert "truncated: complete from 0.0 s to 0.7 s; what came before and after is not in the file" in (
        shown.stdout
    )
    assert "The recording begins at block 10: RAM kept the newest 0.7 s." in shown.stderr
    for word in ("damaged", "lost", "power was cut", "missing"):
        assert word not in shown.stdout + shown.stderr
    facts = decode_json(tmp_path / "RAM.BIN", expect=3)
    assert facts["gaps"][0]["late_start"] is True


def test_a_cut_recording_says_from_when_to_when_it_is_complete(tmp_path: Path) -> None:
    shown = decode(write(tmp_path / "SD.bin", made().image()), expect=3)
    assert "truncated: complete from 0.0 s to 0.9 s; what came after is not in the file" in shown.stdout


def test_a_part_that_ram_could_not_hold_is_not_said_to_come_from_it(tmp_path: Path) -> None:
    path = write(tmp_path / "part.bin", b"".join(made(1200).blocks[100:]))
    shown = decode(path, expect=3)
    assert "what came before it is not in this file" in shown.stderr
    assert "RAM" not in shown.stderr
