"""Words that do not exist: what may have been meant, and what there is."""

from __future__ import annotations

import pytest

from tests.cli.process import RunCli


@pytest.mark.parametrize(
    ("line", "what", "next_step"),
    [
        ("evalute run", "There is no command 'evalute'.", "Did you mean: tfsat-host evaluate run"),
        ("zzz", "There is no command 'zzz'.", "tfsat-host --help lists all commands."),
        (
            "evaluate --calibratin x",
            "tfsat-host evaluate has no option --calibratin.",
            "Did you mean --calibration? All options: tfsat-host evaluate --help",
        ),
        (
            "rehearse --fualt servo-dead",
            "tfsat-host rehearse has no option --fualt.",
            "Did you mean --fault? All options: tfsat-host rehearse --help",
        ),
        (
            "log fetch all --prot=x",
            "tfsat-host log fetch has no option --prot.",
            "Did you mean --port? All options: tfsat-host log fetch --help",
        ),
        (
            "--vers",
            "tfsat-host has no option --vers.",
            "Did you mean --version? All options: tfsat-host --help",
        ),
        (
            "log lst",
            "tfsat-host log: there is no action 'lst'.",
            "Did you mean list? There is: list, fetch, erase",
        ),
        (
            "flash microwave",
            "tfsat-host flash: there is no board 'microwave'.",
            "There is: sequencer, logger",
        ),
    ],
)
def test_what_does_not_exist_is_named_with_what_may_have_been_meant(
    tfsat_host: RunCli, line: str, what: str, next_step: str
) -> None:
    done = tfsat_host(*line.split(), expect=2)
    assert done.stdout == ""
    assert done.stderr.splitlines()[0] == f"Error: {what}"
    assert done.stderr.splitlines()[-1].strip() == next_step


@pytest.mark.parametrize(
    ("command", "actions"),
    [
        ("log", ["list", "fetch", "erase"]),
        ("record", ["start", "stop"]),
        ("campaign", ["init", "add", "list", "note", "void", "next", "report"]),
    ],
)
def test_a_command_without_its_action_lists_them(
    tfsat_host: RunCli, command: str, actions: list[str]
) -> None:
    done = tfsat_host(command, expect=2)
    lines = [line.split() for line in done.stderr.splitlines()[2:]]
    assert [words[:3] for words in lines] == [["tfsat-host", command, action] for action in actions]
    assert all(len(words) > 5 for words in lines), "what each is for"
