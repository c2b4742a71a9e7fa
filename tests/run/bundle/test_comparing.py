"""What counts as the same, and what as a difference."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.run.bundle.json_comparison import (
    EVALUATION_TOLERANCE,
    REPORT_TOLERANCE,
    Tolerance,
    differences,
    same_figures,
)

# Relative and absolute: ten times stricter than the evaluation's relative 1e-5.
STRICT = Tolerance(1e-6, 1e-9)
_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
)


def keys(first: object, two: object) -> list[str]:
    difference_keys = [difference.key for difference in differences(first, two, STRICT)]
    assert len(difference_keys) == len(list(differences(two, first, STRICT))), (
        "it does not matter who is first"
    )
    return difference_keys


@given(_JSON)
def test_a_value_is_the_same_as_itself(value: object) -> None:
    assert keys(value, value) == []


def test_numbers_are_held_against_the_larger_or_the_largest_of_their_list() -> None:
    assert keys({"a": 1.0}, {"a": 1.0 + 0.9e-6}) == []
    # Just beyond the relative tolerance of 1e-6.
    assert keys({"a": 1.0}, {"a": 1.0 + 1.2e-6}) == ["a"]
    assert keys({"a": 1e-7}, {"a": 1.02e-7}) == ["a"], "beyond the absolute one"
    # Opposite signs, but both below the absolute tolerance of 1e-9.
    assert keys({"a": 1e-10}, {"a": -1e-10}) == []
    # Entries of a list share a unit: rounding of the largest may move the smallest.
    assert keys([1000.0, 1e-4], [1000.0, 5e-4]) == [], "next to 1000, 1e-4 is nothing"
    # A change of 2e-3 exceeds 1e-6 of 1000, though the 1000 stands in another row.
    assert keys([[1000.0, 1e-4], [0.0, 2e-3]], [[1000.0, 1e-4], [0.0, 4e-3]]) == ["[1][1]"]
    # Entries of an object may differ in unit: mass beside angle excuses nothing.
    assert keys({"a": 1000.0, "b": 1e-4}, {"a": 1000.0, "b": 5e-4}) == ["b"], "no list"


def test_a_difference_has_its_key_both_values_and_its_size() -> None:
    (difference,) = differences({"a": [{"b": 10.0}]}, {"a": [{"b": 11.0}]}, EVALUATION_TOLERANCE)
    assert (difference.key, difference.bundled, difference.recomputed) == ("a[0].b", 10.0, 11.0)
    assert difference.relative == pytest.approx(1.0 / 11.0)


@pytest.mark.parametrize(
    ("first", "two"),
    [
        # Python calls these equal; a flag that became a count is another result.
        (True, 1),
        (None, 0.0),
        (0.0, None),
        ("1", 1),
        ([1], [1, 2]),
        ({"a": 1}, {}),
        ([], {}),
        (1, [1]),
        ("a", "b"),
    ],
)
def test_what_is_of_another_kind_differs(first: object, two: object) -> None:
    assert len(keys({"k": first}, {"k": two})) == 1


@pytest.mark.parametrize(
    ("first", "two", "same"),
    [
        # Decimals may differ by one in the last digit: another machine rounds there.
        ("turned by 25.64 ± 0.01 deg", "turned by 25.65 ± 0.02 deg", True),
        ("turned by 25.64 ± 0.01 deg", "turned by 25.66 ± 0.01 deg", False),
        ("1.0e-05 of it", "1.1e-05 of it", True),
        # The same count in other words, then counts, ids, signs and dates, which must be equal.
        ("all 22 checks passed.", "22 checks hold (all).", True),
        ("22 checks", "21 checks", False),
        ("22 checks of 24", "22 checks", False),
        ("recording 910a2dec", "recording 911a2dec", False),
        ("file 1.5a", "file 1.6a", False),
        ("rose by 2.5 deg", "rose by -2.5 deg", False),
        ("released 2026-01-05", "released 2026-01-06", False),
    ],
)
def test_of_sentences_the_figures_count(first: str, two: str, same: bool) -> None:
    assert same_figures(first, two) is same


@pytest.mark.parametrize(
    ("key", "first", "two"),
    [
        # Words without a digit that are results all the same.
        ("worth", "to be made", "not called for"),
        ("verdict", "passed", "not possible"),
        ("name", "body 1 CoM x", "body 1 CoM y"),
        ("composition", "86 % body 2 CoM z", "86 % body 2 CoM x"),
        ("level", "good", "doubtful"),
    ],
)
@pytest.mark.parametrize("tolerance", [EVALUATION_TOLERANCE, REPORT_TOLERANCE])
def test_what_is_no_sentence_must_be_equal(key: str, first: str, two: str, tolerance: Tolerance) -> None:
    (difference,) = differences({"correction": {key: first}}, {"correction": {key: two}}, tolerance)
    assert difference.key == f"correction.{key}"


@pytest.mark.parametrize("tolerance", [EVALUATION_TOLERANCE, REPORT_TOLERANCE])
def test_the_sentences_of_a_list_may_be_said_otherwise(tolerance: Tolerance) -> None:
    then = {"reasons": ["2 of 3 switches"]}
    assert differences(then, {"reasons": ["switches, 2 of 3"]}, tolerance) == []
    (difference,) = differences(then, {"reasons": ["1 of 3 switches"]}, tolerance)
    assert difference.key == "reasons[0]"


def test_a_page_may_name_its_headings_otherwise() -> None:
    then, now = (
        {"title": "Strokes", "rows": [["1: joint 1"]]},
        {"title": "Joint strokes", "rows": [["1, joint 1"]]},
    )
    assert differences(then, now, REPORT_TOLERANCE) == []
    assert len(differences(then, now, EVALUATION_TOLERANCE)) == 2


def nest_list(depth: int) -> object:
    value: object = 1.0
    for _ in range(depth):
        value = [value]
    return value


# Deeper than the recursion limit, larger than any float, not finite.
@pytest.mark.parametrize(
    "hostile", [nest_list(5000), 10**400, float("nan"), float("inf"), {"a": nest_list(5000)}]
)
def test_what_nobody_would_write_is_a_difference(hostile: object) -> None:
    for ours in (1.0, [1.0], nest_list(5), {"a": [1.0, [2.0]]}):
        for first, two in ((hostile, ours), (ours, hostile)):
            mismatches = list(differences({"k": first}, {"k": two}, STRICT))
            assert mismatches
            # It is printed as well: a value that cannot be shown must not crash the screen.
            repr(mismatches)
