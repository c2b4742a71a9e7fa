"""Which of a file's recordings is decoded; one that begins late, from the logger's RAM, is not damaged."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.sdlog.encoder import HEADER, Recorder
from tests.sdlog.test_decode_command import decode, decode_json
from tests.sdlog.test_values import assert_values, write
from tfsat_host.sdlog import load
from tfsat_host.sdlog.log_errors import LogError

STARTED_US = 1_790_000_000_000_000
HOUR_US = 3_600_000_000
OLD, NEW, THIRD = 0xA, 0xB, 0xC


def record_session(session: int, wall_clock_us: int, data_blocks: int = 5) -> Recorder:
    recorder = Recorder(session=session, header=replace(HEADER, wall_clock_us=wall_clock_us), repeat_blocks=4)
    for _ in range(data_blocks):
        recorder.data()
    recorder.close()
    return recorder


@pytest.fixture
def card(tmp_path: Path) -> Path:
    """Write a card image with an older recording first and return its path."""
    old, new = record_session(OLD, STARTED_US), record_session(NEW, STARTED_US + HOUR_US)
    return write(tmp_path / "card.img", bytes(512 * 3) + old.image() + bytes(512 * 4) + new.image())


def test_the_newest_by_the_time_of_day_is_decoded_wherever_it_stands(card: Path) -> None:
    log = load(card)
    assert (log.session, log.chosen_by, log.verdict, log.other_sessions) == (
        NEW,
        "time of day",
        "complete",
        (OLD,),
    )
    assert_values(log)
    started = {log_recording.session: log_recording.started_unix_us for log_recording in log.recordings}
    assert started == {OLD: STARTED_US, NEW: STARTED_US + HOUR_US}
    assert [
        (log_recording.samples, log_recording.is_unbroken, log_recording.has_end)
        for log_recording in log.recordings
    ] == [(30, True, True)] * 2
    assert load(card, session=OLD).chosen_by == "asked for"


@pytest.mark.parametrize("told_us", [0, 3_600_000_000], ids=["none", "1970"])
def test_one_without_time_of_day_leaves_it_to_the_place(tmp_path: Path, told_us: int) -> None:
    first, later = record_session(OLD, told_us), record_session(NEW, STARTED_US)
    log = load(write(tmp_path / "card.img", first.image() + later.image()))
    assert (log.session, log.chosen_by) == (OLD, "place")
    assert load(write(tmp_path / "one.bin", later.image())).chosen_by == "only one"


def test_remains_of_an_old_recording_do_not_need_a_time_of_day(tmp_path: Path) -> None:
    """Ignore remains of an old recording without a time of day when choosing the newest recording.

    They stand at the beginning of the card or behind the newer recording in its file.
    """
    undated, new, third = (
        record_session(OLD, 0, 30),
        record_session(NEW, STARTED_US),
        record_session(THIRD, STARTED_US + 1),
    )
    image = b"".join([*undated.blocks[9:20], *new.blocks, *third.blocks])
    assert load(write(tmp_path / "card.img", image)).session == THIRD


def test_an_old_block_at_the_start_does_not_make_a_dated_recording_of_its_remains(tmp_path: Path) -> None:
    old, new = record_session(OLD, STARTED_US, 30), record_session(NEW, 0)
    image = b"".join([old.blocks[0], *new.blocks[1:], *old.blocks[len(new.blocks) :]])
    log = load(write(tmp_path / "SD.bin", image))
    assert (log.session, log.chosen_by) == (NEW, "place")


def test_the_cut_recording_is_taken_where_its_time_says_that_it_is_the_newest(tmp_path: Path) -> None:
    old, new = record_session(OLD, STARTED_US), record_session(NEW, STARTED_US + HOUR_US)
    log = load(write(tmp_path / "card.img", old.image() + b"".join(new.blocks[1:-1])))
    assert (log.session, log.header_is_copy, log.verdict) == (NEW, True, "damaged")


def test_a_clock_that_was_set_while_recording_tells_when_it_began(tmp_path: Path) -> None:
    late = record_session(OLD, 0, 9)
    dated = record_session(OLD, STARTED_US, 9)
    blocks = [*late.blocks[:8], *dated.blocks[8:]]
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    repeated_us = late.time_us(36) - late.time_us(0)
    assert log.recordings[0].started_unix_us == STARTED_US - repeated_us


def test_the_command_lists_them_and_names_the_way_to_another(card: Path) -> None:
    process = decode(card)
    assert f"{card} holds 2 recordings. Decoded: 0000000b, the newest by the time of day" in process.stderr
    assert "0000000a  2026-09-21 14:13:20 UTC  about 30 samples in 8 blocks, whole" in process.stderr
    assert f"tfsat-host decode {card} --session ID" in process.stderr
    assert "8 of other recordings" in process.stdout and "stale" not in process.stdout
    facts = decode_json(card, "--session", "a")
    assert (facts["session"], facts["chosen_by"]) == ("0000000a", "asked for")
    assert [entry["session"] for entry in facts["recordings"]] == ["0000000a", "0000000b"]


def test_the_place_is_named_as_the_rule_and_a_missing_time_is_a_dash(tmp_path: Path) -> None:
    image = record_session(OLD, 0).image() + b"".join(record_session(NEW, 0, 9).blocks[3:])
    process = decode(write(tmp_path / "card.img", image))
    assert "Decoded: 0000000a, the first in the file" in process.stderr
    assert "0000000a  -  " in process.stderr
    assert "parts of it" in process.stderr
    alone = decode(write(tmp_path / "one.bin", record_session(OLD, 0).image()))
    assert "recordings" not in alone.stderr


def test_more_recordings_than_are_looked_at_leave_it_to_the_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tfsat_host.sdlog.recordings.MAX_RECORDINGS", 1)
    image = record_session(OLD, STARTED_US).image() + record_session(NEW, STARTED_US + HOUR_US).image()
    log = load(write(tmp_path / "card.img", image))
    assert (log.session, log.chosen_by, len(log.recordings), log.other_sessions) == (OLD, "place", 1, (NEW,))


ZERO = bytes(512)


def record_blocks(data_blocks: int = 40, drop_after: int | None = None) -> Recorder:
    recorder = Recorder(repeat_blocks=16)
    for number in range(data_blocks):
        recorder.data()
        if number == drop_after:
            recorder.drop(7)
    return recorder


def test_everything_from_a_later_block_on_is_truncated_and_nothing_is_lost(tmp_path: Path) -> None:
    blocks = record_blocks().blocks
    log = load(write(tmp_path / "RAM.BIN", b"".join(blocks[10:])))
    assert (log.verdict, log.samples_lost, log.blocks_lost, log.header_is_copy) == ("truncated", 0, 0, True)
    (gap,) = log.gaps
    assert gap == log.late_start
    assert (gap.late_start, gap.blocks, gap.samples, gap.start_us) == (True, 10, 54, None)
    assert log.sample_index[0] == 54
    assert_values(log)


def test_with_its_end_it_is_truncated_still(tmp_path: Path) -> None:
    recorder = record_blocks()
    recorder.close()
    log = load(write(tmp_path / "RAM.BIN", b"".join(recorder.blocks[16:])))
    assert (log.verdict, log.blocks_lost) == ("truncated", 0)
    assert log.footer is not None
    process = decode(tmp_path / "RAM.BIN", expect=3)
    assert "start not in the file" in process.stdout
    assert "no end" not in process.stderr


def test_what_was_dropped_before_the_start_is_not_lost_inside(tmp_path: Path) -> None:
    early, late = record_blocks(drop_after=3), record_blocks(drop_after=30)
    log = load(write(tmp_path / "RAM.BIN", b"".join(early.blocks[10:])))
    assert (log.verdict, log.samples_lost) == ("truncated", 0)
    log = load(write(tmp_path / "RAM.BIN", b"".join(late.blocks[10:])))
    assert (log.verdict, log.samples_lost, len(log.gaps)) == ("damaged", 7, 2)


def test_a_hole_inside_is_damage_and_told_apart(tmp_path: Path) -> None:
    blocks = record_blocks().blocks
    path = write(tmp_path / "RAM.BIN", b"".join(blocks[10:20] + blocks[22:]))
    log = load(path)
    assert (log.verdict, log.blocks_lost, log.samples_lost) == ("damaged", 2, 12)
    assert [gap.late_start for gap in log.gaps] == [True, False]
    process = decode(path, expect=3)
    assert "begins at block 10" in process.stderr
    assert "(2 blocks), in 1 place" in process.stderr


def test_a_file_whose_own_beginning_is_spoiled_is_damaged(tmp_path: Path) -> None:
    blocks = record_blocks().blocks
    for first in (ZERO, blocks[0][:500] + ZERO[:12], b"x" * 512):
        log = load(write(tmp_path / "SD.bin", first + b"".join(blocks[1:])))
        assert (log.verdict, log.blocks_lost, log.late_start) == ("damaged", 1, None)


def test_a_late_start_is_not_called_damage(tmp_path: Path) -> None:
    blocks = record_blocks().blocks
    process = decode(write(tmp_path / "RAM.BIN", b"".join(blocks[10:])), expect=3)
    assert "truncated: complete from 0.0 to 0.7 s; start and end not in the file" in (process.stdout)
    assert "The recording begins at block 10: RAM kept the newest 0.7 s." in process.stderr
    for word in ("damaged", "lost", "power was cut", "missing"):
        assert word not in process.stdout + process.stderr
    facts = decode_json(tmp_path / "RAM.BIN", expect=3)
    assert facts["gaps"][0]["late_start"] is True


def test_a_cut_recording_says_from_when_to_when_it_is_complete(tmp_path: Path) -> None:
    process = decode(write(tmp_path / "SD.bin", record_blocks().image()), expect=3)
    assert "truncated: complete from 0.0 to 0.9 s; end not in the file" in process.stdout


def test_a_part_that_ram_could_not_hold_is_not_said_to_come_from_it(tmp_path: Path) -> None:
    path = write(tmp_path / "part.bin", b"".join(record_blocks(1200).blocks[100:]))
    process = decode(path, expect=3)
    assert "what came before it is not in this file" in process.stderr
    assert "RAM" not in process.stderr


def test_remains_without_a_header_do_not_hide_a_recording_that_can_be_decoded(tmp_path: Path) -> None:
    """Without a header nothing of them has a scale; the other recording is told of the choice."""
    old, new = record_session(OLD, STARTED_US, 30), record_session(NEW, 0)
    remains = b"".join(old.blocks[1:4])
    card = write(tmp_path / "card.img", remains + new.image())
    log = load(card)
    assert (log.session, log.chosen_by, log.other_sessions) == (NEW, "header", (OLD,))
    assert_values(log)
    assert "the first in the file that has a header" in decode(card).stderr
    with pytest.raises(LogError, match="has lost its header"):
        load(card, session=OLD)
    alone = write(tmp_path / "remains.bin", remains)
    with pytest.raises(LogError, match="has lost its header"):
        load(alone)


@pytest.mark.parametrize("front", range(1, 9))
def test_remains_of_any_length_in_front_leave_the_recording_behind_them(tmp_path: Path, front: int) -> None:
    old, new = record_session(OLD, STARTED_US, 30), record_session(NEW, STARTED_US + HOUR_US)
    image = b"".join([*old.blocks[30 : 30 + front], *new.blocks])
    assert load(write(tmp_path / "card.img", image)).session == NEW
