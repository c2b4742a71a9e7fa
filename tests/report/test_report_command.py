"""`tfsat-host report`: which files it writes, which it leaves alone, and what it says."""

from __future__ import annotations

import contextlib
import hashlib
import io
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser

from tests.cli.process import RunCli
from tests.evaluation.commanded import Said
from tests.evaluation.run_folder import CERTIFICATE, run_folder
from tests.report.opened import Opened
from tfsat_host.cli.main import main
from tfsat_host.report.figures import files as figure_files
from tfsat_host.run.files import names_of
from tfsat_host.run.reporting import PAGE_MARKER
from tfsat_host.sdlog import errors as extras

FIGURES = {
    f"{name}.{kind}"
    for name in ("motion", "momentum", "rate-error", "attitude-error")
    for kind in ("pdf", "png")
}


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A whole drop in the folder `run` of the current one."""
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    return tmp_path / "run"


def report(*args: object) -> Said:
    """Runs the command in the current folder, in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(["report", *map(str, args)])
    said = Said(code, out.getvalue(), err.getvalue())
    assert "Traceback" not in said.err and "a bug of its own" not in said.out + said.err, said
    return said


def test_page_lies_beside_the_recording_and_is_made_again(run: Path) -> None:
    said = report("run")
    page = run / "report.html"
    assert (said.code, said.out.splitlines()[-1]) == (0, "Written  run/report.html")
    assert said.out.startswith("run: GOOD. ")
    assert PAGE_MARKER in page.read_bytes()[:4096]
    page.write_bytes(page.read_bytes().replace(b"<noscript>", b"<noscript>old "))
    assert report("run").code == 0  # its own page it may replace
    assert b"<noscript>old" not in page.read_bytes()


def test_a_file_of_somebody_else_is_kept(run: Path) -> None:
    (run / "report.html").write_text("<p>my notes</p>", encoding="utf-8")
    said = report("run")
    assert said.code == 1 and "report.html exists and was not made by this command" in said.err
    assert (run / "report.html").read_text(encoding="utf-8") == "<p>my notes</p>"
    assert "Evaluating" not in said.err  # it was refused before anything took time
    assert report("run", "--out", "other.html").code == 0
    assert report("run", "--force").code == 0
    assert PAGE_MARKER in (run / "report.html").read_bytes()


def test_figures_and_mcap(run: Path) -> None:
    said = report("run", "--figures", "figures", "--mcap", "--json")
    assert said.code == 0, said.err
    assert {path.name for path in Path("figures").iterdir()} == FIGURES
    result = said.json
    assert result["report"] == "run/report.html"
    assert set(result["files"]) == {
        "run/report.html",
        "run/SD.evaluated.mcap",
        *(f"figures/{name}" for name in FIGURES),
    }
    assert all(Path(file).stat().st_size > 0 for file in result["files"])
    [drop] = result["drops"]
    assert (drop["name"], drop["run"], drop["verdict"]["level"]) == ("run", "run", "good")


def test_mcap_where_it_is_told_to(run: Path) -> None:
    (run / "mine.mcap").write_text("not yours", encoding="utf-8")
    refused = report("run", "--mcap=run/mine.mcap")
    assert refused.code == 1 and "mine.mcap exists" in refused.err
    assert not (run / "report.html").exists()
    assert report("run", "--mcap=out/drop.mcap").code == 0
    assert Path("out/drop.mcap").stat().st_size > 100_000


def test_doubts_end_with_3(run: Path) -> None:
    (run / CERTIFICATE).unlink()
    said = report("run", "--json")
    assert said.code == 3
    verdict = said.json["drops"][0]["verdict"]
    assert verdict["level"] == "doubtful" and any("no calibration" in reason for reason in verdict["reasons"])
    page = (run / "report.html").read_text(encoding="utf-8")
    assert verdict["sentence"] in page and "There is no calibration" in page


def test_several_drops_lie_in_one_page_here(run: Path) -> None:
    run_folder(Path("second"), seed=2)
    said = report("run", "second", "--figures", "figures", "--mcap", "--json")
    assert said.code == 0, said.err
    assert said.json["report"] == "report.html"
    assert [drop["name"] for drop in said.json["drops"]] == ["run", "second"]
    assert {path.name for path in Path("figures/second").iterdir()} == FIGURES
    assert Path("second/SD.evaluated.mcap").exists() and Path("run/SD.evaluated.mcap").exists()
    refused = report("run", "second", "--mcap=one.mcap")
    assert refused.code == 2 and "--mcap names one file" in refused.err


def test_a_drop_that_cannot_be_evaluated_does_not_cost_the_others(run: Path) -> None:
    Path("empty").mkdir()
    said = report("run", "empty", "--json")
    assert said.code == 1
    assert [drop["name"] for drop in said.json["drops"]] == ["run"]
    [refused] = said.json["refused"]
    assert refused["run"] == "empty" and "empty holds no recording" in refused["what"]
    assert "empty is not in the report" in said.err
    page = Path("report.html").read_text(encoding="utf-8")
    assert "<p>empty could not be evaluated: empty holds no recording" in page
    assert '"lacking":["empty could not' in page


def test_several_drops_say_what_they_find_together(run: Path, browser: Browser) -> None:
    run_folder(Path("second"), seed=2)
    Path("empty").mkdir()
    assert report("run", "second", "empty").code == 1
    opened = Opened(browser.new_page(), Path("report.html").resolve())
    page = opened.page
    assert "empty holds no recording" in page.locator(".lacking").inner_text()
    together = page.locator(".tables .table", has_text="by all drops together")
    assert together.locator("thead th").all_inner_texts() == ["what", "unit", "all drops", "run", "second"]
    assert together.locator("tbody tr").count() == 9
    judged = page.locator(".tables .table", has_text="Each drop by the corrections of the others")
    assert [row.locator("th").inner_text() for row in judged.locator("tbody tr").all()] == ["run", "second"]
    assert "better in 2 of 2 drops" in judged.inner_text()
    assert opened.complaints == []
    page.close()


def test_provenance_names_all_that_was_read(run: Path) -> None:
    (run / "laser.csv").write_text(
        "t_s,spot,along_mm,up_mm\n"
        + "".join(
            f"{t:.2f},{spot},0.0,{300 - 26 * t:.3f}\n" for t in (0.2, 0.3, 0.4, 0.5, 0.6) for spot in (1, 2)
        ),
        encoding="utf-8",
    )
    assert report("run", "--laser", "run/laser.csv").code in (0, 3)
    page = (run / "report.html").read_text(encoding="utf-8")
    for name in ("laser.csv", "maneuver.toml", CERTIFICATE):
        digest = hashlib.sha256((run / name).read_bytes()).hexdigest()
        assert f"run/{name}, SHA-256 {digest}" in page, name
    assert '["options","--laser run/laser.csv"]' in page


def test_nothing_to_report(run: Path) -> None:
    Path("empty").mkdir()
    alone = report("empty")
    assert alone.code == 1 and "empty holds no recording" in alone.err
    Path("hollow").mkdir()
    both = report("empty", "hollow")
    assert both.code == 1 and "None of the drops can be evaluated." in both.err
    assert not Path("report.html").exists()


@pytest.mark.parametrize("asked", ["--figures", "--mcap"])
def test_missing_extra_is_told_before_anything_is_evaluated(
    asked: str, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figure_files, "MODULE", "a_module_that_nobody_has")
    monkeypatch.setitem(extras.MODULES, "mcap", ("a_module_that_nobody_has",))
    said = report("run", f"{asked}=somewhere")
    extra = asked.removeprefix("--")
    assert said.code == 1 and f"python -m pip install '.[{extra}]'" in said.err
    assert "Evaluating" not in said.err and not (run / "report.html").exists()


def test_names_of_drops_differ() -> None:
    assert names_of([Path("a/SD.bin"), Path("b/a/SD.bin"), Path("b/DROP0002.BIN")]) == [
        "a",
        "a (2)",
        "DROP0002",
    ]


def test_the_page_of_the_command_opens(run: Path, browser: Browser) -> None:
    hostile = run.with_name("<img src=x onerror=alert(1)>")
    run.rename(hostile)
    said = report(hostile.name, "--json")
    assert said.code == 0, said.err
    opened = Opened(browser.new_page(), hostile / "report.html")
    assert hostile.name in opened.page.inner_text("h1")
    assert opened.page.locator("img").count() == 0
    assert opened.complaints == [] and opened.requests == [opened.address]
    opened.page.close()


def test_as_a_process(tfsat_host: RunCli) -> None:
    run_folder(tfsat_host.folder / "run")
    result: Any = tfsat_host.json("report", "run/SD.bin", "--out", "page.html")
    assert result["files"] == ["page.html"]
    assert result["drops"][0]["name"] == "run"
