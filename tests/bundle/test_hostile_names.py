"""Names in an archive that a person cannot see for what they are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.bundle.commands import command
from tests.bundle.test_hostile_archives import GOOD, manifest_of, packed
from tfsat_host.run.bundle.manifest import parse_manifest


@pytest.mark.parametrize("sign", ["\u202e", "\u200b", "\ufeff", "\u00ad", "\u2066", "\u0085", "\u2028"])
def test_characters_that_nobody_sees_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: str
) -> None:
    """A name that reads `exe.txt` and ends otherwise (bidirectional), or two that look alike (zero width)."""
    monkeypatch.chdir(tmp_path)
    Path("a.zip").write_bytes(packed(GOOD | {f"run/gnp{sign}.txt": b"x"}))
    said = command("reproduce", "a.zip", expect=1)
    assert (
        "a character that cannot be seen" in said.words + " ".join(said.err.split()) and sign not in said.err
    )


def test_the_name_of_a_drop_is_no_novel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    values = json.loads(manifest_of(GOOD))
    for count, what in ((200, "SD.bin"), (201, "its name has 201 characters")):
        values["name"] = "n" * count
        Path("a.zip").write_bytes(packed(GOOD, json.dumps(values).encode()))
        if count > 200:
            assert what in " ".join(command("reproduce", "a.zip", expect=1).err.split())
        else:
            assert parse_manifest(json.dumps(values).encode(), "a.zip").name == "n" * 200
