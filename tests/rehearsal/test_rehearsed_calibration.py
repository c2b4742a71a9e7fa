"""The biases of a rehearsed day are measured on the bench, kept raw, and recomputed from the bundle."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.run.bundle.commands import command, result
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import from_bytes
from tfsat_host.calibration.steps.step import rest
from tfsat_host.file_hash import sha256_of
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot

MODEL = load_robot()
CERTIFICATE = "calibration-emulated.toml"
RECORDINGS = "calibration-emulated-recordings"


def read_first_certificate(run: Path) -> Calibration:
    """Read the certificate that the preflight checked: the first one archived."""
    return read_calibration(min((run / RECORDINGS).glob("certificate-*.toml")))


def test_the_certificate_holds_what_calibrate_makes_of_the_raw_samples(run: Path) -> None:
    calibration = read_first_certificate(run)
    (recording,) = calibration.recordings
    file = run / RECORDINGS / recording.file
    assert sha256_of(file) == recording.sha256
    evidence = from_bytes(file.read_bytes(), source=recording.file)
    assert evidence.step == rest()
    assert np.ptp(evidence.counts.t_us) * 1e-6 >= 20.0, "as long as calibrate bias reads"
    assert evidence.counts.samples_lost == 0
    assert evidence.origin.logger_serial == calibration.subject.logger_serial
    for certified, solved in zip(calibration.gyros, solve([evidence], MODEL).gyros, strict=True):
        assert np.allclose(certified.bias_rad_s, solved.bias_rad_s, rtol=1e-10)
        assert np.allclose(certified.covariance[:3, :3], solved.covariance[:3, :3], rtol=1e-10)
        assert np.allclose(certified.noise_rad_s, solved.noise_rad_s, rtol=1e-10)
        assert np.isclose(certified.temperature_c, solved.temperature_c)
        assert certified.bias_recorded_at == recording.recorded_at


def test_a_cold_gyro_on_the_bench_feels_its_weight(run: Path) -> None:
    truth = drawn_truth(MODEL, 1).imperfections
    for body, gyro in enumerate(read_first_certificate(run).gyros):
        # Up, in the gyro's own axes: its case, its mounting and the bench's vertical.
        up = (truth.mounting[body] @ MODEL.imus[body].sensor_to_body).T @ [0.0, 0.0, 1.0]
        felt = truth.gyro_g_sensitivity_rad_s_g[body] @ up
        off = gyro.bias_rad_s - truth.gyro_bias_rad_s[body] - felt
        assert np.rad2deg(np.abs(off)).max() < 0.02
        # Large enough to be seen: else the line before would hold without gravity, too.
        assert np.rad2deg(np.linalg.norm(felt)) > 0.02
        assert gyro.temperature_c < 25.5, "the minutes that warm it come later"


def test_what_was_not_measured_is_said(run: Path) -> None:
    assert read_first_certificate(run).simulated_quantities == ("zero", "misalignment", "scale", "servo")
    certificate = json.loads(
        command("calibrate", "show", "--emulated", "--out", run / CERTIFICATE, "--json").out
    )
    assert certificate["drawn"] == ["zero", "misalignment", "scale", "servo"]
    words = command("calibrate", "show", "--emulated", "--out", run / CERTIFICATE).words
    assert "Simulated: zero points, misalignments of the gyros" in words


def test_the_bundle_is_computed_anew_from_the_raw_samples(run: Path) -> None:
    (missing,) = result("bundle", "run")["missing"]
    assert (
        missing["lost"] is False and "Simulated by a rehearsal, not measured: zero points" in missing["why"]
    )
    reproduction = result("reproduce", "run.tfsat.zip")
    assert reproduction["same"] is True and reproduction["complete"] is True
    again = next(comparison for comparison in reproduction["compared"] if comparison["what"] == "calibration")
    assert again["differences"] == [] and again["lacking"] is False
    assert "from 1 recording: biases of the gyros. Simulated: zero" in again["sentence"]


def test_a_bias_that_the_raw_samples_do_not_give_differs(run: Path) -> None:
    present = read_calibration(run / CERTIFICATE)
    # 0.001 deg/s: no eye would see it in the file.
    wrong = replace(present.gyros[2], bias_rad_s=present.gyros[2].bias_rad_s + np.deg2rad([0.0, 0.001, 0.0]))
    gyros = (*present.gyros[:2], wrong, present.gyros[3])
    (run / CERTIFICATE).write_text(format_calibration(replace(present, gyros=gyros)))
    command("bundle", "run", expect=3)  # the file is not as the rehearsal left it
    again = next(
        comparison
        for comparison in result("reproduce", "run.tfsat.zip", expect=3)["compared"]
        if comparison["what"] == "calibration"
    )
    assert [difference["key"] for difference in again["differences"]] == ["gyro[2].bias.value[1]"]


def test_without_its_raw_samples_it_is_not_the_same(run: Path) -> None:
    (recording,) = (run / RECORDINGS).glob("rest-*.npz")
    recording.unlink()
    command("bundle", "run", expect=3)
    reproduction = result("reproduce", "run.tfsat.zip", expect=3)
    assert reproduction["complete"] is False
    assert recording.name in " ".join(reproduction["incomplete"])


def test_the_certificate_that_the_preflight_checked_stays(run: Path) -> None:
    """Keep the certificate that the preflight checked.

    The landing was noted in the certificate since; both are valid, and both are in the bundle.
    """
    checked = json.loads((run / "preflight.json").read_text())["files"]["calibration"]["sha256"]
    name_by_sha256 = {sha256_of(path): path.name for path in (run / RECORDINGS).glob("certificate-*.toml")}
    assert checked in name_by_sha256 and checked != sha256_of(run / CERTIFICATE)
    assert len(name_by_sha256) == 2 and read_calibration(run / CERTIFICATE).last_landing is not None
    assert result("bundle", "run")["record"] == []
    # Gone, nothing proves any more what the preflight saw.
    (run / RECORDINGS / name_by_sha256[checked]).unlink()
    (sentence,) = result("bundle", "run", expect=3)["record"]
    assert f"run/{CERTIFICATE} is not the calibration that the preflight checked" in sentence
    assert "none of the certificates that were kept is" in sentence
    assert sentence in result("reproduce", "run.tfsat.zip", expect=3)["record"]


def test_another_maneuver_than_the_preflight_checked_is_named(run: Path) -> None:
    maneuver = run / "maneuver.toml"
    # A comment: no stroke differs, but it is not the file that was checked.
    maneuver.write_text(maneuver.read_text() + "\n# touched\n")
    output = command("bundle", "run", expect=3)
    assert (
        "Changed: run/maneuver.toml is not the maneuver that the preflight checked (run/maneuver.toml"
        in output.words
    )
    assert "Changed: run/maneuver.toml is not" in command("reproduce", "run.tfsat.zip", expect=3).words
