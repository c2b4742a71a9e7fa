"""tools/generate_protocol.py: what it checks, what it writes, and what the protocol hash stands for."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from protocol_generator.spec import Spec, SpecError, load_spec
from tests.paths import REPOSITORY
from tfsat_host.protocol.limits import PROTOCOL_HASH

TOML = REPOSITORY / "protocol" / "tfsat.toml"
TEXT = TOML.read_text(encoding="utf-8")
GENERATED_FOLDERS = (
    "firmware/arduino_sequencer/src/protocol",
    "firmware/teensy_logger/src/protocol",
    "firmware/teensy_logger/src/release",
    "host/tfsat_host/protocol",
)
PAGES = ("log-format.md",)
SEQUENCER_CORE = "firmware/arduino_sequencer/src/core"


def generate(tree: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(tree / "tools" / "generate_protocol.py"), *options]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Copy the generator's inputs and outputs to a temporary folder."""
    no_caches = shutil.ignore_patterns("__pycache__")
    shutil.copy(REPOSITORY / "tools" / "generate_protocol.py", _folder(tmp_path / "tools"))
    for folder in ("tools/protocol_generator", "protocol", SEQUENCER_CORE, *GENERATED_FOLDERS):
        shutil.copytree(REPOSITORY / folder, tmp_path / folder, ignore=no_caches)
    _folder(tmp_path / "docs")
    for page in PAGES:
        shutil.copy(REPOSITORY / "docs" / page, tmp_path / "docs" / page)
    return tmp_path


def _folder(path: Path) -> Path:
    path.mkdir(parents=True)
    return path


def files(tree: Path) -> dict[str, str]:
    """Return every text file below `tree`, by its name."""
    paths = [path for path in tree.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    return {path.relative_to(tree).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def test_what_is_committed_is_what_the_specification_says() -> None:
    process = generate(REPOSITORY, "--check")
    assert (process.returncode, process.stdout, process.stderr) == (0, "", "")


def test_every_generated_file_is_watched(tree: Path) -> None:
    """Deleted, all of them are written again as they were; touched, each is named."""
    before = files(tree)
    for folder in GENERATED_FOLDERS:
        for path in (tree / folder).iterdir():
            if path.name not in ("__init__.py", "record.py", "framing.py", "log_layout.py", "live_sample.py"):
                path.unlink()
    for name in ("reference.md", "tfsat_log.ksy", "golden_vectors.json", "golden_vectors.h"):
        (tree / "protocol" / name).unlink()
    for page in PAGES:
        (tree / "docs" / page).unlink()
    missing = set(before) - set(files(tree))
    assert len(missing) > 20
    process = generate(tree)
    assert process.returncode == 0, process.stderr
    assert {line.removeprefix("wrote ") for line in process.stdout.splitlines()} == missing
    assert files(tree) == before

    for name in missing:
        path = tree / name
        path.write_text(path.read_text() + "\n")
    process = generate(tree, "--check")
    assert process.returncode == 1
    assert {line.split()[1] for line in process.stderr.splitlines()} == missing
    assert "make protocol" in process.stderr


@pytest.mark.parametrize(
    "name",
    [
        "firmware/teensy_logger/src/protocol/messages.h",
        "firmware/arduino_sequencer/src/protocol/frame.h",
        "host/tfsat_host/protocol/enums.py",
        "protocol/tfsat_log.ksy",
    ],
)
def test_a_touched_file_fails_the_check_until_it_is_generated_again(tree: Path, name: str) -> None:
    path = tree / name
    original = path.read_text()
    path.write_text(original.replace("1", "2", 1))
    process = generate(tree, "--check")
    assert process.returncode == 1
    assert process.stderr == f"stale: {name} (run `make protocol` and commit the result)\n"
    assert path.read_text() != original  # --check writes nothing
    assert generate(tree).stdout == f"wrote {name}\n"
    assert path.read_text() == original
    assert generate(tree, "--check").returncode == 0


def test_hand_written_link_code_is_copied_to_both_sketches(tree: Path) -> None:
    source = tree / "protocol" / "cpp" / "link.h"
    source.write_text(source.read_text() + "// changed\n")
    process = generate(tree)
    assert sorted(process.stdout.splitlines()) == [
        f"wrote {folder}/link.h" for folder in GENERATED_FOLDERS[:2]
    ]


def test_a_contradiction_is_an_error_that_names_the_file(tree: Path) -> None:
    before = files(tree)
    broken = TEXT.replace("id = 0x21", "id = 0x20")
    (tree / "protocol" / "tfsat.toml").write_text(broken)
    process = generate(tree)
    assert process.returncode == 1
    assert process.stderr.startswith("protocol/tfsat.toml: message ids must be different")
    assert files(tree) == before | {"protocol/tfsat.toml": broken}


def change_spec(tmp_path: Path, old: str, new: str) -> Spec:
    assert TEXT.count(old) >= 1, f"the specification no longer has {old}"
    path = tmp_path / "tfsat.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    return load_spec(path)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('type = "Sample"', 'type = "Sampel"', "unknown type Sampel"),
        ('type = "u8[8]"', 'type = "u8[x]"', r"unknown type u8\[x\]"),
        ("id = 0x03", "id = 0x02", "must be different"),
        ("id = 0x03", "id = 0x83", "within 0x01 to 0x7F"),
        ("id = 0x03", "id = 0x00", "within 0x01 to 0x7F"),
        ("max_payload_bytes = 96", "max_payload_bytes = 85", "live_sample: payload over"),
        ("armed = { value = 1", "armed = { value = 0", "SequencerState: two names share a value"),
        ("samples_per_block = { value = 6", "samples_per_block = { value = 7", "does not hold its samples"),
        ("events_per_block = { value = 2", "events_per_block = { value = 3", "does not hold its samples"),
        (
            'name = "samples_dropped", type = "u32"',
            'name = "samples_dropped", type = "u8[500]"',
            "payload over|hold",
        ),
        ('name = "blocks", type = "u32"', 'name = "blocks", type = "u8[480]"', "LogFooter does not fit"),
        ('meaning = "Nothing was changed."', 'meaning = ""', "meaning and remedy are missing"),
        (
            'remedy = "`tfsat-host upload-sequence 59 70`"',
            'remedy = ""',
            "error no_maneuver: meaning and remedy",
        ),
    ],
)
def test_contradictions(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    with pytest.raises(SpecError, match=complaint):
        change_spec(tmp_path, old, new)


def test_the_host_has_the_hash_of_the_specification() -> None:
    assert load_spec(TOML).hash == PROTOCOL_HASH


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Kind of board that answers HELLO.", "Which board it is."),
        ("The upload was interrupted; nothing was stored,", "Nothing happened,"),
        ("Choose smaller strokes.", "Take less."),
        ("a second copy finds the board safe", "twice is once"),
        ('firmware_version = "0.2.0"', 'firmware_version = "0.2.1"'),
        ("# ---", "# another comment ---"),
    ],
)
def test_the_hash_ignores_prose(tmp_path: Path, old: str, new: str) -> None:
    assert change_spec(tmp_path, old, new).hash == PROTOCOL_HASH


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("fall_us = { value = 2500000", "fall_us = { value = 2500001"),
        ("id = 0x21", "id = 0x2F"),
        ('name = "arm_token", type = "u16"', 'name = "arm_token", type = "u32"'),
        ('name = "arm_token"', 'name = "token"'),
        ("watchdog = { value = 3", "watchdog = { value = 9"),
        ("CRC-16/IBM-3740", "CRC-16/XMODEM"),
        ("[message.disarm]", "[message.stand_down]"),
        (
            '{ name = "index", type = "u8", doc = "From 0." },\n  { name = "joint", type = "u8", doc = "1 to 3." },',
            '{ name = "joint", type = "u8", doc = "1 to 3." },\n  { name = "index", type = "u8", doc = "From 0." },',
        ),
    ],
)
def test_the_hash_changes_with_what_the_sides_must_agree_on(tmp_path: Path, old: str, new: str) -> None:
    assert change_spec(tmp_path, old, new).hash != PROTOCOL_HASH
