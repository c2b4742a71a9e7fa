"""Damage to a campaign's papers is said by every command that reads them, and a run is no campaign."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bundle.commands import command, result


def test_every_command_says_that_index_and_drops_are_damaged(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    (camp / "campaign.json").write_text("[1]")
    (camp / "drop-0001" / "drop.json").write_text("[2]")
    (camp / "drop-0002" / "drop.json").unlink()
    said = [
        command("campaign", "list", "camp", expect=3).err,
        command("campaign", "next", "camp", expect=3).err,
        command("campaign", "report", "camp", expect=1).err,
    ]
    for err in said:
        for name in (
            "campaign.json is damaged",
            "drop-0001 is not in the index",
            "drop-0002 is not in the index",
        ):
            assert name in " ".join(err.split())
    assert command("campaign", "next", "camp", expect=3).out == "3\n"


@pytest.mark.parametrize(("damage", "words"), [(None, "is gone"), ("[2]", "cannot be read")])
def test_a_drop_that_lost_its_own_entry_is_named_until_it_has_it_again(
    camp: Path, damage: str | None, words: str
) -> None:
    command("campaign", "add", "camp", "run1")
    own = camp / "drop-0001" / "drop.json"
    own.unlink() if damage is None else own.write_text(damage)
    for action in ("list", "next"):
        assert words in command("campaign", action, "camp", expect=3).err
    assert words in result("campaign", "report", "camp", expect=3)["findings"][0]
    command("campaign", "note", "camp", "1", "found without its entry")
    assert result("campaign", "list", "camp")["findings"] == []


def test_an_entry_that_is_not_the_index_s_is_named(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    own = camp / "drop-0001" / "drop.json"
    own.write_text(own.read_text().replace('"emulated"', '"real"'))
    assert "not as the index has this drop" in command("campaign", "list", "camp", expect=3).err


@pytest.mark.parametrize(
    "left", ["SD.bin", "DROP0001.BIN", "preflight.json", "record.json", ".tfsat-rehearsal"]
)
def test_a_run_is_no_campaign(camp: Path, left: str) -> None:
    del camp
    Path("place").mkdir()
    (Path("place") / left).write_bytes(b"")
    said = command("campaign", "init", "place", expect=1)
    assert f"it holds {left}" in said.err and not Path("place/campaign.json").exists()


def test_hints_can_be_typed_as_they_are(camp: Path) -> None:
    camp.rename("camp ü $(x)")
    command("campaign", "add", "camp ü $(x)", "run1")
    for words in (
        ("add", "camp ü $(x)", "run1"),
        ("note", "camp ü $(x)", "7", "text"),
        ("init", "camp ü $(x)"),
    ):
        assert "'camp ü $(x)'" in command("campaign", *words, expect=1).err
