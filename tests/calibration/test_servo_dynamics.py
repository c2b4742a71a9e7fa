"""`calibrate servo --log`: speed, acceleration and delay of each servo by a recorded run, and what predictions gain."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.cli.process import RunCli
from tests.fixtures.emulated_drop import DESIGNED_TOGETHER, Act, Drop, drop
from tfsat_host.calibration.certificate.file import certificate_values, format_calibration, read_calibration
from tfsat_host.calibration.servos.dynamics_fit import fit_dynamics, with_servos
from tfsat_host.dynamics.simulation import fly
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.imperfections import draw
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import Maneuver, Schedule, Stroke, format_maneuver, schedule_maneuver
from tfsat_host.rehearsal.rehearsed_drop import rehearse
from tfsat_host.rehearsal.series import decode_drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth, truth_as_filed
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.robot.loading import parse_robot
from tfsat_host.run.corrected_robot import corrected_robot
from tfsat_host.run.recorded_strokes import recorded_strokes

BENCH = Maneuver(
    tuple(Stroke(joint, way * 90.0, t_s) for way, t_s in ((1, 0.70), (-1, 1.50)) for joint in (1, 2, 3))
)
"""All joints open and close, with a rest in between."""
BEGAN = datetime(2026, 7, 1, 9, tzinfo=UTC)
RATES, DELAYS_S, CLOSING = (0.95, 1.07, 1.02), (0.004, 0.011, 0.008), (1.03, 0.98, 1.0)
"""Of the robot file's greatest rate; of each servo; of its own rate when it closes."""
PULSE_S = 0.00145
"""From the rise of the stroke line to the mean end of a pulse."""


@cache
def robot(rates: tuple[float, ...] = RATES) -> RobotModel:
    """Return the robot as it is: its servos are faster or slower than its file says."""
    filed = load_robot()
    servos = zip(filed.servos, rates, strict=True)
    return replace(
        filed,
        servos=tuple(replace(servo, max_rate_rad_s=rate * servo.max_rate_rad_s) for servo, rate in servos),
    )


@cache
def flown(maneuver: Maneuver, seed: int, before_drop: Act = lambda _: None) -> Drop:
    late = replace(draw(seed), servo_delay_s=np.array(DELAYS_S), servo_closing_share=np.array(CLOSING))
    schedule: Schedule = schedule_maneuver(maneuver)
    unix_us = round(BEGAN.timestamp() * 1e6)
    return drop(robot(), late, seed=seed, schedule=schedule, unix_us=unix_us, before_drop=before_drop)


@pytest.fixture
def recording(tfsat_host: RunCli) -> Path:
    """Return a recording of the bench run, its maneuver beside it."""
    (tfsat_host.folder / "maneuver.toml").write_text(format_maneuver(BENCH))
    file = tfsat_host.folder / "SD.bin"
    file.write_bytes(flown(BENCH, 3).card)
    return file


def test_each_servo_s_speed_acceleration_and_delay_are_found_within_their_deviations(
    tfsat_host: RunCli, recording: Path
) -> None:
    result = tfsat_host.json("calibrate", "servo", "--log", recording, "--out", "own.toml")
    rows = {(row["joint"], row["direction"]): row for row in result["servos"]}
    assert len(rows) == 6
    for (joint, direction), row in rows.items():
        closing = CLOSING[joint - 1] if direction == "closing" else 1.0
        for key, truth, most in (
            ("speed_deg_s", 200.0 * RATES[joint - 1] * closing, 1.0),
            ("acceleration_deg_s2", 4000.0, 150.0),
            ("delay_ms", 1e3 * (DELAYS_S[joint - 1] + PULSE_S), 1.0),
        ):
            assert row[f"{key}_std"] < most
            assert abs(row[key] - truth) < 4.0 * row[f"{key}_std"], (joint, direction, key)
    # The same recording a second time changes nothing.
    before = (tfsat_host.folder / "own.toml").read_bytes()
    again = tfsat_host("calibrate", "servo", "--log", recording, "--out", "own.toml")
    assert "already contains this recording" in again.stderr
    assert (tfsat_host.folder / "own.toml").read_bytes() == before
    shown = tfsat_host("calibrate", "show", "--emulated", "--out", "own.toml", "--full").stdout
    assert "Servo speeds: measured of joint 1, 2, 3" in shown and "closing" in shown


def test_a_drop_with_joints_that_move_together_is_predicted_with_measured_servos(
    tfsat_host: RunCli, recording: Path
) -> None:
    tfsat_host("calibrate", "servo", "--log", recording, "--out", "own.toml")
    (tfsat_host.folder / "together.toml").write_text(format_maneuver(DESIGNED_TOGETHER))
    measured = ("--file", "together.toml", "--calibration", "own.toml")
    predicted = tfsat_host.json("simulate", *measured)
    assert predicted["calibration"] == "own.toml"
    by_file = tfsat_host.json("simulate", "--file", "together.toml")
    true_deg = math.degrees(flown(DESIGNED_TOGETHER, 4).true_turn(3, 0.0, 2.5).magnitude())
    assert abs(by_file["reorientation_deg"] - true_deg) > 0.5, "the file's servos do not predict it"
    assert abs(predicted["reorientation_deg"] - true_deg) < 0.1
    # What the servos' ± cost: everything else is exact.
    stated = load_robot().uncertainty
    assert stated is not None
    exact = [f"{key}=0" for key in stated.figures()]
    sigmas = [word for key in exact for word in ("--sigma", key)]
    study = tfsat_host.json("sensitivity", *measured, *sigmas, "--samples", "2000", "--workers", "1")
    assert study["reorientation_deg"] == pytest.approx(predicted["reorientation_deg"], abs=1e-3)
    std_deg = study["monte_carlo"]["outputs"]["reorientation_deg"]["std"]["value"]
    assert 0.005 < std_deg < 0.1
    no_maps = "no servo map of joint 1, joint 2, joint 3: strokes are taken to end where commanded"
    assert no_maps in tfsat_host("simulate", *measured).stderr
    assert abs(predicted["reorientation_deg"] - true_deg) < 4.0 * std_deg
    assert {source["kind"] for source in study["sources"] if source["linear_deg"] > 1e-4} == {
        "servo_speed",
        "servo_acceleration",
        "servo_delay",
    }


def test_what_tells_no_speed_is_refused_and_nothing_is_written(tfsat_host: RunCli, recording: Path) -> None:
    (tfsat_host.folder / "maneuver.toml").unlink()
    log = ("calibrate", "servo", "--log", recording, "--out", "own.toml")
    error = tfsat_host.json(*log, expect=1)["error"]
    assert "unknown: no maneuver.toml" in error["what"] and "--maneuver" in error["next_step"]
    # Strokes at other times than the stroke line's.
    other = Maneuver((Stroke(1, 60.0, 0.93), Stroke(1, -60.0, 1.31)))
    (tfsat_host.folder / "other.toml").write_text(format_maneuver(other))
    error = tfsat_host.json(*log, "--maneuver", "other.toml", expect=1)["error"]
    assert "no stroke line that fits the maneuver" in error["what"]
    assert not (tfsat_host.folder / "own.toml").exists()


def test_a_joint_that_did_not_move_is_named_and_the_others_are_kept(
    tfsat_host: RunCli, recording: Path
) -> None:
    def kill(robot: EmulatedRobot) -> None:
        robot.faults.servo(2, "dead")

    recording.write_bytes(flown(BENCH, 3, kill).card)
    process = tfsat_host("calibrate", "servo", "--log", recording, "--out", "own.toml")
    assert "Joint 2 went 0.0 deg instead of +90 deg." in process.stderr
    assert [row.split()[:2] for row in process.stdout.splitlines() if " ± " in row] == [
        [joint, way] for joint in "13" for way in ("opening", "closing")
    ]


def test_strokes_too_short_to_tell_a_speed_are_refused(tfsat_host: RunCli, recording: Path) -> None:
    short = Maneuver((Stroke(1, 10.0, 0.70), Stroke(1, -10.0, 1.20)))
    (tfsat_host.folder / "maneuver.toml").write_text(format_maneuver(short))
    recording.write_bytes(flown(short, 3).card)
    error = tfsat_host.json("calibrate", "servo", "--log", recording, "--out", "own.toml", expect=1)["error"]
    assert "Joint 1 was not at its servo's greatest rate for 30 ms" in error["what"]
    assert "60 deg or more" in error["next_step"]
    assert not (tfsat_host.folder / "own.toml").exists()


def test_a_certificate_without_servo_speeds_or_of_another_robot_predicts_nothing(
    tfsat_host: RunCli, recording: Path
) -> None:
    tfsat_host("calibrate", "bias", "--log", recording, "--out", "own.toml", expect=1)
    tfsat_host("calibrate", "servo", "--log", recording, "--out", "own.toml")
    error = tfsat_host.json(
        "simulate", "90", "90", "--robot", "cubesat_3u", "--calibration", "own.toml", expect=1
    )["error"]
    assert "not of" in error["what"] and "robot file" in error["next_step"]


class Predicted(NamedTuple):
    """A second drop: predicted less true reorientation, and angle between predicted and true attitude, deg."""

    reorientation_deg: float
    attitude_deg: float


def predict(flies: Truth, before: RobotModel, filed: RobotModel, flight: Schedule) -> Predicted:
    """Compare a drop with the prediction by the robot `before` it, turning as the drop itself measured."""
    certificate = careful_certificate(filed, flies.imperfections, flies.seed, BEGAN)
    day = rehearse(flight, filed, flies)
    rate = evaluate(decode_drop(day), before, certificate, flight).initial_rates[filed.base].rate_rad_s
    times_s, base = day.truth[:, 0] - (day.released_s or 0.0), 4 + 4 * filed.base
    begin, end = np.searchsorted(times_s, [0.0, day.fall_s - 0.05])
    attitudes = Rotation.from_quat(day.truth[[begin, end], base : base + 4])
    true = attitudes[0].inv() * attitudes[1]
    flown = fly(before, flight, until_s=float(times_s[end]), initial_rate_rad_s=rate)
    predicted = Rotation.from_quat(flown.quaternion_xyzw)
    apart = [predicted.magnitude() - true.magnitude(), (true.inv() * predicted).magnitude()]
    return Predicted(*np.rad2deg(apart).tolist())


def calibrated(flies: Truth, filed: RobotModel) -> RobotModel:
    """Return the robot with servos as its own bench run and its servo maps have them."""
    certificate = careful_certificate(filed, flies.imperfections, flies.seed, BEGAN)
    bench = schedule_maneuver(BENCH)
    log = decode_drop(rehearse(bench, filed, flies))
    steps = recorded_strokes(log, bench, Path("SD.bin"))
    fits = [fit for step in steps for fit in fit_dynamics(step, certificate.joints, filed)]
    return with_servos(filed, fits, certificate.servo_maps)


def test_play_is_counted_in_a_prediction() -> None:
    filed = load_robot()
    exact = truth_as_filed(filed, 3)
    play = replace(exact.imperfections, servo_backlash_rad=np.deg2rad([0.9, 0.7, 0.8]))
    flies = replace(exact, imperfections=play)
    measured, together = calibrated(flies, filed), schedule_maneuver(DESIGNED_TOGETHER)
    assert abs(predict(flies, measured, filed, together).reorientation_deg) < 0.1
    servos = tuple(replace(servo, play_rad=0.0) for servo in measured.servos)
    without = replace(measured, servos=servos)
    assert predict(flies, without, filed, together).reorientation_deg > 0.3


def test_what_a_servo_map_says_of_strokes_takes_the_place_of_the_robot_file(tfsat_host: RunCli) -> None:
    built_robot = drawn_truth(load_robot(), 3)
    certificate = careful_certificate(load_robot(), built_robot.imperfections, 3, BEGAN)
    (tfsat_host.folder / "own.toml").write_text(format_calibration(certificate))
    study = tfsat_host.json("sensitivity", "59", "70", "--calibration", "own.toml", "--samples", "500")
    stops = {source["source"]: source["std"] for source in study["sources"] if source["kind"] == "stroke"}
    by_map = [f"{math.degrees(servo_map.stop_std_rad):.4g} deg" for servo_map in certificate.servo_maps]
    assert stops["stroke 1 end (joint 1)"] == by_map[0] and stops["stroke 4 end (joint 2)"] == by_map[1]
    kinds = {source["kind"] for source in study["sources"]}
    assert "start" in kinds and "servo_scale" not in kinds
    ends = {row["parameter"]: row["value"] for row in study["parameters"]}
    play_deg = math.degrees(certificate.servo_maps[0].backlash_rad)
    assert ends["stroke 1 end (joint 1)"] == pytest.approx(59.0 - 0.5 * play_deg)
    assert ends["stroke 3 end (joint 1)"] == pytest.approx(0.5 * play_deg)


def test_a_rehearsal_s_certificate_keeps_what_no_recording_tells(tfsat_host: RunCli, recording: Path) -> None:
    own = tfsat_host.folder / "own.toml"
    own.write_text(format_calibration(careful_certificate(load_robot(), draw(3), 3, BEGAN)))
    certificate = read_calibration(own)
    tfsat_host("calibrate", "servo", "--log", recording, "--out", own)
    learnt = read_calibration(own)
    assert len(learnt.servo_dynamics) == 6 and learnt.simulated_quantities == certificate.simulated_quantities
    before, after = map(certificate_values, (certificate, learnt))
    assert {key for key in before if before[key] != after[key]} <= {
        "servo_dynamics", "recordings", "written", "logger_image", "tool_version", "protocol_hash"
    }  # fmt: skip


def built(seed: int, filed: RobotModel) -> Truth:
    """Draw a robot as a rehearsal does, with servos of speeds and delays of their own."""
    random = np.random.default_rng([seed, 99])
    rates = np.clip(1.0 + 0.05 * random.standard_normal(3), 0.87, 1.15)
    truth = drawn_truth(filed, seed)
    late = replace(
        truth.imperfections,
        servo_delay_s=random.uniform(0.002, 0.015, 3),
        servo_closing_share=random.uniform(0.95, 1.05, 3),
    )
    return replace(truth, model=replace(truth.model, servos=robot(tuple(rates)).servos), imperfections=late)


@pytest.mark.prove
@pytest.mark.timeout(600)
def test_the_second_drop_of_eight_rehearsed_robots_is_predicted_to_half_a_degree() -> None:
    filed, together = load_robot(), schedule_maneuver(DESIGNED_TOGETHER)
    as_filed, as_calibrated = [], []
    for seed in range(1, 9):
        flies = built(seed, filed)
        certificate = careful_certificate(filed, flies.imperfections, seed, BEGAN)
        # The bench tells the servos, a first drop the centers of mass; the second drop is predicted.
        first = rehearse(together, filed, replace(flies, rate_rad_s=np.zeros(3)))
        evaluation = evaluate(decode_drop(first), filed, certificate, together)
        corrected = parse_robot(corrected_robot(evaluation), Path("corrected.toml"))
        servos = calibrated(flies, filed).servos
        as_calibrated.append(predict(flies, replace(corrected, servos=servos), filed, together))
        as_filed.append(predict(flies, filed, filed, together))
    rms = [np.sqrt(np.mean(np.square(errors), axis=0)) for errors in (as_filed, as_calibrated)]
    assert (rms[1] < 0.5).all() and (rms[0] > 1.0).all(), rms
