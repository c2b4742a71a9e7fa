"""What is made of blocks that are lost, moved, repeated, torn or of another recording."""

from __future__ import annotations

import random
import struct
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sdlog.encoder import HEADER, SESSION, Recorder, event, recording, renumbered
from tests.sdlog.test_values import assert_values, write
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import BLOCK_VERSION
from tfsat_host.protocol.messages import BlockHeader, LogFooter
from tfsat_host.sdlog import LogError, SessionError, load

ZERO = bytes(512)


def test_order_on_the_card_does_not_matter(tmp_path: Path) -> None:
    blocks = recording(20).blocks
    random.Random(1).shuffle(blocks)
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert (log.verdict, len(log)) == ("complete", 120)
    assert_values(log)


def test_copies_and_unwritten_room_change_nothing(tmp_path: Path) -> None:
    blocks = recording(8).blocks
    log = load(write(tmp_path / "SD.bin", b"".join([*blocks, ZERO, ZERO, *blocks[3:7], ZERO])))
    assert (log.verdict, len(log)) == ("complete", 48)
    assert (log.set_aside.duplicate, log.set_aside.never_written) == (4, 3)


def test_two_different_blocks_with_one_number_are_doubtful(tmp_path: Path) -> None:
    blocks = recording(4).blocks
    log = load(write(tmp_path / "SD.bin", b"".join([*blocks, renumbered(blocks[2], time_us=9)])))
    assert log.verdict == "damaged"
    assert log.set_aside.conflicting == 1


def test_the_newest_recording_is_decoded_and_the_older_can_be_asked_for(tmp_path: Path) -> None:
    new, old = recording(6, session=7, repeat_blocks=4), recording(30, session=9, start_us=1)
    survivors = old.blocks[8:]
    # A lost write let one old block survive where the new recording begins.
    file = write(tmp_path / "SD.bin", b"".join([old.blocks[0], *new.blocks[1:], *survivors]))
    log = load(file)
    assert (log.session, log.other_sessions, len(log)) == (7, (9,), 36)
    assert log.set_aside.stale == len(survivors) + 1
    assert (log.blocks_lost, log.samples_lost, log.verdict) == (1, 0, "damaged")
    image_path = write(tmp_path / "image.bin", recording(6, session=7).image() + old.image())
    older = load(image_path, session=9)
    assert (older.session, older.verdict, len(older)) == (9, "complete", 180)
    with pytest.raises(SessionError, match="no recording 00000005"):
        load(image_path, session=5)


def test_lost_blocks_are_counted_where_they_were(tmp_path: Path) -> None:
    recorder = recording(10)
    blocks = recorder.blocks
    log = load(write(tmp_path / "SD.bin", b"".join(blocks[:4] + blocks[6:])))
    assert (log.verdict, log.samples_lost, log.blocks_lost) == ("damaged", 12, 2)
    (gap,) = log.gaps
    assert (gap.after_sample, gap.samples, gap.blocks, gap.samples_dropped) == (17, 12, 2, 0)
    assert (gap.start_us, gap.end_us) == (recorder.time_us(17), recorder.time_us(30))
    assert_values(log)


def test_samples_that_the_logger_dropped_are_told_apart(tmp_path: Path) -> None:
    recorder = recording(3, closed=False)
    recorder.drop(25)
    recorder.data()
    recorder.drop(4)
    recorder.close()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert (log.verdict, log.samples_lost, log.blocks_lost) == ("damaged", 29, 0)
    assert [(gap.samples, gap.samples_dropped, gap.blocks) for gap in log.gaps] == [(25, 25, 0), (4, 4, 0)]


def test_a_lost_header_is_replaced_by_its_copy(tmp_path: Path) -> None:
    recorder = Recorder(repeat_blocks=4)
    for _ in range(10):
        recorder.data()
    recorder.close()
    log = load(write(tmp_path / "SD.bin", ZERO + b"".join(recorder.blocks[1:])))
    assert log.header == HEADER
    assert (log.header_is_copy, log.verdict, log.blocks_lost, log.samples_lost) == (True, "damaged", 1, 0)
    assert_values(log)


def test_without_any_header_nothing_is_guessed(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="lost its header"):
        load(write(tmp_path / "SD.bin", b"".join(recording(5).blocks[1:])))


@pytest.mark.parametrize(
    "change",
    [
        {"rate_hz": float("nan")},
        {"rate_hz": 1e9},
        {"gyro_lsb_per_deg_s": 0.0},
        {"gyro_lsb_per_deg_s": -65.5},
        {"accel_lsb_per_g": float("inf")},
        {"accel_range_g": 0},
        {"temperature_lsb_per_c": 0.0},
        {"temperature_offset_c": float("nan")},
        {"angle_counts_per_turn": 0},
    ],
)
def test_a_header_that_makes_no_sense_is_refused(tmp_path: Path, change: dict[str, float]) -> None:
    recorder = Recorder(header=replace(HEADER, **change))  # type: ignore[arg-type]
    recorder.data()
    recorder.close()
    with pytest.raises(LogError, match="makes no sense"):
        load(write(tmp_path / "SD.bin", recorder.image()))


def test_header_copies_that_disagree_are_doubtful(tmp_path: Path) -> None:
    recorder = Recorder(repeat_blocks=4)
    for _ in range(10):
        recorder.data()
    recorder.close()
    other = Recorder(header=replace(HEADER, gyro_lsb_per_deg_s=131.0, gyro_range_deg_s=250)).blocks[0]
    blocks = [*recorder.blocks]
    blocks[4] = renumbered(other, block_number=4, first_sample=18)
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert log.verdict == "damaged"
    assert log.header == HEADER
    assert "disagree" in log.doubts[0]


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        ({"time_us": 0}, "time does not advance"),
        ({"first_sample": 3}, "repeat sample numbers"),
        ({"samples_dropped": 9}, "goes down"),
    ],
)
def test_contradictions_inside_are_doubtful(tmp_path: Path, change: dict[str, int], doubt: str) -> None:
    blocks = recording(6).blocks
    blocks[4] = renumbered(blocks[4], **change)
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert log.verdict == "damaged"
    assert any(doubt in text for text in log.doubts)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"sample_count": 7}, "malformed"),
        ({"event_count": 3}, "malformed"),
        ({"time_us": 1 << 63}, "malformed"),
        ({"version": BLOCK_VERSION + 1}, "newer"),
    ],
)
def test_blocks_with_impossible_heads_are_set_aside(
    tmp_path: Path, change: dict[str, int], reason: str
) -> None:
    blocks = recording(6).blocks
    blocks[3] = renumbered(blocks[3], **change)
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert getattr(log.set_aside, reason) == 1
    assert (log.verdict, log.samples_lost) == ("damaged", 6)


def test_nothing_is_concluded_from_an_event_at_an_impossible_time(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data()
    recorder.data(events=[event((1 << 64) - 1, EventCode.SWITCH_EDGE, 0, 1)])
    recorder.data()
    recorder.close()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert (log.verdict, len(log), len(log.events), log.release) == ("damaged", 18, 1, None)
    assert log.doubts == ("1 events have impossible times",)


def test_an_end_that_makes_no_sense_is_not_used_and_doubtful(tmp_path: Path) -> None:
    recorder = recording(3)
    footer = bytearray(recorder.blocks[-1])
    footer[BlockHeader.SIZE + LogFooter.SIZE - 1] = 77  # no StopReason
    log = load(write(tmp_path / "SD.bin", b"".join([*recorder.blocks[:-1], renumbered(bytes(footer))])))
    assert (log.footer, log.verdict) == (None, "damaged")
    assert "impossible values" in log.doubts[0]


def test_a_cut_without_loss_is_truncated(tmp_path: Path) -> None:
    log = load(write(tmp_path / "SD.bin", recording(6, closed=False).image() + ZERO))
    assert (log.verdict, log.footer, log.samples_lost, log.gaps) == ("truncated", None, 0, ())


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: b"", "is empty"),
        (lambda: bytes(4096), "zero bytes and no block"),
        (lambda: b"t_s,rate\n" * 400, "not a tfsat log"),
        (lambda: recording(0).image(), "no samples"),
        (lambda: b"".join(renumbered(b, version=9) for b in recording(2).blocks), "layout"),
        (lambda: recording(2).image()[:300], "not a tfsat log"),
    ],
)
def test_files_that_give_no_log_say_why(tmp_path: Path, make: Callable[[], bytes], what: str) -> None:
    with pytest.raises(LogError, match=what):
        load(write(tmp_path / "SD.bin", make()))


def test_more_blocks_than_are_held_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("source", "copies", "load"):
        monkeypatch.setattr(sys.modules[f"tfsat_host.sdlog.{name}"], "CHUNK_BLOCKS", 64)
    recorder = recording(300)
    blocks = [block for number, block in enumerate(recorder.blocks) if number % 97 != 50]
    lost = [number for number in range(len(recorder.blocks)) if number % 97 == 50]
    blocks[20], blocks[250] = blocks[250], blocks[20]
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert log.blocks_lost == len(lost)
    expected = [
        first + slot
        for _, kind, count, first in sorted(map(_head, blocks))
        if kind == 2
        for slot in range(count)
    ]
    assert log.sample_index.tolist() == expected
    assert_values(log)


def _head(block: bytes) -> tuple[int, int, int, int]:
    _, _, kind, count, _, _, number, first = struct.unpack_from("<IBBBBIII", block)
    return number, kind, count, first


@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_any_loss_gives_right_values_and_right_counts(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    recorder = Recorder(
        repeat_blocks=data.draw(st.integers(3, 9)), start_us=data.draw(st.integers(0, 1 << 45))
    )
    for count in data.draw(st.lists(st.integers(0, 6), min_size=1, max_size=25)):
        recorder.data(count)
        if data.draw(st.integers(0, 9)) == 0:
            recorder.drop(data.draw(st.integers(1, 50)))
    closed = data.draw(st.booleans())
    if closed:
        recorder.close()
    blocks = recorder.blocks
    kept_numbers = data.draw(st.sets(st.integers(0, len(blocks) - 1)))
    noise = data.draw(st.lists(st.sampled_from([ZERO, b"x" * 512, blocks[0][:508] + b"torn"]), max_size=4))
    order = data.draw(st.permutations([blocks[number] for number in sorted(kept_numbers)] + noise))
    path = write(tmp_path_factory.mktemp("any") / "SD.bin", b"".join(order))
    heads = [_head(blocks[number]) for number in sorted(kept_numbers)]
    samples = [first + slot for _, kind, count, first in heads if kind == 2 for slot in range(count)]
    if not samples or not any(kind == 1 for _, kind, _, _ in heads):
        with pytest.raises(LogError):
            load(path)
        return
    log = load(path)
    assert log.session == SESSION
    assert log.sample_index.tolist() == samples
    assert log.t_us.tolist() == [recorder.time_us(index) for index in samples]
    assert_values(log)
    before = log.late_start
    if before is not None:
        assert order[0] == blocks[before.blocks] and min(kept_numbers) == before.blocks
    assert log.blocks_lost == max(kept_numbers) + 1 - len(kept_numbers) - (before.blocks if before else 0)
    has_footer = closed and len(blocks) - 1 in kept_numbers
    if has_footer:
        assert log.samples_lost == recorder.samples - len(samples) - (before.samples if before else 0)
    is_gapless = not log.blocks_lost and not log.samples_lost
    both_ends = has_footer and before is None
    assert log.verdict == (("complete" if both_ends else "truncated") if is_gapless else "damaged")


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"dlpf_cfg": 77}, r"low-pass setting 77 \(possible: 0, 1, 2, 3, 4, 5, 6\)"),
        ({"dlpf_cfg": 7}, "low-pass setting 7 "),
        ({"gyro_range_deg_s": 1024, "gyro_lsb_per_deg_s": 32.0}, "gyro range in deg/s 1024 "),
        ({"accel_range_g": 3, "accel_lsb_per_g": 10922.7}, "accelerometer range in g 3 "),
        ({"bus_khz": 0}, "bus clock in kHz 0 "),
        (
            {"imu_offset_us": (0, 0, 0, 65535)},
            "a sensor read 65535 us after its sample, at 280 samples a second",
        ),
        ({"angle_offset_us": (5000, 0, 0, 0, 0, 0)}, "a sensor read 5000 us after its sample"),
    ],
)
def test_a_header_with_settings_that_no_logger_has_is_not_believed(
    tmp_path: Path, changed: dict[str, Any], words: str
) -> None:
    recorder = Recorder(header=replace(HEADER, **changed))
    recorder.data()
    with pytest.raises(LogError, match="makes no sense: " + words):
        load(write(tmp_path / "SD.bin", recorder.image()))
