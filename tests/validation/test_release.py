"""A release is refused, with what to type, where the tree is dirty, the changelog is silent or a page is stale."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from tests.validation import release
from tests.validation.provenance import PROOFS, SHA256_ROW, Proof, read_provenance
from tfsat_host import __version__


@pytest.fixture
def clean_tree(tmp_path: Path) -> Path:
    (tmp_path / "CHANGELOG.md").write_text("# Changes\n")
    for command in (("init", "-q"), ("add", "."), ("commit", "-qm", "first")):
        identity = ("-c", "user.name=tfsat", "-c", "user.email=tfsat@localhost")
        subprocess.run(["git", *identity, *command], cwd=tmp_path, check=True)
    return tmp_path


def test_a_dirty_tree_is_named(clean_tree: Path) -> None:
    assert release.find_uncommitted(clean_tree) == []
    (clean_tree / "new.py").write_text("")
    (sentence,) = release.find_uncommitted(clean_tree)
    assert sentence.startswith("1 file") and "git status" in sentence


@pytest.mark.parametrize(
    ("headings", "sentences"),
    [
        (("0.3.0", "0.2.0"), 0),
        (("0.3.0 - 2026-12-01", "0.2.0"), 0),
        (("[0.3.0]",), 0),
        (("Unreleased", "0.3.0"), 1),
        (("0.2.0",), 1),
        (("Unreleased", "0.2.0"), 2),
        (("0.3.01",), 1),
    ],
)
def test_the_changelog_has_a_section_of_the_version(headings: tuple[str, ...], sentences: int) -> None:
    text = "# Changes\n\n" + "\n\n".join(f"## {heading}\n\n- An entry." for heading in headings)
    assert len(release.find_missing_entry(text, "0.3.0")) == sentences


@pytest.mark.parametrize("proof", PROOFS, ids=lambda proof: proof.name)
def test_a_page_is_stale_as_soon_as_its_subject_differs(proof: Proof) -> None:
    recorded = read_provenance(proof.folder)[SHA256_ROW]
    assert not replace(proof, hash_subject=lambda: recorded).is_stale()
    changed = replace(proof, hash_subject=lambda: "0" * 64)
    assert changed.is_stale() and proof.command in changed.stale_sentence()


def test_a_stale_page_is_refused_with_its_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Proof, "is_stale", lambda proof: proof.name == "calibration-proof")
    monkeypatch.setattr(release, "find_uncommitted", lambda _: [])
    monkeypatch.setattr(release, "find_missing_entry", lambda _: [])
    assert release.main() == 1
    refusal = capsys.readouterr().err
    assert "docs/calibration-proof.md was measured on another version of the code" in refusal
    assert "Run: make calibration-report" in refusal


def test_a_clean_release_has_the_package_and_its_image(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(release, "find_obstacles", list)
    monkeypatch.setattr(release, "build_release", lambda: [release.DIST / "a.whl"])
    assert release.main() == 0
    assert capsys.readouterr().out == f"  dist/a.whl\nNext: git tag v{__version__}\n"
