"""`reproduce`: the raw data give what was bundled, or what differs is named; 0 only if all of it was computed."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.calibration.bench_day import REST, SWINGS, ZERO, record_good_step
from tests.contract.running import unpack_drop
from tests.evaluation.run_folder import CERTIFICATE
from tests.run.bundle.commands import command, result, rewrite, rewrite_json
from tests.run.bundle.conftest import PAGE, STEPS
from tfsat_host.calibration.certificate.calibration_campaign import note_landing
from tfsat_host.calibration.certificate.certificate import Landing
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.calibration.steps.evidence import to_bytes
from tfsat_host.cli.main import main
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.report import render
from tfsat_host.run import drop_evaluation
from tfsat_host.run.bundle.reproducing import document_in

ARCHIVE = Path("run.tfsat.zip")
RECORDINGS = CERTIFICATE.replace(".toml", "-recordings")
Computed = Callable[[str | None], None]


def test_a_bundle_gives_the_same_again(bundle: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drop_evaluation, "evaluate", evaluate)  # computed, and not kept
    output = command("reproduce", bundle)
    reproduction = output.result
    assert (reproduction["same"], reproduction["complete"], reproduction["incomplete"]) == (True, True, [])
    assert [(comparison["what"], comparison["differences"]) for comparison in reproduction["compared"]] == [
        ("evaluation", []),
        ("report", []),
        ("calibration", None),
    ]
    assert reproduction["record"] == [] and reproduction["environment"] == []
    assert reproduction["folder"] == "run-reproduced"
    folder = Path("run-reproduced")
    with zipfile.ZipFile(bundle) as opened:
        for name in opened.namelist():
            assert (folder / name).read_bytes() == opened.read(name), "computing changes nothing"
    lines = output.out.splitlines()
    assert output.words.startswith("Reproduced identically: evaluation (") and len(lines) <= 6
    assert "SHA-256 of all files verified" in output.words and "NOT REPRODUCED" not in output.words


def test_the_folder_must_be_new_and_the_bundle_one(
    bundle: Path, fixed_evaluation: Computed, capsys: pytest.CaptureFixture[str]
) -> None:
    fixed_evaluation(PAGE)
    Path("run-reproduced").mkdir()
    # An empty folder is as good as a new one.
    command("reproduce", bundle, expect=3)
    assert "run-reproduced exists and is not empty" in command("reproduce", bundle, expect=1).err
    output = command("reproduce", "run-reproduced", expect=1)
    assert "run-reproduced is a folder; BUNDLE is a file that tfsat-host bundle makes" in output.err
    assert "There is no file nope.zip; BUNDLE is a file" in command("reproduce", "nope.zip", expect=1).err
    with pytest.raises(SystemExit):
        main(["reproduce", "--help"])
    assert "NAME-reproduced" in capsys.readouterr().out


def test_a_number_that_differs_is_named_with_both_values(bundle: Path) -> None:
    def change(values: Any) -> None:
        # Ten times the relative tolerance of 1e-5.
        values["reorientation_deg"] *= 1.0 + 1e-4
        values["strokes"][1]["size_deg"] += 0.01
        values["attitude_covariance_deg2"][0][1] += 1e-13  # what another machine does to the last digits
        # A tenth of the tolerance: no difference.
        values["initial_rate_deg_s"][0] *= 1.0 + 1e-6

    rewrite_json(bundle, "evaluation.json", change)
    output = command("reproduce", bundle, expect=3)
    assert output.result["same"] is False
    evaluation, report, _ = output.result["compared"]
    keys = {difference["key"]: difference["relative"] for difference in evaluation["differences"]}
    assert keys.keys() == {"reorientation_deg", "strokes[1].size_deg"}
    assert keys["reorientation_deg"] == pytest.approx(1e-4, rel=1e-3)
    assert report["differences"] == []
    words = output.words
    verdict = "NOT REPRODUCED: 2 differences in evaluation; identical: report ("
    assert words.startswith(verdict) and words.count(verdict) == 2, "first and last"
    assert "Evaluation: 2 differences (" in words and "allowed: 1e-05 relative or 1e-09" in words
    assert "strokes[1].size_deg" in words


def test_words_that_differ_and_keys_that_are_gone_are_named(bundle: Path) -> None:
    def change(values: Any) -> None:
        # A changed word, a key that is missing, and one that nothing computes any more.
        values["verdict"]["level"] = "doubtful"
        del values["lag"]
        values["more"] = 1

    rewrite_json(bundle, "evaluation.json", change)
    reproduction = result("reproduce", bundle, expect=3)
    differs = {
        difference["key"]: (difference["bundled"], difference["recomputed"])
        for difference in reproduction["compared"][0]["differences"]
    }
    assert differs.keys() == {"verdict.level", "lag", "more"}
    assert differs["verdict.level"] == ("doubtful", "good")
    assert differs["lag"][0] == differs["more"][1] == "not there"


def test_only_the_document_of_the_page_is_compared(bundle: Path) -> None:
    # A new style of the page is no other result.
    def other_style(files: dict[str, bytes]) -> None:
        files["report.html"] = files["report.html"].replace(b"<style>", b"<style>/* another version */")

    rewrite(bundle, other_style)
    rewrite_json(bundle, "environment.json", lambda values: values["packages"].update(numpy="1.0"))
    reproduction = result("reproduce", bundle)
    assert reproduction["same"] is True, "nor is another environment a difference"
    assert [sentence.partition(" now")[0] for sentence in reproduction["environment"]] == [
        f"numpy: 1.0 then, {np.__version__}"
    ]

    # One point of a curve: what a person reads off the page.
    def other_curve(files: dict[str, bytes]) -> None:
        document = document_in(files["report.html"].decode())
        document["drops"][0]["plots"][0]["series"][0]["values"][100] += 1.0
        files["report.html"] = render(document).encode()

    rewrite(bundle, other_curve)
    reproduction = result("reproduce", bundle, "--out", "again", expect=3)
    (difference,) = reproduction["compared"][1]["differences"]
    assert difference["key"] == "drops[0].plots[0].series[0].values[100]"


def test_a_bundle_of_an_older_program_is_computed_and_the_program_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reproduce a drop of tfsat 0.2.0, whose manifest has fewer entries and whose estimators were others."""
    unpack_drop(tmp_path)
    monkeypatch.chdir(tmp_path)
    output = command("reproduce", "drop.tfsat.zip", expect=3)
    evaluation, _, calibration = output.result["compared"]
    assert evaluation["differences"] and calibration["differences"] == []
    words = output.words
    assert words.startswith("NOT REPRODUCED: ") and "identical: calibration (from 1 recording" in words
    assert "Program: changed since the bundle was made (by tfsat-host bundle 0.2.0)." in words
    assert "Differences may come from the program, not from the data" in words
    assert len(output.out.splitlines()) <= 40


def test_another_recording_gives_other_numbers(bundle: Path) -> None:
    """Report differing numbers for another recording, although its hashes are right."""

    def zero_middle_block(files: dict[str, bytes]) -> None:
        blocks = files["run/SD.bin"]
        # One block in the middle, on a multiple of 512 bytes, as a card loses them.
        middle = len(blocks) // 1024 * 512
        files["run/SD.bin"] = blocks[:middle] + bytes(512) + blocks[middle + 512 :]

    rewrite(bundle, zero_middle_block)
    reproduction = result("reproduce", bundle, expect=3)
    assert any(
        difference["key"].startswith("recording.samples")
        for difference in reproduction["compared"][0]["differences"]
    )


def test_a_changed_file_is_refused_by_name(bundle: Path) -> None:
    def change(files: dict[str, bytes]) -> None:
        # One degree less commanded: the strokes would look too large.
        files["run/maneuver.toml"] = files["run/maneuver.toml"].replace(b"59.0", b"58.0")

    rewrite(bundle, change, hashes=False)
    output = command("reproduce", bundle, expect=1)
    assert "run/maneuver.toml" in output.err and "Nothing was unpacked" in output.err
    assert not Path("run-reproduced").exists()


# Empty, another type, no UTF-8, nested beyond the recursion limit, and a number that becomes infinite.
@pytest.mark.parametrize("name", ["evaluation.json", "environment.json", "report.html"])
@pytest.mark.parametrize("data", [b"", b"[]", b"\xff", b"[" * 100_000, b'{"packages": [1], "k": 1e999}'])
def test_parts_that_nobody_would_write_are_differences_and_no_crash(
    bundle: Path, fixed_evaluation: Computed, name: str, data: bytes
) -> None:
    fixed_evaluation(None)
    if name == "report.html":
        data = b'<script type="application/json" id="document">' + data + b"</script>"
    rewrite(bundle, lambda files: files.update({name: data}))
    assert result("reproduce", bundle, expect=3)["same"] is False
    command("reproduce", bundle, "--out", "again", expect=3)


@pytest.mark.parametrize("data", [None, b"", b"\xff", b"[" * 100_000])
def test_an_evaluation_that_is_none_is_named_in_words(
    bundle: Path, fixed_evaluation: Computed, data: bytes | None
) -> None:
    fixed_evaluation(None)
    name = "evaluation.json"
    rewrite(bundle, lambda files: files.pop(name) if data is None else files.update({name: data}))
    (difference,) = result("reproduce", bundle, expect=3)["compared"][0]["differences"]
    assert (difference["key"], difference["recomputed"]) == (name, "an evaluation")
    words = command("reproduce", bundle, "--out", "again", expect=3).words
    expected = "The bundle has no evaluation" if data is None else "The bundled evaluation cannot be read"
    assert expected in words
    assert "None" not in words


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("report.html", "it can be made again"),
        ("run/notes.txt", "The raw log run/SD.bin is whole"),
        ("run/SD.bin", "decode uses every block of it that is whole"),
    ],
)
def test_a_flipped_bit_leaves_what_is_still_good(bundle: Path, name: str, expected: str) -> None:
    data = bytearray(bundle.read_bytes())
    with zipfile.ZipFile(bundle) as opened:
        # Past the 30 bytes of the local header and the name, into the stored content.
        at = opened.getinfo(name).header_offset + 30 + len(name) + 10
    data[at] ^= 0x10
    bundle.write_bytes(data)
    output = command("reproduce", bundle, expect=1)
    err = " ".join(output.err.split())
    assert f"1 of 11 files in {bundle} is not what its manifest says: {name}." in err
    assert expected in err and "Nothing was unpacked." in err
    assert f"unzip {bundle} -d rescued" in err and "tfsat-host bundle rescued/run" in err
    assert not Path("run-reproduced").exists()


def test_changed_evidence_is_named(bundle: Path) -> None:
    def change(files: dict[str, bytes]) -> None:
        # Other firmware of the sequencer than the one that was checked and signed.
        files["run/preflight.json"] = files["run/preflight.json"].replace(b"1a2b", b"1a2c")

    rewrite(bundle, change)
    output = command("reproduce", bundle, expect=3)
    assert (output.result["same"], output.result["complete"]) == (True, False)
    assert output.words.startswith("REPRODUCED IN PART: 1 changed; identical: evaluation (")
    assert "preflight.json was changed" in output.words


def test_what_was_changed_before_it_was_bundled_stays_named(quick_run: Path) -> None:
    """Also by a bundle from which the record was taken out."""
    (quick_run / "preflight.json").write_text("{}")
    command("bundle", "run", expect=3)
    # Without the record nothing can be verified: the manifest still says what was found then.
    rewrite(ARCHIVE, lambda files: files.pop("run/record.json"))
    reproduction = result("reproduce", ARCHIVE, expect=3)
    assert reproduction["complete"] is False and "preflight.json was changed" in reproduction["record"][0]


def test_a_drop_whose_evaluation_is_refused_is_not_whole(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused in the same words then and now."""

    def refuse(*_: Any, **__: Any) -> None:
        raise TfsatError(what="It ends at the release.", meaning="Nothing.", next_step="Another one.")

    del run
    monkeypatch.setattr(drop_evaluation, "evaluate_run", refuse)
    command("bundle", "run", expect=3)
    reproduction = result("reproduce", ARCHIVE, expect=3)
    # The same refusal twice is the same result, and still no evaluated drop.
    assert (reproduction["same"], reproduction["complete"]) == (True, False)
    assert "It ends at the release." in reproduction["compared"][0]["sentence"]
    words = command("reproduce", ARCHIVE, "--out", "again", expect=3).words
    assert words.startswith("REPRODUCED IN PART: evaluation refused, 1 lost")
    assert "Evaluation: The drop cannot be evaluated, now as then: It ends at the release." in words
    assert words.count("Lost: report.html: ") == 1 and "identical" not in words


def calibration_in(reproduction: Any) -> Any:
    return next(comparison for comparison in reproduction["compared"] if comparison["what"] == "calibration")


def test_a_certificate_is_computed_from_its_recordings(calibrated_run: Path) -> None:
    """Recompute a certificate from its recordings.

    A landing noted later did not change it, though it lies before the last step.
    """
    # One landing among the recordings, one long after: the values tell which was known.
    between = record_good_step(REST).recorded_at + timedelta(seconds=30)
    note_landing(calibrated_run / CERTIFICATE, Landing(between, "recording 0000abcd"))
    note_landing(calibrated_run / CERTIFICATE, Landing(between + timedelta(days=300), "recording 0000abce"))
    summary = result("bundle", "run")
    recordings = [name for name in summary["files"] if name.startswith(f"run/{RECORDINGS}")]
    assert sum(name.endswith(".npz") for name in recordings) == len(STEPS)
    assert "raw data of the calibration" not in {entry["what"] for entry in summary["missing"]}
    summary = result("reproduce", ARCHIVE)
    assert (summary["same"], summary["complete"], summary["incomplete"]) == (True, True, [])
    again = calibration_in(summary)
    assert again["differences"] == [] and "recomputed from 3 recordings" in again["sentence"]


def test_values_that_the_recordings_do_not_give_are_named(calibrated_run: Path) -> None:
    calibration = read_calibration(calibrated_run / CERTIFICATE)
    # 1e-4 rad/s: 0.014 deg over the 2.5 s of a fall, and not what the recordings give.
    bias = calibration.gyros[1].bias_rad_s + np.array([0.0, 1e-4, 0.0])
    gyros = (calibration.gyros[0], replace(calibration.gyros[1], bias_rad_s=bias), *calibration.gyros[2:])
    (calibrated_run / CERTIFICATE).write_text(format_calibration(replace(calibration, gyros=gyros)))
    result("bundle", "run")
    differs = calibration_in(result("reproduce", ARCHIVE, expect=3))["differences"]
    assert [difference["key"] for difference in differs] == ["gyro[1].bias.value[1]"]


def test_recordings_that_are_gone_or_changed_are_lost(calibrated_run: Path) -> None:
    rest, zero = (read_calibration(calibrated_run / CERTIFICATE).recordings[i].file for i in (0, 1))
    # A good recording of another step under this one's name.
    (calibrated_run / RECORDINGS / zero).write_bytes(to_bytes(record_good_step(SWINGS[0])))
    lost = {entry["what"] for entry in result("bundle", "run", expect=3)["missing"] if entry["lost"]}
    assert lost == {f"run/{RECORDINGS}/{zero}"}
    reproduction = result("reproduce", ARCHIVE, expect=3)
    assert (reproduction["same"], reproduction["complete"]) == (True, False)
    assert any(zero in sentence for sentence in reproduction["incomplete"])
    words = command("reproduce", ARCHIVE, "--out", "again", expect=3).words
    assert words.startswith("REPRODUCED IN PART: 1 not computed, 1 lost; identical: evaluation")
    assert "Reproduced identically" not in words
    # Then one that is not there at all.
    (calibrated_run / RECORDINGS / rest).unlink()
    lost = {entry["what"] for entry in result("bundle", "run", expect=3)["missing"] if entry["lost"]}
    assert lost == {f"run/{RECORDINGS}/{rest}", f"run/{RECORDINGS}/{zero}"}
    again = calibration_in(result("reproduce", ARCHIVE, "--out", "third", expect=3))
    assert again["differences"] is None and rest in again["sentence"]


def test_a_recording_that_was_changed_in_the_bundle_does_not_pass(calibrated_run: Path) -> None:
    """Reject a recording changed in the bundle, even with a matching manifest.

    The certificate names the recording by its hash.
    """
    del calibrated_run
    result("bundle", "run")

    def change(files: dict[str, bytes]) -> None:
        name = next(name for name in files if "zero" in name and name.endswith(".npz"))
        files[name] = to_bytes(replace(record_good_step(ZERO), tool_version="another"))

    rewrite(ARCHIVE, change)
    reproduction = result("reproduce", ARCHIVE, expect=3)
    assert (reproduction["same"], reproduction["complete"]) == (True, False)
    again = calibration_in(reproduction)
    assert again["differences"] is None and "SHA-256 differs" in again["sentence"]
