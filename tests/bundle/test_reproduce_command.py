"""`reproduce`: the raw data give what was bundled, or what differs is said by name and number."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.bundle.commands import command, result
from tests.bundle.rewritten import rewrite
from tfsat_host.report import render
from tfsat_host.run.bundle.recomputing import Recomputed, document_in


def test_a_bundle_gives_the_same_again(bundle: Path) -> None:
    said = result("reproduce", bundle)
    assert said["same"] is True
    assert [(one["what"], one["differences"]) for one in said["compared"]] == [
        ("evaluation", []),
        ("report", []),
        ("calibration", None),
    ]
    assert said["record"] == [] and said["environment"] == []
    assert said["folder"] == "run-reproduced"
    folder = Path("run-reproduced")
    with zipfile.ZipFile(bundle) as opened:
        for name in opened.namelist():
            assert (folder / name).read_bytes() == opened.read(name), "computing changes nothing"
    assert "SAME: " in command("reproduce", bundle, "--out", "other").out


def test_the_folder_must_be_new(bundle: Path) -> None:
    command("reproduce", bundle)
    said = command("reproduce", bundle, expect=1)
    assert "run-reproduced is there already" in said.err
    Path("empty").mkdir()
    command("reproduce", bundle, "--out", "empty")


def evaluation_with(change: Callable[[Any], None]) -> Callable[[dict[str, bytes]], None]:
    def edit(files: dict[str, bytes]) -> None:
        values = json.loads(files["evaluation.json"])
        change(values)
        files["evaluation.json"] = json.dumps(values).encode()

    return edit


def test_a_number_that_differs_is_named_with_both_values(bundle: Path) -> None:
    def change(values: Any) -> None:
        values["reorientation_deg"] *= 1.0 + 1e-4
        values["strokes"][1]["size_deg"] += 0.01

    rewrite(bundle, evaluation_with(change))
    said = result("reproduce", bundle, expect=3)
    assert said["same"] is False
    evaluation, report, _ = said["compared"]
    keys = {one["key"]: one["relative"] for one in evaluation["differences"]}
    assert keys.keys() == {"reorientation_deg", "strokes[1].size_deg"}
    assert keys["reorientation_deg"] == pytest.approx(1e-4, rel=1e-3)
    assert report["differences"] == []
    shutil.rmtree("run-reproduced")
    words = command("reproduce", bundle, expect=3).words
    assert "Evaluation: 2 DIFFER" in words and "strokes[1].size_deg" in words and "NOT THE SAME" in words


def test_what_another_machine_does_to_the_last_digits_is_no_difference(bundle: Path) -> None:
    def change(values: Any) -> None:
        values["reorientation_deg"] *= 1.0 + 1e-6
        values["attitude_covariance_deg2"][0][1] += 1e-13

    rewrite(bundle, evaluation_with(change))
    assert result("reproduce", bundle)["same"] is True


def test_words_that_differ_and_keys_that_are_gone_are_named(bundle: Path) -> None:
    def change(values: Any) -> None:
        values["verdict"]["level"] = "doubtful"
        del values["lag"]
        values["more"] = 1

    rewrite(bundle, evaluation_with(change))
    said = result("reproduce", bundle, expect=3)
    differs = {one["key"]: (one["bundled"], one["recomputed"]) for one in said["compared"][0]["differences"]}
    assert differs.keys() == {"verdict.level", "lag", "more"}
    assert differs["verdict.level"] == ("doubtful", "good")
    assert differs["lag"][0] == differs["more"][1] == "not there"


def test_only_the_document_of_the_page_is_compared(bundle: Path) -> None:
    def other_style(files: dict[str, bytes]) -> None:
        files["report.html"] = files["report.html"].replace(b"<style>", b"<style>/* another version */")

    rewrite(bundle, other_style)
    assert result("reproduce", bundle)["same"] is True

    def other_curve(files: dict[str, bytes]) -> None:
        document = document_in(files["report.html"].decode())
        document["drops"][0]["plots"][0]["series"][0]["values"][100] += 1.0
        files["report.html"] = render(document).encode()

    rewrite(bundle, other_curve)
    said = result("reproduce", bundle, "--out", "again", expect=3)
    (one,) = said["compared"][1]["differences"]
    assert one["key"] == "drops[0].plots[0].series[0].values[100]"


def test_another_recording_gives_other_numbers(bundle: Path) -> None:
    """The hashes are right, and still the raw data do not give what stands there."""

    def shorter(files: dict[str, bytes]) -> None:
        blocks = files["run/SD.bin"]
        middle = len(blocks) // 1024 * 512
        files["run/SD.bin"] = blocks[:middle] + bytes(512) + blocks[middle + 512 :]

    rewrite(bundle, shorter)
    said = result("reproduce", bundle, expect=3)
    assert any(one["key"].startswith("recording.samples") for one in said["compared"][0]["differences"])


def test_a_changed_file_is_refused_by_name(bundle: Path) -> None:
    def change(files: dict[str, bytes]) -> None:
        files["run/maneuver.toml"] = files["run/maneuver.toml"].replace(b"59.0", b"58.0")

    rewrite(bundle, change, hashes=False)
    said = command("reproduce", bundle, expect=1)
    assert "run/maneuver.toml" in said.err and "Nothing was unpacked" in said.err
    assert not Path("run-reproduced").exists()


def test_another_environment_is_told_and_no_difference(bundle: Path) -> None:
    def change(files: dict[str, bytes]) -> None:
        values = json.loads(files["environment.json"])
        values["packages"]["numpy"] = "1.0"
        files["environment.json"] = json.dumps(values).encode()

    rewrite(bundle, change)
    said = result("reproduce", bundle)
    assert said["same"] is True and len(said["environment"]) == 1
    assert said["environment"][0].startswith("numpy: 1.0 then, ")


@pytest.mark.parametrize("name", ["evaluation.json", "environment.json", "report.html"])
@pytest.mark.parametrize("data", [b"", b"[]", b"\xff", b"[" * 100_000, b'{"packages": [1], "k": 1e999}'])
def test_parts_that_nobody_would_write_are_differences_and_no_crash(
    bundle: Path, monkeypatch: pytest.MonkeyPatch, name: str, data: bytes
) -> None:
    monkeypatch.setattr(
        "tfsat_host.run.bundle.recomputing.recompute", lambda *_: Recomputed({"a": [1.0]}, None, None)
    )
    if name == "report.html":
        data = b'<script type="application/json" id="document">' + data + b"</script>"

    def change(files: dict[str, bytes]) -> None:
        files[name] = data

    rewrite(bundle, change)
    assert result("reproduce", bundle, expect=3)["same"] is False
    command("reproduce", bundle, "--out", "again", expect=3)
