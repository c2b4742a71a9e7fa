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
    process = tfsat_host(*line.split(), expect=2)
    assert process.stdout == ""
    assert process.stderr.splitlines()[0] == f"Error: {what}"
    assert process.stderr.splitlines()[-1].strip() == next_step


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
    process = tfsat_host(command, expect=2)
    lines = [line.split() for line in process.stderr.splitlines()[2:]]
    assert [words[:3] for words in lines] == [["tfsat-host", command, action] for action in actions]
    assert all(len(words) > 5 for words in lines), "what each is for"


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("simulate", "--file", "tower.toml"), "tower.toml is a robot file, no maneuver file."),
        (("simulate", "--file", "calibration.toml"), "calibration.toml is a certificate, no maneuver file."),
        (("simulate", "--file", "SD.csv"), "SD.csv is a table, no maneuver file."),
        (("simulate", "--file", "SD.bin"), "SD.bin is a recording, no maneuver file."),
        (
            ("simulate", "59", "70", "--robot", "maneuver.toml"),
            "maneuver.toml is a maneuver file, no robot file.",
        ),
        (("bundle", "SD.csv"), "SD.csv is what decode made of a recording, not the recording itself."),
        (("evaluate", "SD.csv"), "SD.csv is what decode made of a recording, not the recording itself."),
    ],
)
def test_a_file_of_another_kind_is_named_as_what_it_is(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], what: str
) -> None:
    folder = tfsat_host.folder
    for name, content in (
        ("tower.toml", b"format = 1\ninertia_off_diagonals = 'tensor'\n"),
        ("calibration.toml", b"format = 9\nwho_am_i = '68'\n"),
        ("maneuver.toml", b"schema = 1\nstrokes = []\n"),
        ("SD.csv", b"t_s,x\n0,1\n"),
        ("SD.bin", b"\xff\xfe\x00"),
    ):
        (folder / name).write_bytes(content)
    monkeypatch.chdir(folder)
    process = tfsat_host(*arguments, expect=1)
    assert f"Error: {what}" in process.stderr.splitlines()
    if "SD.csv" in arguments[1:2]:
        assert process.stderr.splitlines()[-1] == f"  tfsat-host {arguments[0]} SD.bin"
        assert not list(folder.glob("*.zip"))
