"""The logger's own notes of a release, beside what the switch edges tell."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder, event
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.messages import Event
from tfsat_host.sdlog import DropLog, load

OPEN = ALL_VALID | 0x0C00


class Story:
    """A recording told by what happens to the switches; `releases` are the true times, `at` block numbers."""

    def __init__(self) -> None:
        self.recorder = Recorder(repeat_blocks=1 << 20)
        self.releases: list[int] = []
        self.at: list[int] = []
        self.closed = False

    def hang(self, blocks: int, events: Sequence[Event] = ()) -> None:
        for block in range(blocks):
            self.recorder.data(events=events if block == 0 else ())

    def open(self, blocks: int, *, noted: bool = True, noted_later_us: int = 0) -> None:
        """Both switches open; the logger notes it a block later."""
        first_us = self.now_us()
        release_us = first_us + 10
        self.releases.append(release_us)
        self.at.append(len(self.recorder.blocks))
        edges = [
            event(first_us, EventCode.SWITCH_EDGE, 0, 1),
            event(release_us, EventCode.SWITCH_EDGE, 1, 1),
        ]
        self.recorder.data(flags=OPEN, events=edges)
        said = [event(release_us + noted_later_us, EventCode.RELEASE, 0, 1)] if noted else []
        self.recorder.data(flags=OPEN, events=said)
        self.fall(blocks)

    def close(self, *, revokes: bool = True) -> None:
        """Both close, and after 200 ms the logger takes the release back."""
        self.hang(12, [event(self.now_us() + 10 * i, EventCode.SWITCH_EDGE, i, 0) for i in range(2)])
        self.hang(1, [event(self.releases[-1], EventCode.RELEASE, 0, 0)] if revokes else [])

    def fall(self, blocks: int, events: Sequence[Event] = ()) -> None:
        for block in range(blocks):
            self.recorder.data(flags=OPEN, events=events if block == 0 else ())

    def land(self) -> None:
        self.fall(1, [event(self.now_us(), EventCode.LANDING, 0, 1, 9000)])

    def now_us(self) -> int:
        return self.recorder.time_us(self.recorder.samples)

    def load(self, tmp_path: Path, *, without: range = range(0)) -> DropLog:
        if not self.closed:
            self.recorder.close()
        self.closed = True
        left = [block for number, block in enumerate(self.recorder.blocks) if number not in without]
        return load(write(tmp_path / "SD.bin", b"".join(left)))


def knocked_then_dropped(*, lands: bool = True) -> Story:
    """A release that was none, and 2 s later the drop, without strokes."""
    story = Story()
    story.hang(20)
    story.open(10)
    story.close()
    story.hang(90)
    story.open(60)
    if lands:
        story.land()
        story.fall(20)
    return story


@pytest.mark.parametrize("lands", [False, True])
def test_a_release_that_the_logger_revoked_is_none(tmp_path: Path, lands: bool) -> None:
    story = knocked_then_dropped(lands=lands)
    log = story.load(tmp_path)
    assert (log.release_us, log.release_uncertainty_us) == (story.releases[1], 0)
    assert (log.t_s_origin, log.verdict, log.doubts) == ("release", "complete", ())


def test_only_a_revoked_release_is_none(tmp_path: Path) -> None:
    story = Story()
    story.hang(20)
    story.open(10)
    story.close()
    story.hang(20)
    log = story.load(tmp_path)
    assert (log.release, log.t_s_origin, log.doubts) == (None, "first sample", ())


@pytest.mark.parametrize("noted", [False, True])
def test_what_follows_the_landing_is_no_release(tmp_path: Path, noted: bool) -> None:
    story = Story()
    story.hang(20)
    story.open(60, noted=noted)
    story.land()
    story.close(revokes=False)
    story.open(20, noted=False)
    log = story.load(tmp_path)
    assert (log.release_us, log.doubts) == (story.releases[0], ())


@pytest.mark.parametrize("noted", [False, True])
def test_the_last_release_counts_where_neither_stroke_nor_landing_tells(tmp_path: Path, noted: bool) -> None:
    story = Story()
    story.hang(20)
    story.open(10, noted=noted)
    story.close(revokes=False)
    story.open(20, noted=noted)
    log = story.load(tmp_path)
    assert (log.release_us, log.doubts) == (story.releases[1], ())


def test_the_first_stroke_tells_more_than_the_logger(tmp_path: Path) -> None:
    story = Story()
    story.hang(20)
    story.open(40)
    story.fall(1, [event(story.releases[0] + 700_000, EventCode.STROKE)])
    story.close(revokes=False)
    story.open(20)
    story.land()
    log = story.load(tmp_path)
    assert (log.release_us, log.doubts) == (story.releases[0], ())


@pytest.mark.parametrize("run", [1, 2, 5])
@pytest.mark.parametrize("which", [0, 1])
def test_without_its_edges_the_loggers_note_gives_the_release(tmp_path: Path, which: int, run: int) -> None:
    """Of the true release: it is exact. Of the revoked one: what the samples show of it is revoked too."""
    story = knocked_then_dropped()
    at = story.at[which]
    log = story.load(tmp_path, without=range(at - run + 1, at + 1))
    assert log.verdict == "damaged"
    assert (log.release_us, log.release_uncertainty_us) == (story.releases[1], 0)
    assert (log.t_s_origin, log.doubts) == ("release", ())


def test_a_recording_of_which_the_start_is_lost_with_the_edges(tmp_path: Path) -> None:
    story = Story()
    story.hang(20)
    story.open(60)
    story.land()
    log = story.load(tmp_path, without=range(1, story.at[0] + 1))
    assert (log.release_us, log.release_uncertainty_us) == (story.releases[0], 0)


@pytest.mark.parametrize("run", [1, 3, 10, 40, 60, 120])
def test_whatever_is_lost_the_release_is_right_or_doubted(tmp_path: Path, run: int) -> None:
    story = knocked_then_dropped()
    exact = 0
    for first in range(1, len(story.recorder.blocks) - run, max(1, run // 3)):
        log = story.load(tmp_path, without=range(first, first + run))
        if log.release is None:
            assert log.doubts or story.at[1] in range(first, first + run), first
            continue
        assert log.release.earliest_us <= story.releases[1] <= log.release.latest_us, first
        exact += log.release_us == story.releases[1]
        assert log.release_us == story.releases[1] or log.doubts
    assert exact


@pytest.mark.parametrize(("later_us", "doubted"), [(3, False), (40, True), (-40, True)])
def test_a_note_that_the_edges_contradict_is_a_doubt(tmp_path: Path, later_us: int, doubted: bool) -> None:
    story = Story()
    story.hang(20)
    story.open(60, noted_later_us=later_us)
    story.land()
    log = story.load(tmp_path)
    assert log.release_us == story.releases[0]
    noted_at = f"noted a release at {(story.releases[0] + later_us) / 1e6:.6f} s"
    assert [noted_at in doubt for doubt in log.doubts] == [True] * doubted


def test_a_note_without_any_edges_is_a_doubt_and_no_time(tmp_path: Path) -> None:
    story = Story()
    story.hang(20)
    story.hang(20, [event(story.now_us(), EventCode.RELEASE, 0, 1)])
    log = story.load(tmp_path)
    assert log.release is None
    assert ["noted a release" in doubt for doubt in log.doubts] == [True]


def test_a_hole_that_may_hide_another_release_is_a_doubt(tmp_path: Path) -> None:
    """Closing, the logger's revoking and the true release, all of it lost."""
    story = Story()
    story.hang(20)
    story.open(10)
    closes_at = len(story.recorder.blocks)
    story.close()
    story.open(60)
    story.land()
    log = story.load(tmp_path, without=range(closes_at, story.at[1] + 2))
    assert log.release is not None
    assert log.release.t_us == story.releases[0]
    assert log.release.earliest_us <= story.releases[1] <= log.release.latest_us
    assert log.t_s_origin == "release (doubtful)"


def test_a_release_between_two_files_is_the_second_files(tmp_path: Path) -> None:
    """Its edges and its event stand in the log with times before the first sample."""
    recorder = Recorder()
    released_us = recorder.time_us(0) - 12_000
    edges = [
        event(released_us - 900, EventCode.SWITCH_EDGE, 0, 1),
        event(released_us, EventCode.SWITCH_EDGE, 1, 1),
    ]
    recorder.data(flags=OPEN, events=edges)
    recorder.data(flags=OPEN, events=[event(released_us, EventCode.RELEASE, 0, 1)])
    for _ in range(40):
        recorder.data(flags=OPEN)
    recorder.close()
    path = tmp_path / "SD.bin"
    path.write_bytes(recorder.image())
    log = load(path)
    assert (log.release_us, log.release_uncertainty_us, log.verdict, log.doubts) == (
        released_us,
        0,
        "complete",
        (),
    )
