"""sketch.yaml and platformio.ini name boards, flags and folders as they are. The tools themselves are not run here."""

from __future__ import annotations

import configparser
import re
from pathlib import Path
from typing import Any

import pytest
import yaml  # comes with myst-parser

from tests.paths import REPOSITORY

FLASHING = (REPOSITORY / "docs" / "guide" / "flashing.md").read_text(encoding="utf-8")
SEQUENCER_MK = (REPOSITORY / "tools" / "firmware" / "sequencer.mk").read_text(encoding="utf-8")
LOGGER_MK = (REPOSITORY / "tools" / "firmware" / "logger.mk").read_text(encoding="utf-8")
SKETCHES = ("arduino_sequencer", "teensy_logger")
CORE = Path("/usr/share/arduino/hardware/arduino/avr")

# Arduino's description of the sketch project file, docs/sketch-project-file.md of arduino-cli.
TOP_KEYS = {
    "profiles",
    "default_profile",
    "default_fqbn",
    "default_programmer",
    "default_port",
    "default_port_config",
    "default_protocol",
}
PROFILE_KEYS = {"notes", "fqbn", "programmer", "platforms", "libraries", "port", "port_config", "protocol"}


def _sketch(name: str) -> dict[str, Any]:
    sketch = yaml.safe_load((REPOSITORY / "firmware" / name / "sketch.yaml").read_text(encoding="utf-8"))
    assert isinstance(sketch, dict)
    return sketch


def _platformio() -> configparser.ConfigParser:
    parser = configparser.ConfigParser()
    parser.read_string((REPOSITORY / "platformio.ini").read_text(encoding="utf-8"))
    return parser


@pytest.mark.parametrize("name", SKETCHES)
def test_a_sketch_project_file_has_the_documented_keys_alone(name: str) -> None:
    sketch = _sketch(name)
    assert set(sketch) <= TOP_KEYS
    for profile in sketch.get("profiles", {}).values():
        assert {"fqbn", "platforms"} <= set(profile) <= PROFILE_KEYS
        for platform in profile["platforms"]:
            maker = re.fullmatch(r"(\w+):\w+ \(\d+\.\d+\.\d+\)", platform["platform"])
            # Without an address only Arduino's own platforms are found.
            assert maker and (maker[1] == "arduino") == ("platform_index_url" not in platform)
    if "default_profile" in sketch:
        assert sketch["default_profile"] in sketch["profiles"]


def test_the_sequencers_profile_is_the_board_and_the_core_that_the_image_is_built_with() -> None:
    profile = _sketch("arduino_sequencer")["profiles"]["micro"]
    assert profile["fqbn"] == "arduino:avr:micro"
    assert "variants/micro" in SEQUENCER_MK and "-DARDUINO_AVR_MICRO" in SEQUENCER_MK
    version = re.search(r"^version=(.+)$", (CORE / "platform.txt").read_text(encoding="utf-8"), re.MULTILINE)
    assert version and profile["platforms"][0]["platform"] == f"arduino:avr ({version[1]})"


def test_the_loggers_board_options_are_those_it_is_compiled_with() -> None:
    profile = _sketch("teensy_logger")["profiles"]["teensy41"]
    assert [platform["platform"] for platform in profile["platforms"]] == ["teensy:avr (1.59.0)"]
    package, architecture, board, options = profile["fqbn"].split(":")
    assert (package, architecture, board) == ("teensy", "avr", "teensy41")
    # Another USB type has other ids than the host looks for; another clock has another timing.
    assert dict(option.split("=") for option in options.split(",")) == {"usb": "serial", "speed": "600"}
    for flag in ("-DARDUINO_TEENSY41", "-DF_CPU=600000000", "-DUSB_SERIAL"):
        assert flag in LOGGER_MK


def test_platformio_builds_the_sketch_folders_with_their_flags() -> None:
    ini = _platformio()
    assert set(ini.sections()) == {"platformio", "env:sequencer", "env:logger"}
    sketch = REPOSITORY / ini["platformio"]["src_dir"]
    assert (sketch / f"{sketch.name}.ino").is_file()
    assert ini["platformio"]["default_envs"] == "sequencer"
    assert (ini["env:sequencer"]["platform"], ini["env:sequencer"]["board"]) == ("atmelavr", "micro")
    logger = ini["env:logger"]
    assert (logger["platform"], logger["board"]) == ("teensy", "teensy41")
    standard = re.search(r"-std=gnu\+\+\d+", LOGGER_MK)
    assert standard and logger["build_flags"].split() == [standard[0], "-D", "USB_SERIAL"]
    assert standard[0] not in logger["build_unflags"]


def test_the_flashing_page_types_profiles_environments_and_folders_that_exist() -> None:
    profiles = {name for sketch in SKETCHES for name in _sketch(sketch)["profiles"]}
    assert set(re.findall(r"--profile (\w+)", FLASHING)) == profiles
    environments = re.findall(r"pio run -e (\w+)", FLASHING)
    assert {f"env:{name}" for name in environments} == set(_platformio().sections()) - {"platformio"}
    folders = re.findall(r"(?:\$PWD/|compile .*)(firmware/\w+)", FLASHING)
    assert len(folders) >= 3
    for folder in folders:
        assert (REPOSITORY / folder / f"{Path(folder).name}.ino").is_file()
