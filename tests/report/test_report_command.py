"""`tfsat-host report`: which files it writes, which it leaves alone, and what it says."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.cli.process import RunCli
from tests.evaluation.run_folder import CERTIFICATE, run_folder
from tests.report.opened import Opened
from tests.run.bundle.commands import command, keep_evaluations, result
from tfsat_host.report import figures as figure_files
from tfsat_host.report.figures import FORMATS
from tfsat_host.report.foxglove_export import MARKER
from tfsat_host.run import drop_report
from tfsat_host.run.drop_report import PAGE_MARKER
from tfsat_host.run.files import EVALUATION_MARKER, REHEARSED, names_of
from tfsat_host.sdlog import log_errors as extras

DRAWN = "rate-error"
HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a whole drop in the folder `run` of the current folder.

    Figures and recordings are replaced by markers: only their places are tested.
    """
    keep_evaluations(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(drop_report, "FIGURES", {DRAWN: None})
    for write in ("write_evaluated_mcap", "write_figure"):
        monkeypatch.setattr(drop_report, write, lambda *arguments: arguments[-1].write_bytes(MARKER))
    run_folder(tmp_path / "run")
    return tmp_path / "run"


def test_the_page_lies_beside_the_recording_and_is_made_again(run: Path) -> None:
    summary = result("report", "run", "--figures", "figures", "--mcap")
    page = run / "report.html"
    assert PAGE_MARKER in page.read_bytes()[:4096]
    figures = [f"figures/{DRAWN}.{kind}" for kind in FORMATS]
    assert (summary["report"], summary["files"]) == (
        "run/report.html",
        ["run/report.html", *figures, "run/SD.evaluated.mcap"],
    )
    assert all(Path(file).stat().st_size > 0 for file in summary["files"])
    [drop] = summary["drops"]
    assert (drop["name"], drop["run"], drop["verdict"]["level"]) == ("run", "run", "good")
    page.write_bytes(page.read_bytes().replace(b"<noscript>", b"<noscript>old "))
    words = command("report", "run/SD.bin", "--mcap=out/drop.mcap").out  # its own page it may replace
    assert b"<noscript>old" not in page.read_bytes()
    assert words.startswith("GOOD: ") and "(run)" not in words and Path("out/drop.mcap").is_file()
    assert words.splitlines()[-2:] == ["Report: run/report.html", "Also written: out/drop.mcap"]


def test_a_file_of_somebody_else_is_kept_without_force_and_doubts_end_with_3(run: Path) -> None:
    page, mcap = run / "report.html", run / "mine.mcap"
    page.write_text("<p>my notes</p>", encoding="utf-8")
    output = command("report", "run", expect=1)
    assert "report.html exists and was not made by this command" in output.err
    assert page.read_text(encoding="utf-8") == "<p>my notes</p>"
    assert "Evaluating" not in output.err  # it was refused before anything took time
    mcap.write_text("not yours", encoding="utf-8")
    assert "mine.mcap exists" in command("report", "run", "--mcap=run/mine.mcap", "--out", "a", expect=1).err
    assert not Path("a").exists()
    # Without a calibration the drop is doubtful, and its page is written all the same.
    (run / CERTIFICATE).unlink()
    verdict = result("report", "run", "--force", expect=3)["drops"][0]["verdict"]
    assert verdict["level"] == "doubtful" and any("no calibration" in reason for reason in verdict["reasons"])
    text = page.read_text(encoding="utf-8")
    assert verdict["sentence"] in text and "There is no calibration" in text


def test_several_drops_lie_in_one_page_here_but_one_that_cannot_be_evaluated(
    run: Path, browser: Browser
) -> None:
    run_folder(Path("second"), seed=2)
    Path("empty").mkdir()
    output = command("report", "run", "second", "empty", "--figures", "figures", "--mcap", "--json", expect=1)
    assert output.json["report"] == "report.html"
    assert [drop["name"] for drop in output.json["drops"]] == ["run", "second"]
    assert Path(f"figures/second/{DRAWN}.pdf").exists() and Path(f"figures/run/{DRAWN}.png").exists()
    assert Path("second/SD.evaluated.mcap").exists() and Path("run/SD.evaluated.mcap").exists()
    [refused] = output.json["refused"]
    assert refused["run"] == "empty" and "empty holds no recording" in refused["what"]
    assert "empty is not in the report" in output.err
    text = Path("report.html").read_text(encoding="utf-8")
    assert "<p>empty could not be evaluated: empty holds no recording" in text
    assert '"lacking":["empty could not' in text
    opened = Opened(browser.new_page(), Path("report.html").resolve())
    page = opened.page
    assert "empty holds no recording" in page.locator(".lacking").inner_text()
    together = page.locator(".tables .table", has_text="by all drops together")
    assert together.locator("thead th").all_inner_texts() == ["what", "unit", "all drops", "run", "second"]
    # Three coordinates of the centers of mass of bodies 1 to 3.
    assert together.locator("tbody tr").count() == 9
    judged = page.locator(
        ".tables .table", has_text="Cross-validation: each drop with the corrections of the others"
    )
    assert [row.locator("th").inner_text() for row in judged.locator("tbody tr").all()] == ["run", "second"]
    assert "better in 2 of 2 drops" in judged.inner_text()
    assert opened.complaints == []
    page.close()


def test_provenance_names_all_that_was_read_and_a_hostile_name_is_text(run: Path, browser: Browser) -> None:
    run.rename(HOSTILE)
    spots = (f"{t:.2f},{spot},0.0,{300 - 26 * t:.3f}\n" for t in (0.2, 0.3, 0.4, 0.5, 0.6) for spot in (1, 2))
    laser = Path(HOSTILE, "laser.csv")
    laser.write_text(f"t_s,spot,along_mm,up_mm\n{''.join(spots)}", encoding="utf-8")
    page = Path("new/deep/report.html")
    output = command("report", HOSTILE, "--laser", laser, "--out", page, expect=3)
    assert "The folder new/deep was not there: it was made." in output.err
    opened = Opened(browser.new_page(), page.resolve())
    assert HOSTILE in opened.page.inner_text("h1")
    provenance = opened.page.locator(".table", has_text="SHA-256 of the recording").text_content() or ""
    for name in ("laser.csv", "maneuver.toml", CERTIFICATE):
        digest = hashlib.sha256(Path(HOSTILE, name).read_bytes()).hexdigest()
        assert f"{HOSTILE}/{name}, SHA-256 {digest}" in provenance, name
    assert f"--laser {laser}" in provenance
    assert opened.page.locator("img").count() == 0
    assert opened.complaints == [] and opened.requests == [opened.address]
    opened.page.close()


def test_what_is_refused_before_anything_is_evaluated(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("empty", "hollow", "there"):
        Path(name).mkdir()
    assert "empty holds no recording" in command("report", "empty", expect=1).err
    both = command("report", "empty", "hollow", expect=1)
    assert "None of the drops can be evaluated." in both.err
    single_output = command("report", "run", "empty", "--mcap=one.mcap", expect=2)
    assert "--mcap names one file" in single_output.err
    for name in ("dirx/", "dirx/.", "there/"):
        output = command("report", "run", "--out", name, expect=2)
        assert f"'{name}' is a folder" in output.err and f"{name.rstrip('.')}NAME" in output.err
        assert "is a folder" in command("campaign", "report", "camp", "--out", name, expect=2).err
    for option in ("--figures", "--mcap"):
        # The way to the files leads through a file.
        output = command("report", "run", f"{option}={Path('run/SD.bin/x')}", expect=1)
        assert f"Name another place with {option}." in output.err and "--out" not in output.err
    # As in an installation without these extras.
    monkeypatch.setattr("tfsat_host.plotting.MODULE", "a_module_that_nobody_has")
    monkeypatch.setitem(extras.MODULES, "mcap", ("a_module_that_nobody_has",))
    for extra in ("figures", "mcap"):
        output = command("report", "run", f"--{extra}=somewhere", expect=1)
        assert f"python -m pip install 'tfsat-host[{extra}]'" in output.err and "Evaluating" not in output.err
    assert sorted(path.name for path in Path().iterdir()) == ["empty", "hollow", "run", "there"]
    assert not (run / "report.html").exists()


def test_names_of_drops_differ() -> None:
    names = names_of([Path("a/SD.bin"), Path("b/a/SD.bin"), Path("b/DROP0002.BIN")])
    assert names == ["a", "a (2)", "DROP0002"]


def test_a_rehearsal_removes_the_results_of_the_recording_that_it_replaces(tfsat_host: RunCli) -> None:
    run = tfsat_host.folder / "run"
    run_folder(run)
    names = sorted(path.name for path in run.iterdir())
    (run / REHEARSED).write_text("\n".join(["made by tfsat-host rehearse", *names]) + "\n", encoding="utf-8")
    (run / "figures").mkdir()
    (run / "figures" / "motion.png").write_bytes(figure_files.MARKER)
    (run / "SD.evaluated.mcap").write_bytes(MARKER)
    (run / "evaluation.json").write_bytes(EVALUATION_MARKER)
    (run / "notes.txt").write_text("mine", encoding="utf-8")
    again = tfsat_host("rehearse", "59", "70", "--seed", "2", "--out", "run")
    file_names = {path.name for path in run.iterdir()}
    assert not file_names & {"evaluation.json", "SD.evaluated.mcap"}, "the page is the new recording's own"
    assert "figures" not in file_names, "a folder that this leaves empty goes, too"
    assert {"notes.txt", "SD.bin", "summary.json"} <= file_names
    assert "evaluation.json: it was made of the recording that this one replaces" in again.stderr
