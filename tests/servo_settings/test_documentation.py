"""The examples of docs/servos.md do what they say."""

from __future__ import annotations

import re
import shlex
from fractions import Fraction

import pytest

from tests.cli.process import RunCli
from tests.cli.test_documentation import shell_examples
from tests.paths import DOCS
from tfsat_host.servo_settings import FACTORY, parse_settings

PAGE = DOCS / "servos.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_commands_run_in_order(tfsat_host: RunCli) -> None:
    for example in shell_examples(PAGE):
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)
    assert tfsat_host.json("upload-servos", "--show", "--emulated")["frame_ms"] == 20.0


def test_the_example_file_is_one() -> None:
    (example,) = re.findall(r"^```toml\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    head, servo = example.split("\n[[servo]]")
    # The page shows joint 1 and says that the others look alike.
    servos = "".join(f"\n[[servo]]{servo.replace('joint = 1', f'joint = {joint}')}" for joint in (1, 2, 3))
    assert parse_settings(head + servos) == (FACTORY, [])


@pytest.mark.parametrize(("direction", "row"), [(1, "false"), (-1, "true")])
def test_the_formulas_find_a_servo(direction: int, row: str) -> None:
    """Recover a servo's true settings with the page's formulas from the angles at two commands."""
    (slope,) = re.findall(r"new us_per_deg = (.*)", TEXT)
    (zero,) = re.findall(rf"new zero_us    = (.*?) +\(reversed = {row}\)", TEXT)
    # A servo 40 us and 0.7 us/deg off the first guess: fractions, as the formulas are exact.
    true_zero, true_slope = Fraction(1040), Fraction("10.3")
    names = {"zero_us": Fraction(1000), "us_per_deg": Fraction(11), "a": Fraction(10), "b": Fraction(80)}

    def measure_angle(commanded: Fraction) -> Fraction:
        # The board gives this pulse; the servo turns it into an angle by its own zero and slope.
        pulse = names["zero_us"] + direction * names["us_per_deg"] * commanded
        return (pulse - true_zero) / (direction * true_slope)

    names |= {"A": measure_angle(names["a"]), "B": measure_angle(names["b"])}
    names["new_slope"] = _value(slope, names)
    assert names["new_slope"] == true_slope
    assert _value(zero.replace("new us_per_deg", "new_slope"), names) == true_zero


def _value(formula: str, names: dict[str, Fraction]) -> Fraction:
    """Evaluate a formula of the page."""
    return Fraction(eval(formula.replace("−", "-").replace("×", "*"), {"__builtins__": {}}, dict(names)))
