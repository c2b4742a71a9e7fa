"""What is wrong lies around the robot: facility, files, cables, images, a card that goes in the middle."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.preflight.ready_robot import CERTIFICATE, MANEUVER, ReadyRobot, check, found_wrong, not_made
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.cli.main import main
from tfsat_host.devices.client import Client
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.maneuver import format_maneuver
from tfsat_host.plan.facility import default_facility_path
from tfsat_host.protocol.enums import Board


@pytest.mark.parametrize(
    ("entry", "value", "red"),
    [
        # Each limit is made stricter than the maneuver bears.
        ("clearance_mm = 21.0", "clearance_mm = 24.0", "pause"),
        ("margin_s = 1.0", "margin_s = 1.2", "duration"),
        ("envelope_radius_mm = 165.0", "envelope_radius_mm = 120.0", "envelope"),
        ("usable_vertical_travel_mm = 250.0", "usable_vertical_travel_mm = 100.0", "envelope"),
    ],
)
def test_a_maneuver_beyond_the_facility(ready: ReadyRobot, entry: str, value: str, red: str) -> None:
    text = default_facility_path().read_text(encoding="utf-8")
    # Else nothing would be replaced and the facility be the default one.
    assert f"\n{entry}" in text
    facility = ready.folder / "tower.toml"
    facility.write_text(text.replace(f"\n{entry}", f"\n{value}"), encoding="utf-8")
    result = ready.preflight("--facility", str(facility), expect=4)
    assert (found_wrong(result), not_made(result)) == ({red}, set())


def test_a_card_that_is_pulled_during_the_trial(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    wait_for_card = LoggerClient.wait_for_card

    def pull_card(self: LoggerClient) -> Any:
        status = wait_for_card(self)
        # The trial recording has begun, its blocks are not read back yet.
        ready.robot.card_slot.remove()
        return status

    monkeypatch.setattr(LoggerClient, "wait_for_card", pull_card)
    result = ready.preflight(expect=4)
    assert found_wrong(result) == {"card", "card-writing"}


def test_samples_that_come_unevenly(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    from_live = Counts.from_live

    def uneven(*args: Any) -> Counts:
        counts = from_live(*args)
        # 0.3 ms of scatter: the rate stays the same, the intervals do not.
        noise = np.random.default_rng(1).normal(0.0, 300.0, len(counts.t_us)).astype(np.int64)
        return replace(counts, t_us=counts.t_us + noise)

    monkeypatch.setattr(Counts, "from_live", uneven)
    result = ready.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == ({"sampling"}, set())


def test_a_host_of_another_release(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    ready.set_clock = None
    # A hash of the same length as the protocol's.
    monkeypatch.setattr("tfsat_host.devices.board_identity.PROTOCOL_HASH", b"another!")
    result = ready.preflight(expect=4)
    assert found_wrong(result) == {"protocol"}
    assert {"maneuver", "switches", "card", "sampling"} <= not_made(result)


@pytest.fixture
def flashed_robot(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> ReadyRobot:
    """Make the boards report image CRCs, as real ones do, with a certificate of a real robot."""
    identify = Client.identify
    images = {Board.SEQUENCER: "5e0e0ce2", Board.LOGGER: "10660001"}

    def as_flashed(self: Client, expected: Board | None = None) -> Any:
        identity = identify(self, expected)
        return replace(identity, image_crc=images[identity.board])

    monkeypatch.setattr(Client, "identify", as_flashed)
    ready.accept(file="acceptance.json")
    subject = replace(ready.calibration.subject, emulated=False)
    ready.certify(replace(ready.calibration, subject=subject))
    return ready


@pytest.mark.parametrize(
    ("sequencer", "logger", "red", "in_the_dark"),
    [
        ("5e0e0ce2", "10660001", set(), set()),
        ("5e0e0ce3", "10660001", {"sequencer-image"}, set()),
        ("5E0E0CE2", "10660002", {"logger-image"}, set()),
        # No image named, and the certificate names none either.
        ("5e0e0ce2", None, set(), {"logger-image"}),
    ],
)
def test_images(
    flashed_robot: ReadyRobot, sequencer: str, logger: str | None, red: set[str], in_the_dark: set[str]
) -> None:
    certificate = ("--calibration", str(flashed_robot.folder / "calibration-emulated.toml"))
    images = ["--sequencer-image", sequencer, *(["--logger-image", logger] if logger else [])]
    result = flashed_robot.preflight(*certificate, *images, expect=4 if red or in_the_dark else 0)
    assert (found_wrong(result), not_made(result)) == (red, in_the_dark)


def test_an_image_of_the_arduino_ide_can_be_named(flashed_robot: ReadyRobot) -> None:
    certificate = ("--calibration", str(flashed_robot.folder / CERTIFICATE))
    result = flashed_robot.preflight(*certificate, "--sequencer-image", "5e0e0ce3", expect=4)
    assert "--sequencer-image 5e0e0ce2" in check(result, "sequencer-image")["next_step"]


def calibrated_with(flashed: ReadyRobot, image: str) -> tuple[str, ...]:
    """Options of a preflight with a certificate that was taken while the logger ran that image."""
    flashed.certify(replace(flashed.calibration, logger_image=image))
    return ("--calibration", str(flashed.folder / CERTIFICATE), "--sequencer-image", "5e0e0ce2")


def test_a_logger_that_runs_what_it_ran_when_it_was_calibrated(flashed_robot: ReadyRobot) -> None:
    result = flashed_robot.preflight(*calibrated_with(flashed_robot, "10660001"), expect=0)
    assert "as when it was calibrated" in check(result, "logger-image")["sentence"]


def test_a_logger_that_was_flashed_since_it_was_calibrated(flashed_robot: ReadyRobot) -> None:
    options = calibrated_with(flashed_robot, "0ddba110")
    result = flashed_robot.preflight(*options, expect=4)
    image = check(result, "logger-image")
    assert (found_wrong(result), not_made(result)) == ({"logger-image"}, set())
    assert "0ddba110" in image["sentence"] and "--logger-image 10660001" in image["next_step"]
    flashed_robot.preflight(*options, "--logger-image", "10660001", expect=0)


def test_the_image_of_another_logger_says_nothing(flashed_robot: ReadyRobot) -> None:
    subject = replace(flashed_robot.calibration.subject, logger_serial="0123456789abcdef")
    flashed_robot.certify(replace(flashed_robot.calibration, subject=subject))
    result = flashed_robot.preflight(*calibrated_with(flashed_robot, "0ddba110"), expect=4)
    assert found_wrong(result) == {"calibration"} and "logger-image" in not_made(result)


def test_a_logger_that_is_not_there(ready: ReadyRobot) -> None:
    ready.robot.set_cable(BoardIndex.LOGGER, False)
    ready.set_clock = None
    result = ready.preflight(expect=4)
    assert found_wrong(result) == set()
    assert {"gyros-present", "card", "clock", "switches", "calibration", "protocol"} <= not_made(result)
    assert check(result, "maneuver")["verdict"] == "go"


def test_boards_that_are_not_there_are_said_once_each(ready: ReadyRobot) -> None:
    """And what was found wrong is not lost among what could not be looked at."""
    text = (ready.folder / "maneuver.toml").read_text(encoding="utf-8")
    (ready.folder / "maneuver.toml").write_text(text.replace("170", "17000"), encoding="utf-8")
    ready.links = {
        board: PortError(PortProblem.NONE_FOUND, what=f"No {board} found.", next_step=f"Plug the {board} in.")
        for board in ("sequencer", "logger")
    }
    assert main(["preflight", str(ready.folder)]) == 4
    output = ready.capture.readouterr().out
    text = " ".join(word for word in output.split() if word != "MADE")  # of the column next to it
    for board in ("sequencer", "logger"):
        assert text.count(f"No {board} found.") == text.count(f"Plug the {board} in.") == 1, output
        assert f"The {board} was not reached." not in text, output
    assert f"{CERTIFICATE} is that of an emulated robot." in text
    verdict, last = (line for line in output.splitlines() if line.startswith("NO-GO:"))
    assert (
        verdict == last == "NO-GO: calibration, protocol, pause, duration, envelope (0 of 28 checks passed)"
    )
    assert output.count("The joint speed is") == 1 and len(output.splitlines()) <= 40
    assert main(["preflight", str(ready.folder), "--full"]) == 4
    output = ready.capture.readouterr().out
    text = " ".join(word for word in output.split() if word != "MADE")  # of the column next to it
    for board in ("sequencer", "logger"):
        assert text.count(f"The {board} was not reached. See protocol.") == 1, output
        assert text.count(f"The {board} was not reached.") == 1, output
    result = ready.preflight(expect=4)
    assert len(result["reasons"]) > 20, "all of them, for programs"


def test_a_sequencer_that_is_not_there(ready: ReadyRobot) -> None:
    ready.robot.set_power(BoardIndex.SEQUENCER, False)
    result = ready.preflight(expect=4)
    assert found_wrong(result) == set()
    assert {"maneuver", "sequencer-state", "restarts", "switches", "protocol"} <= not_made(result)
    assert check(result, "card-writing")["verdict"] == "go"


def test_a_logger_whose_cable_is_pulled_in_the_middle_is_said_to_keep_a_recording(
    ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_for_card = LoggerClient.wait_for_card

    def pull_cable(self: LoggerClient) -> Any:
        status = wait_for_card(self)
        ready.robot.set_cable(BoardIndex.LOGGER, False)
        return status

    monkeypatch.setattr(LoggerClient, "wait_for_card", pull_cable)
    result = ready.preflight(expect=4)
    assert "card-writing" in not_made(result)
    assert "still on the" in result["left_on_the_boards"]


def test_no_maneuver_in_the_run(ready: ReadyRobot) -> None:
    (ready.folder / "maneuver.toml").unlink()
    result = ready.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == (set(), {"maneuver", "pause", "duration", "envelope"})


def test_a_maneuver_of_another_speed_is_another_maneuver(ready: ReadyRobot) -> None:
    other = replace(MANEUVER, speed_deg_s=171.0)
    (ready.folder / "maneuver.toml").write_text(format_maneuver(other), encoding="utf-8")
    assert "maneuver" in found_wrong(ready.preflight(expect=4))
