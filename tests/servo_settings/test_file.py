"""The settings' file: what is written is read, exactly, and what cannot be read is said with its line."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given

from tests.servo_settings.values import valid_settings
from tfsat_host.config import Fault
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import (
    FACTORY,
    ServoSettings,
    SettingsDefect,
    SettingsError,
    format_settings,
    parse_settings,
    read_settings_file,
)

# Joint 2 is reversed and first, joint 3 is at the end of the range: 600 + 90 x 20 = 2400 us.
TEXT = """\
format = 1
frame_ms = 12.5

[[servo]]
joint = 2
zero_us = 2000
us_per_deg = 10.5
reversed = true
limits_deg = [0, 75.25]

[[servo]]
joint = 1
zero_us = 1000
us_per_deg = 11.111
reversed = false
limits_deg = [0.0, 90.0]

[[servo]]
joint = 3
zero_us = 600
us_per_deg = 20
reversed = false
limits_deg = [0, 90]
"""


def test_units_and_the_order_of_the_joints() -> None:
    assert parse_settings(TEXT) == (
        ServoSettings(
            12_500,
            (
                ServoSetting(1000, 11_111, 0, 0, 9000),
                ServoSetting(2000, 10_500, 1, 0, 7525),
                ServoSetting(600, 20_000, 0, 0, 9000),
            ),
        ),
        [],
    )


@given(valid_settings())
def test_what_is_written_is_read_exactly(servo_settings: ServoSettings) -> None:
    assert parse_settings(format_settings(servo_settings)) == (servo_settings, [])


@pytest.mark.parametrize(
    ("old", "new", "expected_text", "rounded_number"),
    [
        # Half to even, as the maneuver's angles.
        ("zero_us = 2000", "zero_us = 2000.5", "rounded from 2000.5 to 2000 us: the board resolves 1 us.", 2000),
        ("zero_us = 2000", "zero_us = 2001.5", "joint 2: zero_us was rounded from 2001.5 to 2002 us:", 2002),
        ("us_per_deg = 10.5", "us_per_deg = 10.5006", "to 10.501 us per deg: the board resolves 0.001 us per", 10_501),
        ("75.25", "75.256", "limits_deg was rounded from 75.256 to 75.26 deg: the board resolves 0.01 deg", 7526),
        ("frame_ms = 12.5", "frame_ms = 12.50049", "from 12.50049 to 12.5 ms: the board resolves 0.001 ms", 12_500),
    ],
)  # fmt: skip
def test_rounding_is_said(old: str, new: str, expected_text: str, rounded_number: int) -> None:
    servo_settings, (notice,) = parse_settings(TEXT.replace(old, new))
    assert expected_text in notice
    servo = servo_settings.of(2)
    assert rounded_number in (servo.zero_us, servo.ns_per_deg, servo.max_cdeg, servo_settings.frame_us)


def test_a_decimal_is_taken_as_it_is_written() -> None:
    """11.115 has no exact binary value, nor has 0.29."""
    servo_settings, notices = parse_settings(TEXT.replace("11.111", "11.115").replace("75.25", "0.29"))
    assert (servo_settings.of(1).ns_per_deg, servo_settings.of(2).max_cdeg, notices) == (11_115, 29, [])


@pytest.mark.parametrize(
    ("old", "new", "code", "line"),
    [
        ("format = 1\n", "", Fault.MISSING_KEY, 1),
        ("format = 1", "format = 2", Fault.FORMAT, 1),
        ("frame_ms = 12.5", "frame_ms = 21", SettingsDefect.FRAME_RANGE, 2),
        ("frame_ms = 12.5", "frame_us = 12500", Fault.UNKNOWN_KEY, 2),
        ("frame_ms = 12.5\n", "", Fault.MISSING_KEY, 1),
        ("joint = 3", "joint = 4", Fault.WRONG_TYPE, 19),
        ("joint = 3", "joint = 2", SettingsDefect.FILE_JOINTS, 19),
        ("joint = 3\n", "", Fault.MISSING_KEY, 18),
        ("zero_us = 2000", "zero_us = 1e300", Fault.WRONG_TYPE, 6),
        ("zero_us = 2000", "zero_us = 70000", SettingsDefect.PULSE_RANGE, 6),
        # The board drives no pulse below 500 us.
        ("zero_us = 600", "zero_us = 499", SettingsDefect.PULSE_RANGE, 20),
        ("us_per_deg = 10.5", "us_per_deg = -10.5", SettingsDefect.SLOPE_RANGE, 7),
        # 600 + 90 x 21.2 = 2508 us: above 2500 us at the end of the range.
        ("us_per_deg = 20", "us_per_deg = 21.2", SettingsDefect.PULSE_RANGE, 21),
        ("reversed = true", "reversed = 1", Fault.WRONG_TYPE, 8),
        # 2000 + 75.25 x 10.5 = 2790 us: not reversed, this servo would be driven against its stop.
        ("reversed = true", "reversed = false", SettingsDefect.PULSE_RANGE, 7),
        ("[0, 75.25]", "[0, 90.01]", SettingsDefect.JOINT_LIMITS, 9),
        ("[0, 75.25]", "[-5, 75.25]", SettingsDefect.JOINT_LIMITS, 9),
    ],
)
def test_a_defect_has_a_name_a_line_and_a_cure(
    old: str, new: str, code: SettingsDefect | Fault, line: int
) -> None:
    with pytest.raises(SettingsError) as caught:
        parse_settings(TEXT.replace(old, new, 1), source="servos.toml")
    assert caught.value.code == code
    assert caught.value.what.startswith(f"servos.toml:{line}: ")
    assert len(caught.value.what) < 300
    assert caught.value.next_step
    assert "settings are as they were" in caught.value.meaning


def test_a_joint_that_is_missing() -> None:
    with pytest.raises(SettingsError, match=r"there is no \[\[servo\]\] of joint 1 and 3") as caught:
        parse_settings(TEXT[: TEXT.index("[[servo]]\njoint = 1")])
    assert caught.value.code == SettingsDefect.FILE_JOINTS
    with pytest.raises(SettingsError, match=r"no \[\[servo\]\] of joint 1 and 2 and 3"):
        parse_settings("format = 1\nframe_ms = 20\n")
    with pytest.raises(SettingsError) as caught:
        parse_settings("format = 1\nframe_ms = 20\nservo = 3\n")
    assert caught.value.code == Fault.WRONG_TYPE


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    # An umlaut of a Windows editor, an interrupted save, something that is no settings file.
    (tmp_path / "latin.toml").write_bytes(b"# \xe9\nformat = 1\n")
    (tmp_path / "torn.toml").write_text("format = ")
    (tmp_path / "large.toml").write_text("#" * 1_000_001)
    (tmp_path / "good.toml").write_text(format_settings(FACTORY))
    assert read_settings_file(tmp_path / "good.toml") == (FACTORY, [])
    for name, code in {
        "latin.toml": Fault.UNREADABLE,
        "missing.toml": Fault.UNREADABLE,
        "torn.toml": Fault.SYNTAX,
        "large.toml": Fault.SYNTAX,
    }.items():
        with pytest.raises(SettingsError) as caught:
            read_settings_file(tmp_path / name)
        assert caught.value.code == code
