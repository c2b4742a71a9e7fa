"""Declared columns: what JSON, terminal and page make of one row."""

from __future__ import annotations

import io
import json
import math
from dataclasses import dataclass
from enum import Enum
from types import SimpleNamespace

import numpy as np
import pytest

from tfsat_host.present import terminal
from tfsat_host.present.output import Output
from tfsat_host.quantity import (
    Column,
    Quantity,
    Table,
    fields,
    json_objects,
    number,
    plus_minus,
    record,
    records,
    unit_of,
    vector,
)
from tfsat_host.report.contents import document_builder as page


class LogState(Enum):
    RECORDING = 1


@dataclass
class Stroke:
    joint: int = 2
    size_rad: float = math.radians(-30.0)
    size_std_rad: float = math.radians(0.0123)
    dead_time_s: float = 0.0021
    moved: bool = True
    axes_rad: object = None
    file: object = "a-b"


COLUMNS = (
    Column("joint", "joint"),
    Column("size_deg", "flown", std="size_std_rad", form="+.2f"),
    Column("dead_time_s", "dead time", form=".1f", shown_in="ms"),
    Column("moved", "moved"),
    Column("", "words", words=lambda stroke: f"of {stroke.joint}"),
    Column("file", "file"),
    # Without a label: for JSON only.
    *fields("number=joint axes_deg"),
)
TABLE = Table("Strokes", COLUMNS, [Stroke(), Stroke(size_rad=float("nan"))], "A caption.", 1, "1 folded")


def test_json_has_values_in_the_unit_of_their_key() -> None:
    stroke = Stroke(axes_rad=np.array([0.0, math.pi]))
    assert record(COLUMNS, stroke) == {
        "joint": 2,
        "size_deg": pytest.approx(-30.0),
        "size_deg_std": pytest.approx(0.0123),
        "dead_time_s": 0.0021,
        "moved": True,
        "file": "a-b",
        "number": 2,
        "axes_deg": pytest.approx([0.0, 180.0]),
    }
    # Minus zero would be read as a direction.
    assert math.copysign(1.0, record(COLUMNS, Stroke(size_rad=-0.0))["size_deg"]) == 1.0


def test_json_has_rows_in_rows() -> None:
    drop = SimpleNamespace(strokes=(Stroke(), Stroke(joint=3)), first=Stroke(), none=None)
    inner = fields("joint")
    columns = tuple(Column(key, columns=inner) for key in ("strokes", "first", "none"))
    assert record(columns, drop) == {
        "strokes": [{"joint": 2}, {"joint": 3}],
        "first": {"joint": 2},
        "none": None,
    }
    axes = Stroke(axes_rad=np.zeros(2), file=LogState.RECORDING)
    assert (
        json.dumps(record(fields("axes_rad file"), axes)) == '{"axes_rad": [0.0, 0.0], "file": "recording"}'
    )
    assert record(fields("joint=first.joint"), drop) == {"joint": 2}
    # Nothing measured is null, measured without rows an empty list.
    assert json_objects(inner, None) is None and records(inner, ()) == []


def test_page_shows_what_has_a_label() -> None:
    table = record(page.table_columns, TABLE)
    assert table["columns"] == ["joint", "flown (deg)", "dead time (ms)", "moved", "words", "file"]
    assert table["rows"][0] == ["2", "−30.000 ± 0.012", "2.1", "yes", "of 2", "a-b"]
    # Not a number.
    assert table["rows"][1][1] == "–"
    assert table["fold"] == {"first": 1, "words": "1 folded"} and table["caption"] == "A caption."


def test_a_row_of_json_is_shown_as_the_object_was() -> None:
    stroke = Stroke()
    columns = tuple(column for column in COLUMNS if column.key)
    assert (
        record(page.table_columns, Table("", columns, [stroke]))["rows"]
        == record(page.table_columns, Table("", columns, [record(columns, stroke)]))["rows"]
    )
    # JSON writes null for what is not a number.
    nothing = {**record(columns, stroke), "size_deg": None}
    assert record(page.table_columns, Table("", columns, [nothing]))["rows"][0][1] == "–"


def test_a_share_is_shown_in_percent_from_an_object_and_from_json() -> None:
    for column in (
        Column("share", "by", shown_in="percent"),
        Column("linear_share", "by", shown_in="percent"),
    ):
        cell = column.cell({column.key: 0.25})
        assert isinstance(cell, Quantity) and (cell.value, cell.unit) == (25.0, "%")


def test_terminal_says_once_what_the_quantities_of_a_group_share() -> None:
    stream = io.StringIO()
    # Two axes of one group with the same first words.
    rates = [
        Quantity(1.0, 0.1, "deg/s", label=f"Initial rate {axis}", group="Initial rates") for axis in "xy"
    ]
    terminal.show_quantities(rates, Output(stdout=stream))
    assert stream.getvalue() == "Initial rates: x 1.00 ± 0.10 deg/s, y 1.00 ± 0.10 deg/s\n"


def test_terminal_breaks_headings_before_numbers() -> None:
    stream = io.StringIO()
    numbers = tuple(Column(f"v{i}", "v", std="std") for i in range(3))
    others = tuple(Column(f"dead{i}", "heading of some words") for i in range(6))
    row = {f"v{i}{end}": value for i in range(3) for end, value in (("", 59.138), ("_std", 0.013))}
    terminal.show_rows(
        (*numbers, *others), [row | {column.key: 1 for column in others}], Output(stdout=stream)
    )
    assert stream.getvalue().count("59.138 ± 0.013") == 3


def test_terminal_shows_the_same() -> None:
    stream = io.StringIO()
    terminal.show_table(TABLE, Output(stdout=stream))
    words = " ".join(stream.getvalue().split())
    assert "flown / deg" in words and "2 -30.000 ± 0.012 2.1 yes of 2 a-b" in words
    # A hyphen in a name stays, a sign becomes a minus.
    assert record(page.table_columns, Table("", (Column("v", "v", words=lambda _: "RAM-1 -2.0 (-3)"),), [0]))[
        "rows"
    ] == [["RAM-1 −2.0 (−3)"]]
    assert words.endswith("1 folded A caption.") and words.count("a-b") == 1


def test_key_numbers_of_a_group_share_a_line() -> None:
    stream = io.StringIO()
    quantities = (
        Quantity(1.0, 0.1, "deg", label="Turn", note="of body 1"),
        Quantity(-2.0, 0.1, "deg/s", "+.2f", "x", group="Rates"),
        Quantity(float("nan"), None, "deg/s", label="y", group="Rates"),
    )
    terminal.show_quantities(quantities, Output(stdout=stream))
    assert stream.getvalue().splitlines() == [
        "Turn: 1.00 ± 0.10 deg, of body 1",
        "Rates: x -2.00 ± 0.10 deg/s, y unknown deg/s",
    ]
    key_numbers = records(page.key_number_columns, quantities)
    assert (key_numbers[0]["value"], key_numbers[0]["std"]) == (1.0, 0.1) and "row" not in key_numbers[0]
    assert key_numbers[2]["value"] is None and key_numbers[2]["row"] == "Rates"


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (27.9779, 0.01394, "27.978 ± 0.014"),
        # Rounded to zero, it loses its sign.
        (-0.0004, 0.25, "0.00 ± 0.25"),
        (123.4, 17.0, "123 ± 17"),
        (5.0, 0.0, "5.00 ± 0.00"),
        (5.0, float("nan"), "5.00 ± unknown"),
        (float("nan"), 1.0, "unknown"),
        # Six decimals at the most.
        (1.0, 1e-12, "1.000000 ± 0.000000"),
    ],
)
def test_a_number_has_the_decimals_that_it_deserves(value: float, std: float, text: str) -> None:
    assert plus_minus(value, std) == text


def test_numbers() -> None:
    assert number(-0.001, ".2f") == "0.00" and number(3.14159, "+.2f") == "+3.14"
    assert (
        number(0.0, "+.2f") == "0.00" and number(float("inf")) == "–" and number(1234.5, ".3g") == "1.23e+03"
    )
    assert vector([1.0, -2.0], [0.1, 0.02], "+.3f") == "+1.00 -2.00 ± 0.10"
    assert vector([1.0, -2.0], form=".1f") == "1.0 -2.0"


def test_the_unit_is_the_end_of_a_name() -> None:
    units = {
        "size_deg": "deg",
        "mean_rate_deg_s": "deg_s",
        "h_kg_m2_s": "kg_m2_s",
        "samples": "",
        "until_s": "s",
    }
    assert {name: unit_of(name) for name in units} == units


FACTS = (
    Column("size_deg", "stroke", of="size_rad", form="+.1f"),
    Column("joint", "moved joint"),
    # Empty, so no line is printed.
    Column("", "remark", words=lambda _stroke: ""),
)


def test_facts_are_a_label_and_a_value_per_line_and_empty_ones_are_left_out() -> None:
    stdout = io.StringIO()
    terminal.show_facts(FACTS, Stroke(), Output(stdout=stdout))
    assert stdout.getvalue() == "stroke:      -30.0 deg\nmoved joint: 2\n"
