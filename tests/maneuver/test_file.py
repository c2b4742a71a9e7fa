"""The maneuver file: what is written is what is read, and nothing else passes."""

from __future__ import annotations

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.config.table import MAX_NUMBER
from tfsat_host.maneuver import (
    Maneuver,
    ManeuverError,
    Stroke,
    format_maneuver,
    four_stroke,
    parse_maneuver,
    read_maneuver,
    write_maneuver,
)

# The file's numbers end at 1e12: nothing that a lab has is greater.
finite = st.floats(-MAX_NUMBER, MAX_NUMBER)
# Times come for all strokes or for none. Joints need not exist: the schedule judges that.
untimed = st.builds(Stroke, st.integers(-(2**63), 2**63 - 1), finite)
timed = st.builds(Stroke, st.integers(1, 3), finite, finite)
names = st.text(st.characters(codec="utf-8").filter(str.isprintable), max_size=40)


@given(st.builds(Maneuver, st.lists(untimed, max_size=20).map(tuple), finite, finite, names))
def test_a_maneuver_reads_back_as_it_was_written(maneuver: Maneuver) -> None:
    assert parse_maneuver(format_maneuver(maneuver)) == maneuver


@given(st.builds(Maneuver, st.lists(timed, min_size=1, max_size=20).map(tuple), finite, name=names))
def test_times_read_back_as_they_were_written(maneuver: Maneuver) -> None:
    assert parse_maneuver(format_maneuver(maneuver)) == maneuver


def test_a_file_reads_back_as_it_was_written(tmp_path: Path) -> None:
    maneuver = four_stroke(58.75, 70.29)
    write_maneuver(maneuver, tmp_path / "maneuver.toml")
    assert read_maneuver(tmp_path / "maneuver.toml") == maneuver


# Lines that are right by themselves, and wrong types, wrong tables and broken syntax among them.
lines = st.sampled_from(
    [
        "schema = 1",
        "schema = 2",
        "speed_deg_s = 170",
        "pause_s = [1]",
        "strokes = 3",
        "strokes = [1, {}]",
        "[[strokes]]",
        "joint = 1",
        "joint = {}",
        "angle_deg = 59",
        "angle_deg = nan",
        "t_s = 0.7",
        "t_s = 1979-05-27",
        'name = "a"',
        "[strokes]",
        "=",
    ]
)


@given(st.lists(lines, max_size=12).map("\n".join) | st.text())
def test_any_text_is_a_maneuver_or_an_error_that_names_its_defect(text: str) -> None:
    try:
        maneuver = parse_maneuver(text, source="x.toml")
    except ManeuverError as error:
        assert error.what.startswith("x.toml:")
    else:
        assert isinstance(maneuver, Maneuver)
