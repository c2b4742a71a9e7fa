"""What was commanded in a drop: what the sequencer held, not a file that happens to lie there."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import Served
from tests.evaluation.run_folder import run_folder
from tfsat_host.devices.sequencer import maneuver_crc
from tfsat_host.maneuver import (
    Maneuver,
    Stroke,
    format_maneuver,
    four_stroke,
    read_maneuver,
    schedule_maneuver,
    write_maneuver,
)
from tfsat_host.sdlog import load

# Close to what is flown, 0.2 deg off: a mix-up that no plot would show.
STALE = four_stroke(59.2, 69.8)


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.chdir(tmp_path)
    with Served() as process:
        yield process


@pytest.fixture
def ports(robot: Served) -> dict[str, str]:
    return {
        "TFSAT_SEQUENCER_PORT": robot.announced["sequencer"],
        "TFSAT_LOGGER_PORT": robot.announced["logger"],
    }


def test_a_drop_by_hand_is_compared_with_what_the_sequencer_held(
    robot: Served, ports: dict[str, str], tfsat_host: RunCli, tmp_path: Path
) -> None:
    stale = tmp_path / "maneuver.toml"
    write_maneuver(STALE, stale)
    uploaded = tfsat_host("upload-sequence", 59, 70, environ=ports)
    assert "maneuver.toml in this folder is another maneuver" in uploaded.stderr
    assert "tfsat-host upload-sequence 59 70 --out maneuver.toml --force" in uploaded.stderr
    # The hint must repeat everything that was typed, or it would write another maneuver.
    slower = tfsat_host("upload-sequence", 59.25, 70, "--speed", 150, environ=ports, expect=3).stderr
    assert "tfsat-host upload-sequence 59.25 70 --speed 150 --out maneuver.toml --force" in slower
    # The last upload before the drop is what the board holds.
    tfsat_host("upload-sequence", 59, 70, environ=ports)
    started = tfsat_host.json("record", "start", environ=ports)
    crc = f"{maneuver_crc(schedule_maneuver(four_stroke(59, 70))):04x}"
    assert started["maneuver_crc"] == crc
    tfsat_host("arm", "--yes", environ=ports)
    # Hang, fall, land; the recording goes on for half a second.
    robot.control("wait 3s", "drop", "wait still", "wait 500ms")
    tfsat_host("record", "stop", environ=ports)
    tfsat_host("log", "fetch", 1, environ=ports)
    note = tmp_path / f"maneuver-{started['session']}.toml"
    assert f"CRC {crc}" in note.read_text(encoding="utf-8")
    assert read_maneuver(note).name == "59/70", "the upload's own name, which no board stores"

    evaluation = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)
    assert evaluation["maneuver"] == note.name
    assert [round(stroke["commanded_deg"], 6) for stroke in evaluation["strokes"]] == [
        59.0,
        70.0,
        -59.0,
        -70.0,
    ]
    assert any("maneuver.toml is not the maneuver" in reason for reason in evaluation["verdict"]["reasons"])

    # Without the note beside it: the state folder has its own copy.
    note.unlink()
    again = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)
    assert Path(again["maneuver"]).name == note.name, "this computer remembers the session"
    # Without any note, on the computer that uploaded it: the card's header names what it kept.
    remembered = Path(again["maneuver"])
    told = remembered.read_bytes()
    remembered.unlink()
    by_header = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)
    kept = Path(by_header["maneuver"])
    assert kept.name.endswith(f"-{crc}.toml")
    assert by_header["strokes"] == again["strokes"]
    # On another computer: the card alone contradicts a maneuver.toml, and agrees with the right one.
    kept.unlink()
    assert f"CRC {crc} on the sequencer" in tfsat_host("decode", "DROP0001.BIN").stdout
    reasons = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)["verdict"]["reasons"]
    assert any(f"held in this drop (CRC {crc} in the log's header)" in reason for reason in reasons)
    write_maneuver(four_stroke(59, 70), stale)
    right = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)
    assert not any("maneuver.toml" in reason for reason in right["verdict"]["reasons"])
    # With no maneuver.toml to contradict, the note alone tells what was commanded.
    remembered.write_bytes(told)
    stale.unlink()
    alone = tfsat_host.json("evaluate", "DROP0001.BIN", expect=3)
    assert Path(alone["maneuver"]).name == note.name
    assert not any("maneuver.toml" in reason for reason in alone["verdict"]["reasons"])


def test_an_upload_during_the_recording_is_noted_by_arm(
    robot: Served, ports: dict[str, str], tfsat_host: RunCli, tmp_path: Path
) -> None:
    tfsat_host("upload-sequence", 30, 40, environ=ports)
    tfsat_host("record", "start", environ=ports)
    # After `record start` noted 30/40: what arm reads back overrides it.
    tfsat_host("upload-sequence", 59, 70, environ=ports)
    armed = tfsat_host("arm", "--yes", environ=ports)
    # The header on the card names the earlier one, and cannot be mended from here.
    crcs = [f"{maneuver_crc(schedule_maneuver(four_stroke(*angles))):04x}" for angles in ((30, 40), (59, 70))]
    warned = " ".join(armed.stderr.split())
    assert f"header names maneuver {crcs[0]}, the sequencer holds {crcs[1]}" in warned
    assert tfsat_host.json("status", environ=ports)["logger"]["maneuver_crc"] == crcs[0]
    robot.control("wait 3s", "drop", "wait still", "wait 500ms")
    tfsat_host("record", "stop", environ=ports)
    (fetched,) = tfsat_host.json("log", "fetch", 1, environ=ports)["logs"]
    schedule = schedule_maneuver(read_maneuver(Path(fetched["maneuver"])))
    assert schedule.is_same_motion(schedule_maneuver(four_stroke(59, 70)))


@pytest.fixture
def drop_folder(tmp_path: Path) -> Path:
    """Return a drop with the note of the sequencer's maneuver, and another maneuver in maneuver.toml."""
    folder = tmp_path / "noted"
    run_folder(folder)
    note = folder / f"maneuver-{load(folder / 'SD.bin').session:08x}.toml"
    # Explicit times and no name, as a board's read-back gives them.
    timed = schedule_maneuver(four_stroke(59.0, 70.0))
    strokes = tuple(Stroke(stroke.joint, stroke.angle_deg, stroke.t_s) for stroke in timed.strokes)
    note.write_text(format_maneuver(Maneuver(strokes)), encoding="utf-8")
    write_maneuver(STALE, folder / "maneuver.toml")
    return folder


def test_a_replaced_maneuver_is_refused_and_the_flown_strokes_are_measured(
    drop_folder: Path, tfsat_host: RunCli
) -> None:
    process = tfsat_host("evaluate", drop_folder, expect=3)
    assert "DOUBTFUL" in process.stdout
    assert "another maneuver than maneuver.toml was flown" in " ".join(process.stdout.lower().split())
    evaluation = tfsat_host.json("evaluate", drop_folder, expect=3)
    assert [round(stroke["commanded_deg"], 6) for stroke in evaluation["strokes"]] == [
        59.0,
        70.0,
        -59.0,
        -70.0,
    ]
    assert all(stroke["moved"] for stroke in evaluation["strokes"])


def test_a_named_maneuver_overrides_and_the_report_says_so(
    drop_folder: Path, tfsat_host: RunCli, tmp_path: Path
) -> None:
    named = tmp_path / "other.toml"
    write_maneuver(STALE, named)
    evaluation = tfsat_host.json("evaluate", drop_folder, "--maneuver", named)
    assert round(evaluation["strokes"][0]["commanded_deg"], 6) == 59.2
    # A person may insist; the result has to say so wherever it is shown.
    assert any("it was named with --maneuver" in note for note in evaluation["notes"])
    tfsat_host("report", drop_folder, "--maneuver", named, "--out", tmp_path / "r.html", expect=None)
    assert "it was named with --maneuver" in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_the_same_maneuver_is_accepted_from_its_own_file(drop_folder: Path, tfsat_host: RunCli) -> None:
    # The rule's times equal the note's explicit ones: the same motion from another text.
    write_maneuver(four_stroke(59.0, 70.0), drop_folder / "maneuver.toml")
    evaluation = tfsat_host.json("evaluate", drop_folder, expect=0)
    assert Path(evaluation["maneuver"]).name == "maneuver.toml"
    assert not any("maneuver.toml" in reason for reason in evaluation["verdict"]["reasons"])


def test_a_bundle_carries_what_the_sequencer_held(
    drop_folder: Path, tfsat_host: RunCli, tmp_path: Path
) -> None:
    # Only the note is left to tell what was commanded.
    (drop_folder / "maneuver.toml").unlink()
    archive = tmp_path / "drop.tfsat.zip"
    bundled = tfsat_host.json("bundle", drop_folder, "--out", archive, expect=0)
    assert not any(missing["what"] == "maneuver" for missing in bundled["missing"]), json.dumps(bundled)
    again = tfsat_host.json("reproduce", archive, expect=0)
    assert again["same"] is True
