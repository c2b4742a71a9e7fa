"""A run as a program has it: the same as the commands, without their files, words and exit codes."""

from __future__ import annotations

import json
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.run_folder import CERTIFICATE, run_folder
from tests.run.bundle.commands import command, keep_evaluations
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.evaluation.verdict import VERDICT
from tfsat_host.quantity import json_objects, record
from tfsat_host.robot import default_robot_path
from tfsat_host.run import EvaluationOptions, Run
from tfsat_host.run.bundle.reproducing import reproduce
from tfsat_host.run.campaign import adding, campaign_folder
from tfsat_host.run.campaign import campaign_report as reporting
from tfsat_host.run.certificate_check import CERTIFICATE_STATE
from tfsat_host.run.drop_comparison import Comparison, Refused, evaluate_several
from tfsat_host.run.files import command_options


class MessageList:
    """Keeps what is said on the way."""

    def __init__(self) -> None:
        self.messages: list[str] = []

    def note(self, text: str) -> None:
        self.messages.append(text)

    warn = note

    def progress(self, description: str, total: float | None = None) -> AbstractContextManager[Any]:
        del total
        self.messages.append(description)
        return nullcontext(lambda _: None)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a whole drop in the folder `run` of the current folder."""
    keep_evaluations(monkeypatch)
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    return Path("run")


def test_a_run_gives_what_the_command_gives(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    listener = MessageList()
    evaluation = Run.open(run, EvaluationOptions(swarm=True)).evaluate(listener)
    assert capsys.readouterr() == ("", ""), "a library prints nothing"
    assert (
        any("knows of the landing" in message for message in listener.messages)
        and "Evaluating run" in listener.messages
    )
    # The library notes the landing as the command does: a certificate ends with it.
    assert read_calibration(run / CERTIFICATE).landings
    result = command("evaluate", run, "--swarm").result
    assert result["verdict"] == json.loads(json.dumps(record(VERDICT, evaluation.verdict)))
    assert result["calibration"] == json_objects(CERTIFICATE_STATE, evaluation.held and evaluation.held.state)
    assert result["swarm"]["particles"] == 48


def test_options_of_one_drop_and_files_that_are_not_there_are_refused(run: Path) -> None:
    with pytest.raises(UsageError, match="--facility permits"):
        Run.open(run, EvaluationOptions(facility=Path("tower.toml")))
    with pytest.raises(TfsatError, match="no file or folder nowhere"):
        Run.open("nowhere")
    with pytest.raises(UsageError, match="--session belongs to one drop"):
        evaluate_several([run, Path("other")], EvaluationOptions(session=1))


def test_a_bundle_is_the_commands_and_gives_itself_again(run: Path) -> None:
    bundle = Run.open(run).bundle("here.zip")
    command("bundle", run, "--out", "there.zip")
    assert Path("here.zip").read_bytes() == Path("there.zip").read_bytes()
    again = reproduce(bundle.target, "again")
    assert (again.same, again.incomplete) == (True, [])
    # The hash in the logbook vouches for every file of the bundle.
    assert again.manifest_sha256 == bundle.manifest_sha256
    with pytest.raises(TfsatError, match="not empty"):
        reproduce(bundle.target, "again")


def test_a_campaign_compares_its_drops(run: Path, tmp_path: Path) -> None:
    run_folder(tmp_path / "second", seed=2)
    folder = Path("season")
    campaign_folder.init(folder)
    assert adding.add(folder, run, note="calm").entry.number == 1
    assert adding.add(folder, Path("second"), move=True).moved
    with pytest.raises(TfsatError, match="A note is one line"):
        campaign_folder.note(folder, 1, "two\nlines")
    campaign_report = reporting.report(folder)
    (robot,) = campaign_report.robots
    assert (
        campaign_report.good
        and campaign_report.page == folder / "report.html"
        and campaign_report.page.is_file()
    )
    assert robot.numbers == (1, 2) and isinstance(robot.compared, Comparison)


def test_several_drops_are_evaluated_or_refused_each(run: Path) -> None:
    Path("broken").mkdir()
    # 1200 bytes without a block: one unreadable drop must not cost the others.
    Path("broken/SD.bin").write_bytes(b"no recording" * 100)
    good, refused = evaluate_several([run, Path("broken")], EvaluationOptions())
    assert not isinstance(good, Refused) and good.verdict.level == "good"
    assert isinstance(refused, Refused) and refused.verdict.level == "failed"
    assert Comparison.of([good]) is None


def test_what_is_missing_is_measured_with_the_robot_of_the_run(run: Path) -> None:
    """The shipped robot needs no name; a smaller one would be measured for parts that it has not."""
    measured = ("--out", str(run / CERTIFICATE))
    (run / "robot.toml").write_bytes(default_robot_path().read_bytes())
    assert command_options(run / CERTIFICATE, emulated=False) == measured
    (run / "robot.toml").write_text("another", encoding="utf-8")
    assert command_options(run / CERTIFICATE, emulated=False) == (*measured, "--robot", "run/robot.toml")
