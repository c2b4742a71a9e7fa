"""`calibrate bias --log` into a certificate that has a bias already: the newest counts, whatever came in last."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.quiet_drop import quiet_drop
from tests.cli.process import RunCli

FILE = "calibration-emulated.toml"
BEGAN = datetime(2024, 5, 4, 10, tzinfo=UTC)


def log(
    folder: Path, began: datetime, seed: int, name: str = "DROP 1.BIN", *, as_built: bool = False
) -> tuple[Path, list[list[float]]]:
    """Write a recording of that time; return its file and its gyros' true biases in deg/s."""
    data, bias_rad_s = quiet_drop(seed, unix_us=round(began.timestamp() * 1e6), as_built=as_built)
    file = folder / name
    file.write_bytes(data)
    return file, np.degrees(bias_rad_s).tolist()


def biases(result: dict[str, list[dict[str, list[float]]]]) -> list[list[float]]:
    return [body["bias_deg_s"] for body in result["bodies"]]


@pytest.mark.usefixtures("short_steps")
def test_a_log_older_than_the_bench_changes_nothing(tfsat_host: RunCli) -> None:
    tfsat_host("calibrate", "bias", "--emulated")
    certificate = tfsat_host.folder / FILE
    before = certificate.read_bytes()
    old, truth = log(tfsat_host.folder, BEGAN, seed=5, as_built=True)
    error = tfsat_host.json("calibrate", "bias", "--log", old, expect=1)["error"]
    assert "is of 2024-05-04 10:00 UTC, older than the biases in calibration-emulated.toml" in error["what"]
    assert "the certificate is unchanged" in error["meaning"]
    # A certificate of its own for the older recording.
    command = f"tfsat-host calibrate bias --log '{old}' --out 'calibration-emulated-DROP 1.toml'"
    assert error["next_step"].endswith(command)
    assert certificate.read_bytes() == before
    apart = tfsat_host.json("calibrate", "bias", "--log", old, "--out", "calibration-emulated-DROP 1.toml")
    assert np.array(biases(apart)) == pytest.approx(np.array(truth), abs=0.03)


def test_a_newer_log_replaces_it_and_is_what_the_table_shows(tfsat_host: RunCli) -> None:
    first, _ = log(tfsat_host.folder, BEGAN, seed=5)
    second, truth = log(tfsat_host.folder, BEGAN + timedelta(hours=3), seed=4, name="DROP2.BIN")
    tfsat_host("calibrate", "bias", "--log", first)
    result = tfsat_host.json("calibrate", "bias", "--log", second)
    assert np.array(biases(result)) == pytest.approx(np.array(truth), abs=0.03)
    (step,) = result["steps"]
    assert step["taken"].startswith("2024-05-04T13:00:")
    bias = tfsat_host.json("calibrate", "show", "--emulated")["quantities"][0]
    assert bias["value"] == pytest.approx(biases(result)[0])
    before = (tfsat_host.folder / FILE).read_bytes()
    # A second time: nothing changes.
    again = tfsat_host("calibrate", "bias", "--log", second)
    assert f"{FILE} already contains this recording: unchanged." in again.stderr
    assert f"{truth[0][0]:+.1f}" in again.stdout
    assert (tfsat_host.folder / FILE).read_bytes() == before


def test_what_to_type_next_is_for_the_robot_of_the_recording(tfsat_host: RunCli) -> None:
    file, _ = log(tfsat_host.folder, BEGAN, seed=4)
    output = tfsat_host("calibrate", "bias", "--log", file, "--out", "mine.toml").stdout
    assert output.endswith("Next:        tfsat-host calibrate zero --all --out mine.toml --emulated\n")
    file.write_bytes(quiet_drop(4)[0])
    refused = tfsat_host("calibrate", "bias", "--log", file, expect=1)
    assert "tfsat-host calibrate bias --emulated" in refused.stderr
