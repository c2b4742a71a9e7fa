"""When the robot was released: by the switch edges, by the logger's own events, by the samples; and the rule itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, event
from tests.sdlog.test_values import write
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof import one_rule
from tfsat_host.protocol import limits
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.messages import Event
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.events import DropEvent
from tfsat_host.sdlog.release import find_release

T_US = np.arange(0, 4_000_000, 4000, dtype=np.int64)


def edge(t_us: int, switch: int, is_open: bool) -> DropEvent:
    return DropEvent(t_us, "switch_edge", switch, int(is_open), 0)


def stroke(t_us: int) -> DropEvent:
    return DropEvent(t_us, "stroke", 0, 0, 0)


def levels(*opened_us: int) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    return np.stack([opened_us[switch] <= T_US for switch in range(2)], axis=1)


NEVER = 1 << 60


def sample_levels(events: list[DropEvent]) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Return the switch levels that the samples show for these edges."""
    switch_levels = levels(NEVER, NEVER)
    for drop_event in events:
        if drop_event.name == "switch_edge":
            switch_levels[drop_event.t_us <= T_US, drop_event.index] = bool(drop_event.arg)
    return switch_levels


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ([], None),
        ([edge(1_000_000, 0, True)], None),
        ([edge(1_000_000, 0, True), edge(1_000_250, 1, True)], 1_000_250),
        # Chatter after the first moment at which both were open.
        (
            [
                edge(1_000_000, 0, True),
                edge(1_000_250, 1, True),
                edge(1_001_000, 0, False),
                edge(1_003_000, 0, True),
            ],
            1_000_250,
        ),
        # A knock: both open, for less than the debounce; then the release.
        (
            [
                edge(1_000_000, 0, True),
                edge(1_000_100, 1, True),
                edge(1_002_000, 0, False),
                edge(1_002_100, 1, False),
                edge(2_000_000, 1, True),
                edge(2_000_300, 0, True),
            ],
            2_000_300,
        ),
        # Handled before the drop: the release is the last before the strokes.
        (
            [
                edge(500_000, 0, True),
                edge(500_000, 1, True),
                edge(900_000, 0, False),
                edge(900_000, 1, False),
                edge(1_500_000, 0, True),
                edge(1_500_700, 1, True),
                stroke(2_200_700),
                edge(3_000_000, 0, False),
                edge(3_000_000, 1, False),
                edge(3_100_000, 0, True),
                edge(3_100_000, 1, True),
            ],
            1_500_700,
        ),
    ],
)
def test_release(events: list[DropEvent], expected: int | None) -> None:
    release = find_release(events, T_US, sample_levels(events))
    assert (release.t_us if release else None) == expected
    assert release is None or release.uncertainty_us == 0


def test_lost_edges_are_replaced_by_the_samples_and_their_uncertainty() -> None:
    switch_levels = levels(1_000_000, 1_200_000)
    release = find_release((), T_US, switch_levels)
    assert release is not None
    assert (release.earliest_us, release.t_us, release.latest_us) == (1_196_000, 1_200_000, 1_200_000)


def test_switches_that_were_open_from_the_start_are_no_release() -> None:
    assert find_release((), T_US, levels(0, 0)) is None


@pytest.mark.parametrize("run", [1, 2, 3, 10, 40])
def test_whatever_blocks_are_lost_the_release_is_right_or_its_uncertainty_covers_it(
    run: int, tmp_path: Path
) -> None:
    recorder, release_us = drop_with_release()
    flagged = 0
    for first in range(1, len(recorder.blocks) - run):
        remaining_blocks = recorder.blocks[:first] + recorder.blocks[first + run :]
        log = load(write(tmp_path / "SD.bin", b"".join(remaining_blocks)))
        if log.release is None:
            assert log.verdict != "complete"
            assert log.doubts, "strokes without a release are doubtful"
            continue
        assert log.release.earliest_us <= release_us <= log.release.latest_us, first
        if log.release_us != release_us:
            flagged += 1
            assert log.t_s_origin == "release (doubtful)"
            assert any("release switches are lost" in doubt for doubt in log.doubts)
    assert flagged


OPEN = ALL_VALID | 0x0C00


class Story:
    """A recording by what happens to the switches; `releases` are the true times, `at` block numbers."""

    def __init__(self) -> None:
        self.recorder = Recorder(repeat_blocks=1 << 20)
        self.releases: list[int] = []
        self.at: list[int] = []
        self.closed = False

    def hang(self, blocks: int, events: Sequence[Event] = ()) -> None:
        for block in range(blocks):
            self.recorder.data(events=events if block == 0 else ())

    def open(self, blocks: int, *, recorded: bool = True, recorded_later_us: int = 0) -> None:
        """Open both switches; the logger records the release one block later."""
        first_us = self.now_us()
        release_us = first_us + 10
        self.releases.append(release_us)
        self.at.append(len(self.recorder.blocks))
        edges = [
            event(first_us, EventCode.SWITCH_EDGE, 0, 1),
            event(release_us, EventCode.SWITCH_EDGE, 1, 1),
        ]
        self.recorder.data(flags=OPEN, events=edges)
        release_events = [event(release_us + recorded_later_us, EventCode.RELEASE, 0, 1)] if recorded else []
        self.recorder.data(flags=OPEN, events=release_events)
        self.fall(blocks)

    def close(self, *, revokes: bool = True) -> None:
        """Close both switches; after 200 ms the logger revokes the release."""
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
        remaining_blocks = [
            block for number, block in enumerate(self.recorder.blocks) if number not in without
        ]
        return load(write(tmp_path / "SD.bin", b"".join(remaining_blocks)))


def knocked_then_dropped(*, lands: bool = True) -> Story:
    """Build a false release and, 2 s later, the drop, without strokes."""
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


@pytest.mark.parametrize("recorded", [False, True])
def test_what_follows_the_landing_is_no_release(tmp_path: Path, recorded: bool) -> None:
    story = Story()
    story.hang(20)
    story.open(60, recorded=recorded)
    story.land()
    story.close(revokes=False)
    story.open(20, recorded=False)
    log = story.load(tmp_path)
    assert (log.release_us, log.doubts) == (story.releases[0], ())


@pytest.mark.parametrize("recorded", [False, True])
def test_the_last_release_counts_where_neither_stroke_nor_landing_tells(
    tmp_path: Path, recorded: bool
) -> None:
    story = Story()
    story.hang(20)
    story.open(10, recorded=recorded)
    story.close(revokes=False)
    story.open(20, recorded=recorded)
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
    """Take the release from the logger's event when its switch edges are lost.

    Where the true release's edges are lost, it is still exact. Where the revoked release's edges are lost,
    the release that the samples show in their place is revoked too.
    """
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
    story.open(60, recorded_later_us=later_us)
    story.land()
    log = story.load(tmp_path)
    assert log.release_us == story.releases[0]
    recorded_at = f"recorded a release at {(story.releases[0] + later_us) / 1e6:.6f} s"
    assert [recorded_at in doubt for doubt in log.doubts] == [True] * doubted


def test_a_note_without_any_edges_is_a_doubt_and_no_time(tmp_path: Path) -> None:
    story = Story()
    story.hang(20)
    story.hang(20, [event(story.now_us(), EventCode.RELEASE, 0, 1)])
    log = story.load(tmp_path)
    assert log.release is None
    assert ["recorded a release" in doubt for doubt in log.doubts] == [True]


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
    """Assign a release between two files to the second file.

    Its edges and its event stand in the log with times before the first sample.
    """
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


@pytest.fixture(scope="module")
def rule(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return one_rule.build_rule(tmp_path_factory.mktemp("rule") / "rule.so")


def test_the_same_edges_give_the_same_releases(rule: Path) -> None:
    """Check that sequencer, logger and decoder find the same releases in 5000 edge trains.

    `make sequencer-report` compares them on a million.
    """
    agreement = one_rule.one_rule(rule, 59, 5_000)
    assert agreement.trains == 5_000
    assert agreement.releases > 1_000
    assert agreement.ambiguous > 300
    assert agreement.false_releases > 100


def test_a_rule_that_differs_by_a_microsecond_is_seen(rule: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HUNG", "DEBOUNCE", "BOUNCE", "CHATTER", "SEATED"):
        limit = f"tfsat_host.sdlog.release_rule.RELEASE_{name}_US"
        with monkeypatch.context() as context:
            context.setattr(limit, getattr(limits, f"RELEASE_{name}_US") + 1)
            with pytest.raises(Broken):
                one_rule.one_rule(rule, 59, 5_000)


def test_eleven_openings_of_a_millisecond_and_then_the_release(rule: Path) -> None:
    edges = []
    for number in range(11):
        for after_us, is_open in ((0, True), (1_000, False)):
            edges += [(one_rule.FIRST_US + 5_000 * number + after_us, switch, is_open) for switch in (0, 1)]
    released_us = one_rule.FIRST_US + 55_000
    edges += [(released_us, switch, True) for switch in (0, 1)]
    ((at_us, first_us, last_us, is_false),) = one_rule.compare(rule, edges, 0)
    assert (first_us, last_us, is_false) == (one_rule.FIRST_US, released_us, False)
    assert 0 <= released_us - at_us <= limits.RELEASE_BOUNCE_US
