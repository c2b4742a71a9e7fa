"""`tfsat-host calibrate servo`: emulated servos of known errors, measured and corrected, and what must not go on."""

from __future__ import annotations

import io
import signal
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.servo_rig import (
    BACKLASHES_DEG,
    GAINS,
    MODEL,
    OFFSETS_DEG,
    befall,
    rig,
    wrong,
)
from tests.cli.process import RunCli
from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns
from tfsat_host.calibration.servos.servo_findings import compute_gain, compute_offset, predict_residuals
from tfsat_host.calibration.servos.servo_map import settings_from_map
from tfsat_host.calibration.servos.visits import at_stops, servo_map_of, servo_points
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Step, rest, servo, sweeps
from tfsat_host.cli.calibrate.jogged_joint import sweep
from tfsat_host.cli.main import main
from tfsat_host.devices.jog_path import JogError, JogInterrupted
from tfsat_host.emulated.emulated_robot import BoardIndex, Reset
from tfsat_host.emulated.imperfections import draw_as_built, ideal
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.servo_settings import FACTORY

# What is found


@cache
def measured_twice(joint: int) -> tuple[Evidence, Evidence, tuple[JointSensors, ...]]:
    """Measure a joint's servo with the factory's settings and with those that follow.

    Return both measurements and the joints' angle sensors.
    """
    with rig(wrong()) as here:
        sensors = here.solution().joints
        evidence = here.measure_joint(joint)
        here.bench.jog.write_settings(settings_from_map(servo_map_of(evidence, sensors, MODEL), FACTORY))
        again = here.measure_joint(joint)
        assert here.is_let_go(joint)
    return evidence, again, sensors


@pytest.mark.parametrize("joint", [1, 3])
def test_the_map_is_the_servos_own_and_the_new_settings_make_its_angles_true(joint: int) -> None:
    evidence, again, sensors = measured_twice(joint)
    assert len(evidence.visits) == 24
    before = FACTORY.of(joint)
    assert evidence.servo_setting == (before.zero_us, before.ns_per_deg, before.reversed)
    servo_map = servo_map_of(evidence, sensors, MODEL)
    assert compute_gain(servo_map).value == pytest.approx(GAINS[joint - 1], rel=0.003)
    assert compute_offset(servo_map).value == pytest.approx(OFFSETS_DEG[joint - 1], abs=0.15)
    assert np.rad2deg(servo_map.backlash_rad) == pytest.approx(BACKLASHES_DEG[joint - 1], abs=0.2)
    residuals = predict_residuals(
        servo_map_of(again, sensors, MODEL), settings_from_map(servo_map, FACTORY).of(joint)
    )
    assert residuals.mean_deg < 0.1 + 2 * np.rad2deg(servo_map.repeatability_rad)


@pytest.mark.parametrize("robots", [1, pytest.param(6, marks=pytest.mark.prove)])
def test_intervals_hold_what_a_scattering_servo_in_a_persons_hands_does(robots: int) -> None:
    """Robots as they are built: errors over their standard deviations."""
    ratios = []
    for seed in range(robots):
        built = replace(draw_as_built(seed), angle_nonlinearity_rad=np.zeros((6, 4)))
        with rig(built, Operator.human(seed), seed) as here:
            servo_map = servo_map_of(here.measure_joint(1), here.solution().joints, MODEL)
            gain, offset = compute_gain(servo_map), compute_offset(servo_map)
            ratios.append((gain.value - built.servo_gain[0]) / gain.std)
            ratios.append((offset.value - np.rad2deg(built.servo_offset_rad[0])) / offset.std)
            ratios.append((servo_map.backlash_rad - built.servo_backlash_rad[0]) / servo_map.backlash_std_rad)
            assert servo_map.repeatability_rad == pytest.approx(built.servo_repeat_rad[0], rel=0.6)
    assert np.max(np.abs(ratios)) < 4.0
    if robots > 1:
        assert np.mean(np.abs(ratios) < 2.0) >= 0.8
        assert 0.4 < np.sqrt(np.mean(np.square(ratios))) < 1.6


# What must not go on


def test_a_dead_servo_is_seen_at_the_first_stop() -> None:
    with rig(replace(wrong(), servo_gain=np.zeros(3))) as here:
        before_us = here.robot.now_us
        with pytest.raises(CalibrationError, match=r"Joint 2 did not follow: 15 deg were commanded"):
            here.measure_joint(2)
        assert here.robot.now_us - before_us < 9_000_000
        assert here.is_let_go(2)


def test_a_reversed_servo_is_let_go_at_the_first_stop() -> None:
    with rig(ideal()) as here:
        backwards = replace(FACTORY.of(1), zero_us=2000, reversed=1)
        here.bench.jog.write_settings(replace(FACTORY, servos=(backwards, *FACTORY.servos[1:])))
        before_us = here.robot.now_us
        with pytest.raises(CalibrationError, match="Joint 1 moves the wrong way") as caught:
            here.measure_joint(1)
        assert "reversed = false and zero_us = 1000" in caught.value.next_step
        assert here.robot.now_us - before_us < 9_000_000
        assert here.is_let_go(1)


def test_the_joint_must_be_where_the_first_pulse_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    with rig(ideal()) as here:

        def open_joint(_step: Step) -> None:
            here.robot.hold(servo(1).held)
            here.robot.operator.move_joint(1, Motion((Leg(np.deg2rad(40.0), 0.5),), Operator.steady(), 1))
            here.robot.advance(2_000_000)

        monkeypatch.setattr(here.bench.mover, "begin", open_joint)
        with pytest.raises(
            RefusedError, match="Joint 1 is at 40 deg, and its first pulse would take it to 0"
        ):
            here.measure_joint(1)
        assert here.robot.joint_angles_deg()[0] == pytest.approx(40.0, abs=1.0)
        assert here.is_let_go(1)


def test_ctrl_c_lets_the_joint_go(monkeypatch: pytest.MonkeyPatch) -> None:
    with rig(ideal()) as here:
        befall(here, monkeypatch, 80, lambda: signal.raise_signal(signal.SIGINT))
        with pytest.raises(JogInterrupted) as caught:
            here.measure_joint(1)
        assert 5 < here.robot.joint_angles_deg()[0] < 60
        assert caught.value.angle_cdeg == pytest.approx(100 * here.robot.joint_angles_deg()[0], abs=300)
        assert "Bring it to 0 deg by hand and type the same command again." in caught.value.next_step
        assert here.is_let_go(1)


def test_a_silent_logger_lets_the_joint_go(monkeypatch: pytest.MonkeyPatch) -> None:
    with rig(ideal()) as here:
        silent_us: list[int] = []

        def reset() -> None:
            silent_us.append(here.robot.now_us)
            here.robot.set_power(BoardIndex.LOGGER, False)
            here.robot.advance(50_000)
            here.robot.set_power(BoardIndex.LOGGER, True)

        befall(here, monkeypatch, 80, reset)
        with pytest.raises(TfsatError, match="No live sample from the logger for 1 s"):
            here.measure_joint(1)
        assert here.robot.now_us - silent_us[0] < 2_500_000
        assert here.is_let_go(1)


def test_a_pulled_sequencer_cable_says_that_nobody_knows(monkeypatch: pytest.MonkeyPatch) -> None:
    with rig(ideal()) as here:
        befall(here, monkeypatch, 80, lambda: here.robot.set_cable(BoardIndex.SEQUENCER, False))
        with pytest.raises(JogError, match="did not confirm that it let joint 1 go"):
            here.measure_joint(1)
        here.robot.set_cable(BoardIndex.SEQUENCER, True)
        here.robot.advance(500_000)
        assert here.is_let_go(1)


def test_a_board_that_restarts_ends_the_tour(monkeypatch: pytest.MonkeyPatch) -> None:
    with rig(ideal()) as here:
        befall(here, monkeypatch, 80, lambda: here.robot.reset(Reset.BROWN_OUT))
        with pytest.raises(JogError, match=r"restarted .* which ended the jog") as caught:
            here.measure_joint(1)
        assert "then bring it to 0 deg by hand and type the same command again." in caught.value.next_step
        assert "--from" not in caught.value.next_step
        assert here.is_let_go(1)


def test_a_sensor_that_slipped_or_fell_silent_is_named() -> None:
    evidence, _, sensors = measured_twice(3)
    slipped = replace(sensors[2], zero_rad=sensors[2].zero_rad + np.deg2rad([0.0, 3.0]))
    with pytest.raises(CalibrationError, match="The two sensors of joint 3 disagree"):
        servo_points(evidence, (*sensors[:2], slipped), MODEL)
    valid = evidence.counts.angle_valid.copy()
    valid[:, sensor_columns(MODEL, 3)[1]] = False
    with pytest.raises(CalibrationError, match="Angle sensor 2 of joint 3 gave no value"):
        servo_points(replace(evidence, counts=replace(evidence.counts, angle_valid=valid)), sensors, MODEL)
    moved = replace(evidence.visits[3], from_us=evidence.visits[3].from_us - 2_000_000)
    with pytest.raises(CalibrationError, match="Joint 3 did not come to rest"):
        servo_points(replace(evidence, visits=(moved,)), sensors, MODEL)
    early = replace(evidence.visits[3], to_us=evidence.visits[3].from_us + 20_000)
    with pytest.raises(CalibrationError, match=r"Only \d+ samples came"):
        servo_points(replace(evidence, visits=(early,)), sensors, MODEL)


def test_a_joint_that_its_stop_keeps_from_closing_is_not_measured_there() -> None:
    with rig(
        replace(wrong(), servo_offset_rad=np.deg2rad([-3.0, 0.0, 0.0]), servo_backlash_rad=np.zeros(3))
    ) as here:
        evidence, sensors = here.measure_joint(1), here.solution().joints
    points = servo_points(evidence, sensors, MODEL)
    stopped = at_stops(points, 1, MODEL)
    assert [met for met in stopped if met] == [True, True]
    assert all((point.pulse_us == 1000.0) == met for point, met in zip(points, stopped, strict=True))
    servo_map = servo_map_of(evidence, sensors, MODEL)
    assert servo_map.places == 6
    assert compute_offset(servo_map).value == pytest.approx(-3.0, abs=0.05)


def test_what_the_zero_point_is_not_known_by_is_in_the_offset() -> None:
    evidence, _, sensors = measured_twice(1)
    unsure = replace(sensors[0], zero_covariance=np.diag(np.deg2rad([2.0, 2.0]) ** 2))
    offset = compute_offset(servo_map_of(evidence, (unsure, *sensors[1:]), MODEL))
    assert offset.std == pytest.approx(np.sqrt(2.0), rel=0.05), "the mean of two sensors"


# With the servo instead of a hand


def test_a_sweep_by_the_servo_tells_the_gyros_scale_as_one_by_hand_does() -> None:
    scaled = replace(wrong(), gyro_scale=np.full((4, 3), 1.02), gyro_noise_rad_s_rthz=np.deg2rad(0.005))
    with rig(scaled) as here:
        still = here.read(rest(), 10.0)
        step = sweeps(1)[0]
        swept = sweep(step, here.bench, here.out)
        check_step(swept, [still, here.zeros], MODEL)
        assert swept.counts.samples_lost == 0
        assert here.is_let_go(1)
    (body,) = step.moved
    gyro = solve([still, here.zeros, swept], MODEL).gyros[body - 1]
    assert gyro.scale[0] == pytest.approx(1.02, abs=0.003)


# As a person has it


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.usefixtures("short_steps")
def test_the_whole_command(tfsat_host: RunCli) -> None:
    servo_1 = ("calibrate", "servo", "--joint", "1", "--emulated")
    without = tfsat_host.json(*servo_1, "--yes", expect=1)["error"]
    assert without["what"] == "The zero point of joint 1 is not calibrated."
    assert without["next_step"].endswith("tfsat-host calibrate zero --joint 1 --emulated")
    tfsat_host("calibrate", "zero", "--joint", "1", "--emulated", "--yes")
    first_result = tfsat_host.json(*servo_1, "--yes", "--no-upload")
    assert (first_result["uploaded"], first_result["verified"]) == (False, False)
    assert len(first_result["points"]) == 24
    stored_servos = tfsat_host.json("upload-servos", "--show", "--emulated")["servos"]
    assert stored_servos == first_result["settings"]["before"]["servos"]
    resumed_result = tfsat_host.json(*servo_1, "--yes", "--resume")
    assert resumed_result["map"] == pytest.approx(first_result["map"]), "the measurement was kept"
    assert (resumed_result["uploaded"], resumed_result["verified"]) == (True, True)
    assert (
        tfsat_host.json("upload-servos", "--show", "--emulated")["servos"]
        == resumed_result["settings"]["after"]["servos"]
    )
    assert (tfsat_host.folder / resumed_result["file"]).name == "calibration-emulated.toml"


@pytest.mark.usefixtures("short_steps")
def test_it_says_what_will_move_and_demands_the_word(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "zero", "--joint", "3", "--emulated", "--yes"]) == 0
    capsys.readouterr()
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    assert main(["calibrate", "servo", "--joint", "3", "--emulated"]) == 4
    output = capsys.readouterr()
    assert output.out == ""
    for words in (
        "Take the holding attachment off joint 3",
        "Hold bodies 1, 2 and 3 on the bench; body 4 will move.",
        "Keep hands, hair and cables clear of the joint.",
        "bring it to 0 deg by hand first",
        "through 26 stops, 1 s each, at 15 deg/s (50 s in all)",
        "Type JOG to move it: ",
        "Nothing was moved.",
    ):
        assert words in output.err
    monkeypatch.setattr(sys, "stdin", Terminal("JOG\nno\n"))
    assert main(["calibrate", "servo", "--joint", "3", "--emulated"]) == 4
    output = capsys.readouterr()
    assert "Repeatability" in output.out and "joint 3: change / us per deg" in output.out
    on = "To resume from the measurement: tfsat-host calibrate servo --joint 3 --resume --emulated\n"
    assert output.err.endswith(on) and "same command" not in output.err
    assert "stop 26 of 26" in output.err
    monkeypatch.setattr(sys, "stdin", Terminal("y\n"))
    assert main(["calibrate", "servo", "--joint", "3", "--emulated", "--resume"]) == 0
    output = capsys.readouterr()
    assert "Sequencer: settings stored, read back identical" in output.out
    assert "Type JOG" not in output.err
