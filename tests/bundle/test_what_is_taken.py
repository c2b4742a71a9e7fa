"""What `bundle` takes from a run's folder: files that lie there, and nothing that a link or a pipe would bring in."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.bundle.commands import command, result
from tests.evaluation.run_folder import CERTIFICATE
from tfsat_host.run.record import sign


@pytest.fixture
def quick(run: Path) -> Path:
    """A run whose recording cannot be evaluated: that would take its time."""
    (run / "SD.bin").write_bytes(b"no recording" * 100)
    return run


def test_links_and_pipes_are_left_out_by_name(quick: Path, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("of somebody else")
    (quick / "outside.txt").symlink_to(tmp_path / "secret.txt")
    (quick / "inside.txt").symlink_to("notes.txt")
    (quick / "nowhere.txt").symlink_to("gone.txt")
    (quick / "round.txt").symlink_to("round.txt")
    (quick / "loop").symlink_to(".")
    os.mkfifo(quick / "pipe.txt")
    said = result("bundle", "run", expect=3)
    left_out = said["left_out"]
    assert left_out["outside.txt"] == f"is a link that leads out of the folder, to {tmp_path / 'secret.txt'}"
    assert left_out["nowhere.txt"] == left_out["round.txt"] == "is a link that leads nowhere"
    assert left_out["loop"] == "is a link to a folder"
    assert left_out["pipe.txt"] == "is a pipe"
    assert {"run/notes.txt", "run/inside.txt"} <= said["files"].keys()
    assert not any("secret" in name or "outside" in name for name in said["files"])
    assert "outside.txt is a link that leads out of the folder" in command("bundle", "run", expect=3).words


@pytest.mark.parametrize("name", ["SD.bin", "maneuver.toml", CERTIFICATE])
def test_a_file_that_counts_and_lies_elsewhere_has_to_be_named(
    quick: Path, tmp_path: Path, name: str
) -> None:
    (quick / name).rename(tmp_path / f"other-{name}")
    (quick / name).symlink_to(tmp_path / f"other-{name}")
    said = command("bundle", "run", expect=1)
    assert f"run/{name} is a link that leads out of the folder" in said.err.replace("\n", " ")
    assert not Path("run.tfsat.zip").exists()
    option = {"maneuver.toml": ("--maneuver",), CERTIFICATE: ("--calibration",)}.get(name)
    given = ("run", *option, f"run/{name}") if option else (f"run/{name}",)
    command("bundle", *given, "--out", "named.zip", expect=3)


def test_a_signed_file_behind_a_link_is_lost(quick: Path, tmp_path: Path) -> None:
    (quick / "photo.jpg").write_bytes(b"jpg")
    sign(quick, [quick / "photo.jpg"], "a person", datetime(2026, 1, 5, 8, 40, tzinfo=UTC))
    (quick / "photo.jpg").rename(tmp_path / "photo.jpg")
    (quick / "photo.jpg").symlink_to(tmp_path / "photo.jpg")
    said = result("bundle", "run", expect=3)
    assert "run/photo.jpg" not in said["files"]
    (lost,) = (one for one in said["missing"] if one["what"] == "run/photo.jpg")
    assert lost["lost"] is True and "leads out of the folder" in lost["why"]


def test_names_that_nobody_sees_are_left_out(quick: Path) -> None:
    """Else no `reproduce` would take the archive."""
    (quick / "note\u202etxt.md").write_text("which way?")
    said = result("bundle", "run", expect=3)
    assert said["left_out"]["run/note\u202etxt.md"] == "its name holds a character that cannot be seen"
    command("reproduce", "run.tfsat.zip", expect=3)


def test_a_folder_with_a_long_name_makes_a_bundle_that_reproduces(quick: Path) -> None:
    quick.rename("n" * 240)
    said = result("bundle", "n" * 240, "--out", "a.zip", expect=3)
    assert said["name"] == "n" * 200
    command("reproduce", "a.zip", expect=3)


def test_it_speaks_of_bundling(run: Path) -> None:
    (run / "SD.bin").unlink()
    said = command("bundle", "run", expect=1)
    assert "Nothing was bundled." in said.err and "evaluate" not in said.err
    assert "tfsat-host bundle SD.bin" in command("bundle", "gone", expect=1).err


def test_a_name_that_ends_like_a_folder_is_none_of_a_file(run: Path) -> None:
    said = command("bundle", "run", "--out", "there/", expect=2)
    assert "'there/' is a folder" in said.err
    assert not Path("there").exists()
