"""Clocks on the logger's scale: strokes that came, came late, never came, or came too often; and a video's events."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evaluation.clock_log import log_with
from tests.fixtures.emulated_drop import drop
from tfsat_host.emulated.imperfections import Imperfections, draw
from tfsat_host.evaluation.camera import Mark, VideoFileError, read_video_marks
from tfsat_host.evaluation.clock_fit import Pair, fit_clock
from tfsat_host.evaluation.clocks import Clocks, align_clocks, match_starts
from tfsat_host.maneuver import Maneuver, Stroke, four_stroke, schedule_maneuver
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.release import Release

SCHEDULE = schedule_maneuver(four_stroke(59, 70))
PLANNED_S = np.array([stroke.t_s for stroke in SCHEDULE.strokes])


def align_strokes(folder: Path, strokes_s: list[float], **log_options: float) -> Clocks:
    return align_clocks(log_with(folder / "SD.bin", strokes_s, **log_options), SCHEDULE)


def test_equal_clocks(tmp_path: Path) -> None:
    clocks = align_strokes(tmp_path, PLANNED_S.tolist())
    fit = clocks.sequencer
    assert fit is not None and not fit.findings
    assert [residual.pair.event for residual in fit.residuals] == [
        "release",
        *(f"stroke {n}" for n in range(1, 5)),
    ]
    # Within two of its deviations, which five events over two seconds make no larger than 10 ppm.
    assert abs(fit.rate_ppm) < 2 * fit.rate_ppm_std < 20
    assert fit.to_logger_s(PLANNED_S) == pytest.approx(PLANNED_S, abs=2e-6)
    assert clocks.stroke_s == pytest.approx(PLANNED_S)
    assert clocks.notes == () and clocks.video is None


def test_strokes_that_begin_together_share_an_edge(tmp_path: Path) -> None:
    together = schedule_maneuver(
        Maneuver((Stroke(1, 60, 0.7), Stroke(2, 50, 0.7), Stroke(3, 40, 0.71), Stroke(1, -60, 1.31)))
    )
    clocks = align_clocks(log_with(tmp_path / "SD.bin", [0.7, 0.71, 1.31]), together)
    assert clocks.stroke_s == pytest.approx([0.7, 0.7, 0.71, 1.31])
    assert clocks.sequencer is not None and not clocks.sequencer.findings
    # The edge counts once: twice would halve its variance.
    assert [residual.pair.event for residual in clocks.sequencer.residuals] == [
        "release",
        "stroke 1",
        "stroke 3",
        "stroke 4",
    ]
    lacking = align_clocks(log_with(tmp_path / "SD.bin", [0.71, 1.31]), together).sequencer
    assert lacking is not None
    assert [finding for finding in lacking.findings if "not seen" in finding] == [
        "Stroke 1 was not seen by the logger.",
        "Stroke 2 was not seen by the logger.",
    ]


@pytest.mark.parametrize("rate", [0.01, -0.01, 0.001])
def test_a_board_whose_clock_is_no_crystal_s_is_measured_and_flagged(tmp_path: Path, rate: float) -> None:
    # 1 % is a resonator's error; crystals differ by some ten ppm.
    fit = align_strokes(tmp_path, (PLANNED_S / (1 + rate)).tolist()).sequencer
    assert fit is not None
    assert fit.rate_ppm == pytest.approx(1e6 * rate, abs=3 * fit.rate_ppm_std)
    assert all(residual.used for residual in fit.residuals)
    (finding,) = fit.findings
    assert f"{abs(rate) * 100:.3f} % {'fast' if rate > 0 else 'slow'}" in finding
    assert "than two crystals differ" in finding


def test_another_schedule_than_the_one_flown_is_no_clock(tmp_path: Path) -> None:
    # 2.5 %: even a resonator is not so far off, so that another schedule was flown.
    fit = align_strokes(tmp_path, (1.025 * PLANNED_S).tolist()).sequencer
    assert fit is not None
    assert "the schedule is not the one that was flown" in fit.findings[-1]


@pytest.mark.parametrize("stroke", [1, 2, 3, 4])
@pytest.mark.parametrize("late_ms", [-40, -3, 0.3, 3, 12])
def test_a_stroke_that_is_not_on_time_is_named_and_left_out(
    tmp_path: Path, stroke: int, late_ms: float
) -> None:
    # One of five events moved: the other four agree and outvote it.
    stroke_times_s = PLANNED_S.copy()
    stroke_times_s[stroke - 1] += 1e-3 * late_ms
    clocks = align_strokes(tmp_path, stroke_times_s.tolist())
    fit = clocks.sequencer
    assert fit is not None
    (finding,) = fit.findings
    assert finding.startswith(
        f"Stroke {stroke} is {abs(late_ms)} ms too {'late' if late_ms > 0 else 'early'}"
    )
    assert [residual.pair.event for residual in fit.residuals if not residual.used] == [f"stroke {stroke}"]
    assert abs(fit.rate_ppm) < 3 * fit.rate_ppm_std
    assert clocks.stroke_s == pytest.approx(stroke_times_s)


def test_strokes_that_all_came_late_contradict_the_release(tmp_path: Path) -> None:
    # The four strokes agree among each other, so the release is the outlier.
    fit = align_strokes(tmp_path, (PLANNED_S + 0.05).tolist()).sequencer
    assert fit is not None
    assert fit.findings[0].startswith("Release is 50 ms too early")
    assert fit.offset_s == pytest.approx(0.05, abs=1e-4)


def test_a_stroke_that_was_not_seen_and_an_edge_too_many(tmp_path: Path) -> None:
    # Stroke 2 is due at 1.05 s.
    clocks = align_strokes(tmp_path, [0.70, 0.9, 1.47, 1.82])
    fit = clocks.sequencer
    assert fit is not None
    # The edge at 0.9 s is 150 ms from stroke 2's time: too far to be it.
    assert fit.findings == (
        "Stroke 2 was not seen by the logger.",
        "The stroke line rose at 0.9000 s, where no stroke was scheduled.",
    )
    assert clocks.stroke_s == pytest.approx([0.70, np.nan, 1.47, 1.82], nan_ok=True)
    assert abs(fit.rate_ppm) < 10


@pytest.mark.parametrize(("strokes_s", "std_ppm"), [([0.70], 25), ([], 5000)])
def test_one_stroke_or_none_still_gives_an_answer(
    tmp_path: Path, strokes_s: list[float], std_ppm: float
) -> None:
    fit = align_strokes(tmp_path, strokes_s).sequencer
    assert fit is not None
    # With one stroke the rate follows from 0.7 s alone; with none only the prior of 5000 ppm is left.
    assert fit.rate_ppm_std == pytest.approx(std_ppm, rel=0.2)
    assert abs(fit.rate_ppm) < 1
    assert sum("was not seen" in finding for finding in fit.findings) == 4 - len(strokes_s)


def test_a_line_that_chatters_is_not_believed(tmp_path: Path) -> None:
    # 300 edges in a drop of four strokes.
    clocks = align_strokes(tmp_path, np.linspace(0.1, 2.4, 300).tolist())
    assert "rose 300 times" in clocks.notes[0]
    assert np.isnan(clocks.stroke_s).all()


def test_a_release_that_is_lost_is_told_by_the_strokes(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist())
    # Neither the release nor its switch edges are left in the log.
    blind = replace(log, release=None, events=tuple(e for e in log.events if e.name == "stroke"))
    fit = align_clocks(blind, SCHEDULE).sequencer
    assert fit is not None
    assert fit.offset_s == pytest.approx(log.origin_us / 1e6 - log.t_us[0] / 1e6, abs=2e-5)


def test_a_release_that_is_only_known_to_some_ms_weighs_as_much(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", (PLANNED_S + 0.003).tolist())
    at_us = log.origin_us
    # The release lies anywhere between -5 and +25 ms: strokes 3 ms late do not contradict it.
    release = Release(at_us, at_us - 5_000, at_us + 25_000, (at_us, at_us), touches_gap=True)
    fit = align_clocks(replace(log, release=release), SCHEDULE).sequencer
    assert fit is not None and not fit.findings
    assert fit.offset_s == pytest.approx(0.003, abs=1e-4)


def test_edges_from_before_the_drop_are_none_of_its_strokes(tmp_path: Path) -> None:
    fit = align_strokes(tmp_path, [-2.5, -1.0, *PLANNED_S]).sequencer
    assert fit is not None and not fit.findings


def test_nothing_known_is_said(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", [])
    clocks = align_clocks(replace(log, release=None), SCHEDULE)
    assert clocks.sequencer is None
    assert "neither a release nor strokes" in clocks.notes[0]


@given(
    st.floats(-0.012, 0.012),
    st.sets(st.integers(0, 3), max_size=2),
    st.lists(st.floats(-0.05, 2.45), max_size=2),
    st.integers(0, 2**32),
)
def test_strokes_are_found_whatever_is_missing_or_too_many(
    rate: float, missing: set[int], extra_s: list[float], seed: int
) -> None:
    """Extra edges stay a stroke's width away, or nobody could tell which edge is the stroke."""
    true_s = PLANNED_S / (1 + rate) + np.random.default_rng(seed).normal(0, 5e-6, 4)
    # Near a stroke's time nobody could tell an extra edge from the stroke.
    extra_s = [t_s for t_s in extra_s if np.abs(PLANNED_S - t_s).min() > 0.16 + 0.03 * t_s]
    edges_s = np.sort([*np.delete(true_s, list(missing)), *extra_s])
    matched = match_starts(PLANNED_S, edges_s, 0.0)
    matched_edges_s = {stroke: edges_s[edge] for stroke, edge in matched.edge_of_start.items()}
    assert matched_edges_s == {stroke: true_s[stroke] for stroke in range(4) if stroke not in missing}
    assert set(matched.unseen) == missing
    assert len(matched.extra) == len(extra_s)


def test_stated_deviations_are_those_of_the_errors() -> None:
    rng = np.random.default_rng(3)
    clock_s, std_s = np.array([0.0, 0.7, 1.05, 1.47, 1.82]), np.array([1e-3, 2e-3, 2e-3, 1e-3, 2e-3])
    z: list[list[float]] = []
    for _ in range(400):
        rate = rng.normal(0, 5e-3)
        logger_s = 3.0 + clock_s / (1 + rate) + std_s * rng.normal(size=5)
        # 400 fits of random clocks: offsets and rates in their stated deviations.
        fit = fit_clock("any", [Pair("x", *row) for row in zip(clock_s, logger_s, std_s, strict=True)])
        z.append([(fit.offset_s - 3.0) / fit.offset_std_s, (fit.rate_ppm - 1e6 * rate) / fit.rate_ppm_std])
    # Standard normal, within the sampling error of 400 values.
    assert np.std(z, axis=0) == pytest.approx(1.0, abs=0.12)
    assert np.mean(z, axis=0) == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(("sequencer_ppm", "logger_ppm"), [(40.0, -30.0), (-8000.0, 20.0)])
def test_the_emulated_boards_clocks(sequencer_ppm: float, logger_ppm: float) -> None:
    """Fit the relative clock rate of both boards' real firmware, each on its own clock."""
    wrong = replace(draw(5), sequencer_clock_ppm=sequencer_ppm, logger_clock_ppm=logger_ppm)
    fit = align_clocks(record_drop(wrong), SCHEDULE).sequencer
    assert fit is not None
    # Rates divide: the fit sees the sequencer's clock by the logger's.
    expected_ppm = 1e6 * ((1 + 1e-6 * sequencer_ppm) / (1 + 1e-6 * logger_ppm) - 1)
    assert fit.rate_ppm == pytest.approx(expected_ppm, abs=3)
    assert all(residual.used and abs(residual.residual_s) < 5e-6 for residual in fit.residuals)
    # Beyond 300 ppm, more than two crystals differ, the fit must flag the clock.
    assert (not fit.findings) == (abs(expected_ppm) < 300)


def record_drop(wrong_by: Imperfections) -> DropLog:
    return drop(imperfections=wrong_by, seed=5, wait_us=0).log


# ---- the video


def video(offset_s: float, rate: float, *, landing_s: float = 2.5) -> list[Mark]:
    events = [
        ("release", 0.0),
        *((f"stroke {n}", t) for n, t in enumerate(PLANNED_S, 1)),
        ("landing", landing_s),
    ]
    # 5 ms: a mark somewhere within a frame of 1/60 s.
    return [Mark(name, (t - offset_s) * (1 + rate), 0.005) for name, t in events]


def test_a_video_of_another_frame_rate(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist(), landing_s=2.5)
    fit = align_clocks(log, SCHEDULE, video(-12.4, 0.001)).video
    assert fit is not None and not fit.findings
    # The release stands at 12.4 s of the logger's clock since the video began; the video's own is 0.1 % fast.
    assert fit.to_logger_s(12.4 * 1.001) == pytest.approx(0.0, abs=1e-3)
    assert fit.rate_ppm == pytest.approx(1000.0, abs=1e-3) and 1000 < fit.rate_ppm_std < 4000
    stated = align_clocks(log, SCHEDULE, video(-12.4, 0.001), 1.0).video
    assert stated is not None and not stated.findings
    # Half a frame in 2.5 s tells a rate no better than what was said of it, and is pulled towards that.
    assert 0 < stated.rate_ppm < 1000 < stated.rate_ppm + stated.rate_ppm_std


@pytest.mark.parametrize("times", [2.0, 8.0, 0.25, 40.0])
def test_slow_motion_is_measured_and_a_wrong_event_among_six_is_the_one_that_is_blamed(
    tmp_path: Path, times: float
) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist(), landing_s=2.5)
    marks = video(-3.0, times - 1.0)
    fit = align_clocks(log, SCHEDULE, marks).video
    assert fit is not None and not fit.findings and 1.0 / fit.slope == pytest.approx(times, rel=1e-9)
    # 0.2 s by the logger's clock, in slow motion so many times longer.
    marks[3] = replace(marks[3], t_s=marks[3].t_s + 0.2 * times)
    fit = align_clocks(log, SCHEDULE, marks).video
    assert fit is not None and 1.0 / fit.slope == pytest.approx(times, rel=1e-6)
    assert [residual.pair.event for residual in fit.residuals if not residual.used] == ["stroke 3"]
    assert len(fit.findings) == 1 and fit.findings[0].startswith("Stroke 3 is ")


def test_what_events_cannot_tell_of_a_rate_is_not_told(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist(), landing_s=2.5)
    release, *strokes, landing = video(-3.0, 1.0)
    release_clocks = align_clocks(log, SCHEDULE, [release])
    assert (
        release_clocks.video is None and "of one event, release, no rate follows" in release_clocks.notes[0]
    )
    release_clocks = align_clocks(log, SCHEDULE, [release], 2.0)
    assert (
        release_clocks.video is not None
        and release_clocks.video.rate_ppm == pytest.approx(1e6)
        and not release_clocks.notes
    )
    two = align_clocks(log, SCHEDULE, [release, landing])
    assert two.video is not None and two.video.rate_ppm == pytest.approx(1e6)
    # Of three, each two are on a line: which one is wrong, nobody can say without the rate.
    three = [release, replace(strokes[1], t_s=strokes[1].t_s + 0.5), landing]
    clocks = align_clocks(log, SCHEDULE, three)
    assert clocks.video is None and "more than one rate suits" in clocks.notes[0]
    clocks = align_clocks(log, SCHEDULE, three, 2.0)
    assert clocks.video is not None and clocks.video.findings[0].startswith("Stroke 2 is ")
    wrong = align_clocks(log, SCHEDULE, [release, *strokes, landing], 1.0)
    assert wrong.video is None and "--video-rate says 1, and its events 2" in wrong.notes[0]


def test_two_strokes_that_were_taken_for_each_other(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist(), landing_s=2.5)
    marks = video(-3.0, 0.0)
    # Stroke 2 and stroke 3 confused by whoever set the marks.
    marks[2], marks[3] = replace(marks[2], t_s=marks[3].t_s), replace(marks[3], t_s=marks[2].t_s)
    fit = align_clocks(log, SCHEDULE, marks).video
    assert fit is not None
    assert fit.findings == ("Stroke 2 and stroke 3 seem to be swapped: exchanged, both fit.",)


def test_an_event_that_the_log_lacks_is_noted(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist())
    clocks = align_clocks(log, SCHEDULE, [Mark("landing", 9.0, 0.01)])
    assert clocks.video is None
    assert "landing could not be used" in clocks.notes[0]
    fit = align_clocks(log, SCHEDULE, [Mark("release", 9.0, 0.01)], 1.0).video
    assert fit is not None
    # The mark's 10 ms, and what the stated rate leaves open over 9 s.
    assert fit.offset_s == pytest.approx(-9.0, abs=1e-6) and fit.offset_std_s == pytest.approx(
        0.0135, abs=0.001
    )


def test_a_landing_that_the_logger_only_counted_off_is_none(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", PLANNED_S.tolist(), landing_s=5.0)
    # arg 0: the logger stopped by its time limit, no shock was felt.
    counted = [replace(event, arg=0) if event.name == "landing" else event for event in log.events]
    clocks = align_clocks(replace(log, events=tuple(counted)), SCHEDULE, video(-3.0, 0.0))
    assert clocks.video is not None and not clocks.video.findings
    assert "landing could not be used" in clocks.notes[0]


def test_the_file_of_a_video(tmp_path: Path) -> None:
    file = tmp_path / "video.csv"
    file.write_text(
        # As a spreadsheet writes it: a byte order mark, spaces, an empty line, a remark, no order.
        "\ufeffevent, t_s ,std_s,remark\nLanding,14.9,,thud\n stroke  1 ,13.1,0.004\n\nrelease,12.4,\n"
    )
    marks = read_video_marks(file)
    assert [(mark.event, mark.t_s) for mark in marks] == [
        ("release", 12.4),
        ("stroke 1", 13.1),
        ("landing", 14.9),
    ]
    # Without std_s: uniform within a frame of 1/60 s.
    assert [mark.std_s for mark in marks] == pytest.approx([1 / 60 / 12**0.5, 0.004, 1 / 60 / 12**0.5])


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("event\nrelease\n", 1, "no column t_s"),
        ("event,t_s,t_s\nrelease,1,1\n", 1, "there 2 times"),
        ("event,t_s\nrelease,1\nstroke 1,\n", 3, "t_s is missing"),
        ("event,t_s\nrelease,1;5\n", 2, "'1;5'"),
        ("event,t_s\nrelease,1e99\n", 2, "beyond 1e+06"),
        ("event,t_s\nstroke 17,1\n", 2, "the event is 'stroke 17'"),
        ("event,t_s\nrelease,1\nrelease,2\n", 3, "a second time"),
        ("event,t_s,std_s\nrelease,1,0\n", 2, "must be above 0"),
        ("event,t_s\n", None, "no event"),
        ('event,t_s\n"release,1\n', None, "no CSV file"),
        (None, None, "No such file"),
        ("\udcff", None, "no text in UTF-8"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str | None, line: int | None, words: str) -> None:
    file = tmp_path / "video.csv"
    if text is not None:
        file.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(VideoFileError) as refused:
        read_video_marks(file)
    assert words in refused.value.what
    assert refused.value.what.startswith(f"{file}:{line}: " if line else f"{file}: ")
    assert refused.value.next_step and "clock" in refused.value.meaning
