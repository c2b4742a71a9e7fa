"""docs/wiring.md and docs/wiring.svg come from docs/wiring.toml, and from a wiring that harms nothing."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.wiring.wirings import Tree, copy_generator
from tests.paths import REPOSITORY
from wiring_generator import page
from wiring_generator.spec import WiringError, load_wiring


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return copy_generator(tmp_path)


def test_what_is_committed_is_what_the_data_says() -> None:
    process = Tree(REPOSITORY).generate("--check")
    assert (process.returncode, process.stdout, process.stderr) == (0, "", "")


def test_a_changed_value_makes_both_files_stale_until_they_are_written(tree: Tree) -> None:
    # One capacitor: its value stands in the drawing and on the page.
    tree.spoil('value = "4.7 nF, film or X7R", short = "4.7 nF"', 'value = "4.8 nF", short = "4.8 nF"')
    process = tree.generate("--check")
    assert process.returncode == 1
    assert {line.split()[1] for line in process.stderr.splitlines()} == {"docs/wiring.svg", "docs/wiring.md"}
    assert tree.generate().returncode == 0
    assert tree.generate("--check").returncode == 0
    for name in ("wiring.svg", "wiring.md"):
        assert "4.8 nF" in (tree.folder / "docs" / name).read_text(encoding="utf-8")


def test_a_wiring_that_is_refused_leaves_both_files_alone_and_says_why(tree: Tree) -> None:
    tree.spoil('"R4", "R2 to 5V"', '"R2 to 5V"')
    process = tree.generate()
    assert (process.returncode, process.stdout) == (1, "")
    assert process.stderr == "docs/wiring.toml: R4 is wired 0 times\n"


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('"R4", "R2 to 5V"', '"R99", "R2 to 5V"', "R99"),
        ('"R4", "R2 to 5V"', '"R2 to 5V"', "R4 is wired 0 times"),
        ('from = "D13"', 'from = "D4"', "D4 is wired twice"),
        ('to = "3"', 'to = "2"', "Teensy 4.1 2 is wired twice"),
        ('kind = "switch"', 'kind = "button"', "button"),
        ('cathode = "left"', 'cathode = "up"', "cathode"),
        ('panel = "logger"', 'panel = "ground station"', "ground station"),
        ("high = 5.25", "high = 4.25", "micro_5v"),
        ('source = "avr"', 'source = "avrr"', "avrr"),
        ("[limit]", "[limits]", "limit"),
        ("[limit]", "[limit", "line"),
    ],
)
def test_a_wiring_that_makes_no_sense_is_refused_by_name(tree: Tree, old: str, new: str, word: str) -> None:
    tree.spoil(old, new)
    with pytest.raises(WiringError, match=re.escape(word)):
        load_wiring(tree.folder / "docs" / "wiring.toml")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        pytest.param(
            # The bootloader drives D13 high: over 10 Ω into a closed contact that is 500 mA.
            'value = "2.7 kΩ", of = 2700.0',
            'value = "10 Ω", of = 10.0',
            "D13 driven high",
            id="switch-on-D13",
        ),
        pytest.param(
            # Against the pin's own pull-up R3 of 10 kΩ leaves the level too high to read as closed.
            'value = "2.7 kΩ", of = 2700.0',
            'value = "10 kΩ", of = 10e3',
            "D4, D13 closed",
            id="too-much-at-D13",
        ),
        pytest.param(
            # 5 V over 22 kΩ is 0.2 mA: the contact wants 1 mA.
            'value = "2.2 kΩ", of = 2200.0',
            'value = "22 kΩ", of = 22e3',
            "closed contact",
            id="contact-too-dry",
        ),
        # 5 x 1.2 V is 6.0 V: the regulator wants 6.1 V.
        pytest.param("low = 6.6", "low = 6.0", "the Micro's VIN", id="five-NiMH-cells"),
        pytest.param("high = 2e-6", "high = 1e-3", "above its own supply", id="power-schottky"),
        pytest.param(
            'R18 = { kind = "resistor", value = "1 kΩ", of = 1e3',
            'R18 = { kind = "resistor", value = "10 kΩ", of = 10e3',
            "Teensy 2, 3 closed",
            id="too-much-at-the-teensy",
        ),
        pytest.param("high = 0.32", "high = 1.0", "Teensy 2, 3 closed", id="two-diodes"),
        # Ten times the capacitor, ten times the delay of the release: 50 us are allowed.
        pytest.param("of = 4.7e-9", "of = 47e-9", "date of an opening", id="slow-filter"),
        # The divider would give 5.25 x 6.8 / 10.1 = 3.5 V; the Teensy's pins take 3.3 V.
        pytest.param(
            "of = 4700.0", "of = 6800.0", "stroke line high, Teensy in reset", id="5V-on-the-teensy"
        ),
        # 5 x 4.7 / 11.5 = 2.0 V: not surely high for the Teensy.
        pytest.param("of = 3300.0", "of = 6800.0", "margin above the high threshold", id="stroke-unseen"),
        pytest.param(
            'value = "10 kΩ", of = 10e3', 'value = "1 MΩ", of = 1e6', "servo line", id="servo-floats"
        ),
        pytest.param('value = "1 kΩ", of = 1e3', 'value = "100 Ω", of = 100.0', "status LED", id="led"),
        # Two metres of cable: a bit takes longer than the logger waits for.
        pytest.param(
            "i2c_cable_f = 150e-12", "i2c_cable_f = 300e-12", "no R14 to R17 is fast enough", id="slow-bus"
        ),
    ],
)
def test_a_wiring_that_breaks_a_limit_is_refused(tree: Tree, old: str, new: str, word: str) -> None:
    tree.spoil(old, new)
    with pytest.raises(WiringError, match=word):
        page.generate(load_wiring(tree.folder / "docs" / "wiring.toml"))


def test_every_source_is_cited() -> None:
    text, sources = (REPOSITORY / "docs" / "wiring.md").read_text(encoding="utf-8").split("\n## Sources\n")
    named = re.findall(r"^\| (\[\d+\]) \|", sources, re.MULTILINE)
    assert len(named) > 10
    assert [name for name in named if name not in text] == []
