"""Boards whose crystals are off: what happens when, in virtual time and in the clock of the logger that notes it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fixtures.emulated_drop import OF_THE_PAPER, read_card, releaser
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import draw, draw_as_built, ideal
from tfsat_host.emulated.library import EmulationError
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.messages import HelloRequest
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog

SCHEDULE_S = np.array([0.70, 1.05, 1.47, 1.82])
MOVED_JOINTS = (0, 1, 0, 1)
RELEASED_US = 2_000_000
LANDED_US = 4_510_000
TRUTH_US = 500
BOTH = pytest.mark.parametrize("sequencer", ["native", "avr"])


@dataclass(frozen=True, eq=False)
class Flight:
    """One drop of 59/70 at a fixed virtual time; `truth` begins just before it."""

    log: DropLog
    truth: NDArray[np.float64]
    released_s: float
    state: SequencerState

    def strokes_noted_s(self) -> NDArray[np.float64]:
        """Return the times of the noted strokes after the release, in the logger's clock."""
        release_us = self.log.release_us
        assert release_us is not None
        stroke_times_us = [event.t_us - release_us for event in self.log.events if event.name == "stroke"]
        return np.array(stroke_times_us) * 1e-6

    def strokes_seen_s(self) -> NDArray[np.float64]:
        """Return the true times of the strokes after the release, in virtual time.

        Each is the time of the first truth row by which a resting joint has moved.
        """
        # A joint that rests moves less than 1e-5 rad in a step.
        moves = np.abs(np.diff(self.truth[:, 1:4], axis=0)) > 1e-5
        # The first row of a motion, not every row of it.
        begun = moves & ~np.vstack([np.zeros((1, 3), bool), moves[:-1]])
        t_s = self.truth[1:, 0] - self.released_s
        onsets_s = np.concatenate([t_s[column & (t_s > 0) & (t_s < 2)] for column in begun.T[:2]])
        return np.asarray(np.sort(onsets_s))


@cache
def fly(sequencer: str, sequencer_ppm: float, logger_ppm: float) -> Flight:
    """Exact servos and sensors, so that the clocks alone are off."""
    wrong = replace(ideal(), sequencer_clock_ppm=sequencer_ppm, logger_clock_ppm=logger_ppm)
    with releaser(imperfections=wrong, sequencer=sequencer) as (robot, board, logger):
        board.upload(OF_THE_PAPER)
        logger.start_recording()
        board.arm()
        # At a fixed time, so that the flights of both clocks can be compared.
        robot.advance(RELEASED_US - robot.now_us)
        robot.record_truth(TRUTH_US)
        robot.drop()
        robot.advance(LANDED_US - robot.now_us)
        truth = robot.truth()
        logger.stop_recording()
        return Flight(read_card(robot), truth, robot.released_us * 1e-6, board.status().state)


@BOTH
@pytest.mark.parametrize("ppm", [-20_000.0, -5_000.0, 50.0, 10_000.0, 20_000.0])
def test_strokes_come_when_the_sequencers_clock_says(sequencer: str, ppm: float) -> None:
    exact, off = fly(sequencer, 0.0, 0.0), fly(sequencer, ppm, 0.0)
    truly_s = SCHEDULE_S / (1 + 1e-6 * ppm)
    assert off.state is SequencerState.DONE
    # The logger is exact: it notes virtual time. The AVR's image takes some 20 us to see a release.
    assert off.strokes_noted_s() == pytest.approx(truly_s, abs=25e-6)
    # The joints move as much earlier or later as the strokes are noted.
    shift_s = off.strokes_seen_s() - exact.strokes_seen_s()
    assert shift_s == pytest.approx(truly_s - SCHEDULE_S, abs=1.01e-6 * TRUTH_US)


@BOTH
@pytest.mark.parametrize(
    ("sequencer_ppm", "logger_ppm"), [(0.0, 10_000.0), (0.0, -35.0), (20_000.0, -20_000.0)]
)
def test_the_logger_notes_the_release_and_strokes_in_its_own_time(
    sequencer: str, sequencer_ppm: float, logger_ppm: float
) -> None:
    off = fly(sequencer, sequencer_ppm, logger_ppm)
    rate = 1 + 1e-6 * logger_ppm
    assert off.log.verdict == "complete" and off.log.samples_lost == 0 and off.log.doubts == ()
    assert off.log.release_us == pytest.approx(off.released_s * 1e6 * rate, abs=2)
    assert off.strokes_noted_s() == pytest.approx(SCHEDULE_S * rate / (1 + 1e-6 * sequencer_ppm), abs=25e-6)


@pytest.mark.parametrize("ppm", [-20_000.0, 0.0, 10_000.0])
def test_the_loggers_samples_are_of_the_instants_at_which_its_clock_says_so(ppm: float) -> None:
    off = fly("native", 0.0, ppm)
    rate = 1 + 1e-6 * ppm
    period_us = np.diff(off.log.t_us)
    assert period_us.mean() == pytest.approx(1e6 / off.log.header.rate_hz, abs=0.01)
    assert np.ptp(period_us) <= 1
    # In the third stroke joint 1 goes back with 200 deg/s: 0.02 deg are 0.1 ms, 1 % of 3.5 s are 35.
    sampled_s = off.log.t_us * 1e-6 / rate
    stroke = np.flatnonzero((sampled_s > RELEASED_US * 1e-6 + 1.5) & (sampled_s < RELEASED_US * 1e-6 + 1.75))
    shown_deg = (off.log.angle_counts[stroke, 0] + 0.5) * 360 / 4096
    true_deg = np.rad2deg(np.interp(sampled_s[stroke], off.truth[:, 0], off.truth[:, 1]))
    sensor = load_robot().angle_sensors[0]
    expected_deg = np.rad2deg(sensor.zero_offset_rad) + sensor.direction * true_deg
    assert np.ptp(true_deg) > 40
    wrong_deg = (shown_deg - expected_deg + 180) % 360 - 180
    assert np.abs(wrong_deg).max() < 0.1
    assert abs(wrong_deg.mean()) < 0.02


@pytest.mark.parametrize("ppm", [-20_000.0, 10_000.0])
def test_the_loggers_clock_leaves_the_world_alone(ppm: float) -> None:
    exact, off = fly("native", 0.0, 0.0), fly("native", 0.0, ppm)
    assert off.released_s == exact.released_s
    assert np.array_equal(off.truth[:, 0], exact.truth[:, 0])
    # Steps of the integration end at samples, too: as much as that may differ.
    # The integration ends its steps at samples: the same motion, to its accuracy.
    assert np.abs(off.truth - exact.truth).max() < 1e-7


@pytest.mark.parametrize("ppm", [-10_000.0, 10_000.0])
def test_pulses_are_as_much_shorter_as_the_sequencer_is_fast(ppm: float) -> None:
    exact, off = fly("native", 0.0, 0.0), fly("native", ppm, 0.0)
    for joint in (0, 1):
        pulses = load_robot().servos[joint].pulses
        assert pulses is not None
        reached_rad = exact.truth[:, 1 + joint].max()
        # The pulse that brought the joint there, by its servo's line.
        pulse_us = pulses.reference_pulse_us + pulses.pulse_us_per_rad * (
            reached_rad - pulses.reference_angle_rad
        )
        # A fast clock counts a microsecond too soon: the pulse is that much shorter.
        missing_rad = pulse_us * (1 - 1 / (1 + 1e-6 * ppm)) / pulses.pulse_us_per_rad
        assert off.truth[:, 1 + joint].max() == pytest.approx(reached_rad - missing_rad, abs=np.deg2rad(0.01))
        assert abs(missing_rad) > np.deg2rad(1.0)


@pytest.mark.parametrize("ppm", [20_001.0, -20_001.0, 1e6, float("inf"), float("nan")])
def test_a_clock_that_no_board_has_is_refused(ppm: float) -> None:
    for wrong in (replace(ideal(), sequencer_clock_ppm=ppm), replace(ideal(), logger_clock_ppm=ppm)):
        with pytest.raises(EmulationError, match=r"clock cannot be off by \S+ ppm, only by 20000 either way"):
            EmulatedRobot(imperfections=wrong)


def test_clocks_are_exact_but_in_a_robot_as_built() -> None:
    for exact in (ideal(), draw(1), draw(2)):
        assert exact.sequencer_clock_ppm == exact.logger_clock_ppm == 0.0
    clock_errors_ppm = np.array(
        [
            (imperfections.sequencer_clock_ppm, imperfections.logger_clock_ppm)
            for imperfections in map(draw_as_built, range(400))
        ]
    )
    # The clocks are drawn with 20 ppm of standard deviation and cut at 50.
    assert np.abs(clock_errors_ppm).max() == 50.0
    assert clock_errors_ppm.std(axis=0) == pytest.approx([20.0, 20.0], rel=0.1)
    # Two boards: their crystals are not correlated.
    assert abs(np.corrcoef(clock_errors_ppm.T)[0, 1]) < 0.15


def test_what_else_a_seed_draws_is_what_it_drew_before_there_were_clocks() -> None:
    # The last of them: one more draw in between would change it.
    repeat_deg = np.rad2deg(draw_as_built(1).servo_repeat_rad)
    assert repeat_deg == pytest.approx([0.277104, 0.232071, 0.149110], abs=1e-6)


def test_reading_ends_with_the_first_byte_or_at_its_deadline() -> None:
    with EmulatedRobot() as robot:
        robot.advance(SETTLE_US)
        port = EmulatedTransport(robot, BoardIndex.LOGGER)
        before_us = robot.now_us
        assert port.read(0.00075) == b""  # nobody has asked the board anything
        assert robot.now_us == before_us + 750
        port.write(encode_frame(Frame(HelloRequest.TYPE, 1, HelloRequest().encode())))
        assert port.read(10.0) != b""
        assert robot.now_us < before_us + 100_000
