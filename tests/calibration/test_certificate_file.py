"""calibration.toml: nothing is lost on the way, and what is not ours is refused by name."""

from __future__ import annotations

import re
import tomllib
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.calibration.some_calibration import MEASURED, drawn_calibration, whole_calibration
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.file import (
    format_calibration,
    parse_calibration,
    read_calibration,
)

WHOLE = format_calibration(whole_calibration())


def assert_same(actual: Any, reference: Any, where: str = "calibration") -> None:
    """Field by field; numbers to 1e-9 of the largest next to them, NaN as NaN."""
    if is_dataclass(reference):
        for field in fields(reference):
            assert_same(getattr(actual, field.name), getattr(reference, field.name), f"{where}.{field.name}")
    elif isinstance(reference, tuple):
        assert len(actual) == len(reference), where
        for number, (element, other) in enumerate(zip(actual, reference, strict=True)):
            assert_same(element, other, f"{where}[{number}]")
    elif isinstance(reference, float | np.ndarray):
        assert np.shape(actual) == np.shape(reference), where
        np.testing.assert_allclose(actual, reference, rtol=1e-9, atol=0.0, equal_nan=True, err_msg=where)
    else:
        assert actual == reference, where


@settings(max_examples=15)
@given(st.integers(0, 2**32))
def test_what_is_read_is_what_was_written_also_a_second_time(seed: int) -> None:
    calibration = drawn_calibration(seed)
    once = parse_calibration(format_calibration(calibration))
    assert_same(once, calibration)
    # Written again: rounding of the text must not accumulate.
    assert_same(parse_calibration(format_calibration(once)), once)


def test_people_can_read_it() -> None:
    assert WHOLE.startswith("# tfsat calibration: ")
    table = tomllib.loads(WHOLE)
    bias = table["gyro"][1]["bias"]
    gyro = whole_calibration().gyros[1]
    assert bias["value"] == pytest.approx(np.degrees(gyro.bias_rad_s))
    assert bias["std"] == pytest.approx([0.005] * 3)
    assert (bias["unit"], bias["frame"]) == ("deg/s", "sensor")
    assert table["gyro"][1]["mounting"]["std"] == pytest.approx([0.02] * 3)
    assert table["gyro"][1]["mounting"]["measured"] == dict.fromkeys("xy", MEASURED)
    assert table["gyro"][1]["scale"]["measured"] == dict.fromkeys("xyz", MEASURED)
    assert table["gyro"][1]["scale"]["measured_frame"] == "body"
    assert table["servo"][0]["slope"]["unit"] == "deg/us"
    for kind in ("gyro", "joint", "servo"):
        for entry in table[kind]:
            for name, part in entry.items():
                if isinstance(part, dict) and name != "setting":
                    # Every number that a person may copy has its unit and its frame.
                    assert {"unit", "frame"} <= part.keys(), (kind, name)


def test_what_was_never_measured_has_no_key() -> None:
    for seed in range(20):
        calibration = drawn_calibration(seed)
        for gyro, entry in zip(
            calibration.gyros, tomllib.loads(format_calibration(calibration))["gyro"], strict=True
        ):
            assert ("taken" in entry["bias"]) == (gyro.bias_recorded_at is not None)
            for part, measured in ((entry["mounting"], gyro.axes), (entry["scale"], gyro.scaled)):
                assert ("measured" in part) == bool(measured)
            assert ("noise" in entry) == (not np.isnan(gyro.noise_rad_s).any())
            # NaN is unequal to itself: never measured.
            assert ("temperature_c" in entry["bias"]) == (gyro.temperature_c == gyro.temperature_c)
        assert "nan" not in format_calibration(calibration)


def in_table(header: str, number: int, old: str, new: str) -> str:
    """Return the whole certificate with one text changed in the `number`-th (from 1) table of that name."""
    starts = [match.end() for match in re.finditer(re.escape(f"\n{header}\n"), WHOLE)]
    start = starts[number - 1]
    assert re.search(old, WHOLE[start:])
    return WHOLE[:start] + re.sub(old, new, WHOLE[start:], count=1)


def line_number(text: str, header: str, number: int, key: str) -> int:
    """Return the line number, from 1, of the key in that table."""
    header_count = 0
    for line, content in enumerate(text.splitlines(), 1):
        header_count += content == header
        if header_count == number and content.startswith(f"{key} = "):
            return line
    raise AssertionError(f"no {key} in {header} {number}")


@pytest.mark.parametrize(
    ("header", "number", "key", "theirs", "ours"),
    [
        ("[gyro.bias]", 2, "unit", "rad/s", "deg/s"),
        ("[gyro.bias]", 3, "frame", "body", "sensor"),
        ("[gyro.noise]", 1, "unit", "counts", "deg/s"),
        ("[gyro.mounting]", 4, "frame", "body to sensor", "sensor to body"),
        ("[gyro.mounting]", 1, "std_unit", "rad", "deg"),
        ("[gyro.scale]", 2, "unit", "%", "1"),
        ("[gyro.scale]", 3, "measured_frame", "sensor", "body"),
        ("[joint.zero]", 3, "unit", "rad", "deg"),
        ("[joint.bend]", 1, "unit", "mrad", "deg"),
        ("[servo.slope]", 2, "unit", "us/deg", "deg/us"),
        ("[servo.backlash]", 1, "frame", "pulse", "joint"),
    ],
)
def test_other_units_and_frames_are_refused_by_name(
    header: str, number: int, key: str, theirs: str, ours: str
) -> None:
    # Only the one key of that table is changed.
    text = in_table(header, number, rf'(?m)^{key} = "[^"]*"', f'{key} = "{theirs}"')
    with pytest.raises(CalibrationError) as raised:
        parse_calibration(text, source="calibration.toml")
    line = line_number(text, header, number, key)
    table, _, inside = header.strip("[]").partition(".")
    of = {"gyro": "gyro of body", "joint": "joint", "servo": "servo of joint"}[table]
    place = f"calibration.toml:{line}: {of} {number}, {inside}.{key}"
    # File, line and key stand at the head of the error: an editor jumps there.
    assert raised.value.what.startswith(
        f"{place}: {theirs!r} is not {ours!r}, which this program writes and reads"
    )
    assert f"Convert the values to {ours!r}" in raised.value.next_step
    assert "tfsat-host calibrate" in raised.value.next_step


def test_units_of_a_covariance_are_refused_by_name() -> None:
    text = in_table("[gyro.covariance]", 2, r'unit = \["deg/s"', 'unit = ["rad/s"')
    with pytest.raises(
        CalibrationError, match=r"gyro of body 2, covariance.unit: \['rad/s', .* is not \['deg/s', "
    ):
        parse_calibration(text)
    text = in_table("[joint.bend]", 2, r'order = \["sin", "cos"', 'order = ["cos", "sin"')
    with pytest.raises(CalibrationError, match=r"joint 2, bend.order: \['cos', 'sin'"):
        parse_calibration(text)


MIRROR = "rotation = [\n    [1.0, 0.0, 0.0],\n    [0.0, 1.0, 0.0],\n    [0.0, 0.0, -1.0],\n]"
ROTATION = r"rotation = \[\n(    .*\n){3}\]"
FIRST_OF_COVARIANCE = r"value = \[\n    \[([^,]*), "


NO_TIME = "is not a time with its zone"


@pytest.mark.parametrize(
    ("header", "old", "new", "words"),
    [
        ("[[gyro]]", "body = 1", "body = 2", "gyro 2, body: body 2 is described twice"),
        ("[[gyro]]", "body = 1", "body = 5", "gyro 1, body: 5 is not a whole number from 1 to 4"),
        ("[[joint]]", "joint = 1", "joint = 3", "joint 3 is described twice"),
        ("[[servo]]", "joint = 1", "joint = 3", "servo 3, joint: joint 3 is described twice"),
        ("[[joint]]", r"direction = .*", "direction = [1.0, 2.0]", "must be 1 or -1"),
        ("[gyro.bias]", r"value = \[.*", "value = [1.0, 2.0]", r"bias.value: \[1.0, 2.0\] is not 3 finite"),
        ("[gyro.bias]", r"std = \[.*", "std = [0.005, 0.005, 0.006]", "bias.std: is not what its covariance"),
        ("[gyro.bias]", "taken = .*", "taken = 2026-07-01", f"2026-07-01 {NO_TIME}"),
        ("[gyro.mounting]", ROTATION, MIRROR, "mounting.rotation: is no rotation but a mirror"),
        ("[gyro.mounting]", ROTATION, MIRROR.replace("-1.0", "1.1"), "no rotation: its rows are not"),
        ("[gyro.mounting]", "measured = { x", "measured = { w", "mounting.measured.w: is not known"),
        ("[gyro.mounting]", 'measured_frame = "body"\n', "", "mounting.measured_frame: is missing"),
        ("[gyro.scale]", "measured = .*", "measured = { x = true }", f"measured.x: true {NO_TIME}"),
        ("[gyro.scale]", r"value = \[[^,]*", "value = [0.0", "a factor is not above zero"),
        ("[gyro.scale]", r"value = \[[^,]*", "value = [2.1", "a factor is not between 0.5 and 2"),
        ("[gyro.skew]", r"value = \[[^,]*", "value = [0.3", "a skew is beyond 0.25"),
        ("[gyro.bias]", r"value = \[[^,]*", "value = [-2001.0", "a bias is beyond the widest range"),
        ("[gyro.bias]", r"value = \[[^,]*", "value = [1e308", r"bias.value: \[1e\+308, .* is beyond 1e\+12"),
        (
            "[joint.bend]",
            r"value = \[\n    \[[^,]*",
            r"value = [\n    [46.0",
            "an amplitude is beyond 45 deg",
        ),
        ("[gyro.covariance]", FIRST_OF_COVARIANCE, r"value = [\n    [-\1, ", "has a negative variance"),
        ("[gyro.covariance]", FIRST_OF_COVARIANCE + "[^,]*,", r"value = [\n    [\1, 1.0,", "not symmetric"),
        ("[servo.slope]", "value = .*", "value = 0.0", "is zero: such a servo would not move"),
        ("[servo.repeatability]", "value = .*", "value = -0.1", "-0.1 is not a number of at least 0"),
        ("[servo.setting]", "reversed = .*", "reversed = 1", "1 is not true or false"),
    ],
)
def test_what_cannot_be_is_refused(header: str, old: str, new: str, words: str) -> None:
    with pytest.raises(CalibrationError, match=words) as raised:
        parse_calibration(in_table(header, 1, old, new))
    assert re.match(r"calibration\.toml:\d+: ", raised.value.what)


def test_errors_that_cannot_vary_like_that() -> None:
    """Correlations of 1, 1 and -1 contradict each other although each alone could be."""
    calibration = whole_calibration()
    correlation = np.eye(12)
    correlation[:3, :3] = [[1, 0.9, 0.9], [0.9, 1, -0.9], [0.9, -0.9, 1]]
    deviations = np.sqrt(np.diag(calibration.gyros[0].covariance))
    # The deviations stay, so that only the correlations are impossible.
    calibration.gyros[0].covariance[:] = correlation * np.outer(deviations, deviations)
    with pytest.raises(
        CalibrationError, match=r"gyro of body 1, covariance\.value: the covariance is not positive"
    ):
        parse_calibration(format_calibration(calibration))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (r"\A", "[[", "is not valid TOML"),
        ("format = 1", "format = 2", ":4: format: 2 is not 1"),
        ("format = 1\n", "", "format: is missing"),
        (r"(?s)\[\[gyro\]\].*\[\[joint\]\]", "[[joint]]", "there is no \\[\\[gyro\\]\\] of body 1 and 2"),
        (r"(?s)\[\[joint\]\].*", "", "there is no \\[\\[joint\\]\\] of joint 1 and 2 and 3"),
        (r"\Z", "[[landing]]\nat = 5\n", f"landing 1, at: 5 {NO_TIME}"),
        (
            r"\Z",
            '[[recording]]\nstep = "a"\ntaken = 2026-07-01T00:00:00Z\nfile = "../a"\nsha256 = ""\n',
            "no name of a file",
        ),
    ],
)
def test_a_file_of_something_else_is_refused(old: str, new: str, words: str) -> None:
    text, changed = re.subn(old, lambda _: new, WHOLE, count=1)
    assert changed
    with pytest.raises(CalibrationError, match=words):
        parse_calibration(text)


def test_what_a_rehearsal_drew_is_read_back_and_of_a_real_robot_nothing_is_said() -> None:
    assert "drawn" not in WHOLE
    rehearsal_calibration = replace(whole_calibration(), simulated_quantities=("zero", "servo"))
    text = format_calibration(rehearsal_calibration)
    assert 'drawn = ["zero", "servo"]' in text
    assert parse_calibration(text).simulated_quantities == ("zero", "servo")
    for wrong in ('["zero", "all"]', '"zero"', "[1]"):
        with pytest.raises(
            CalibrationError, match="not a list of some of bias, zero, misalignment, scale, servo"
        ):
            parse_calibration(text.replace('["zero", "servo"]', wrong))


def test_the_hash_of_another_protocol_is_only_noted() -> None:
    other = replace(whole_calibration(), protocol_hash="00")
    assert parse_calibration(format_calibration(other)).protocol_hash == "00"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("temperature_c = .*", "temperature_c = 24.0"),
        ("tool_version = .*", 'tool_version = "9"'),
        ("# sha256.*", ""),
    ],
)
def test_what_was_changed_by_hand_is_refused(before: str, after: str) -> None:
    """Refuse a certificate changed by hand: its values must be those computed from its recordings."""
    text = re.sub(before, after, WHOLE, count=1)
    assert text != WHOLE
    with pytest.raises(CalibrationError, match="was changed since tfsat-host wrote it") as caught:
        parse_calibration(text, "calibration.toml")
    assert "certificate-" in caught.value.next_step
    # Windows line ends are no change.
    assert_same(parse_calibration(WHOLE.replace("\n", "\r\n")), whole_calibration())


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (None, "cannot be read: No such file"),
        # Refused by its size, before TOML reads it.
        (b"#" * 5_000_000, "too large"),
    ],
)
def test_files_that_are_no_certificate(tmp_path: Path, data: bytes | None, words: str) -> None:
    path = tmp_path / "calibration.toml"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(CalibrationError, match=words) as raised:
        read_calibration(path)
    assert str(path) in raised.value.what
