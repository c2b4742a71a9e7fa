"""Chains of primitives and the estimate that leads the search for them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.chain_polish import least_time
from tfsat_host.plan.orbit.chain_search import Route, lookup, search
from tfsat_host.plan.orbit.orbit_flight import unit_quaternion
from tfsat_host.plan.orbit.orbit_planner import Planner, remainder
from tfsat_host.plan.orbit.primitive_trim import trim_primitive
from tfsat_host.plan.orbit.primitives import PrimitiveTable
from tfsat_host.plan.orbit.time_to_go import TimeToGo

GOAL_RAD = float(np.radians(1.0))
TARGETS_DEG = [(90.0, 0.0, 0.0), (-45.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, -10.0), (150.0, -8.0, 12.0)]


def after(table: PrimitiveTable, route: Route, needed: FloatArray) -> float:
    for index in route.primitives:
        needed = quaternion.product(quaternion.inverse(table.primitive(index).quaternion_xyzw), needed)
    return float(quaternion.angle(needed))


@pytest.mark.parametrize("target_deg", TARGETS_DEG)
def test_search_reaches_the_same_error_in_less_time(
    table: PrimitiveTable, target_deg: tuple[float, ...]
) -> None:
    needed = Rotation.from_euler("ZYX", target_deg, degrees=True).as_quat()
    greedy = lookup(table, needed, GOAL_RAD, 100)
    search_route = search(table, TimeToGo.of(table), needed, GOAL_RAD, most=100)
    for route in (greedy, search_route):
        assert route.remaining_rad <= GOAL_RAD
        assert after(table, route, needed) == pytest.approx(route.remaining_rad, abs=1e-12)
        assert route.duration_s == pytest.approx(table.duration_s[list(route.primitives)].sum())
    assert search_route.duration_s < 0.9 * greedy.duration_s


def test_no_chain_beats_the_robot_s_best_rate(table: PrimitiveTable) -> None:
    needed = Rotation.from_euler("ZYX", [90.0, 0.0, 0.0], degrees=True).as_quat()
    estimate = TimeToGo.of(table)
    route = search(table, estimate, needed, GOAL_RAD, most=100)
    least_s = (np.radians(90.0) - GOAL_RAD) / estimate.rate_rad_s[0]
    assert least_s <= route.duration_s < 1.7 * least_s


def test_at_the_target_nothing_is_flown(table: PrimitiveTable) -> None:
    assert lookup(table, quaternion.identity(), GOAL_RAD, 10).primitives == ()
    assert search(table, TimeToGo.of(table), quaternion.identity(), GOAL_RAD, most=10).primitives == ()


def test_the_estimate_counts_turns_about_the_fast_axis_and_the_tilt_between(table: PrimitiveTable) -> None:
    estimate = TimeToGo.of(table)
    fast, middle, slow = estimate.rate_rad_s
    assert np.degrees(fast) == pytest.approx(3.28, abs=0.05)
    assert fast > middle >= slow > 0.0
    assert np.abs(estimate.axes @ estimate.axes.T - np.eye(3)).max() < 1e-12
    rng = np.random.default_rng(6)
    for a, b, c in rng.uniform(-np.pi, np.pi, (40, 3)):
        turns = [
            quaternion.exponential(axis * angle)
            for axis, angle in zip(estimate.axes[[0, 1, 0]], (a, b, c), strict=True)
        ]
        needed = quaternion.product(quaternion.product(turns[0], turns[1]), turns[2])
        upper = (abs(a) + abs(c)) / fast + abs(b) / middle
        assert 0.0 < estimate.seconds(needed) <= upper * (1 + 1e-9)
    half_turn = quaternion.exponential(np.array(estimate.axes[0]) * 1.0)
    assert estimate.seconds(half_turn) == pytest.approx(1.0 / fast)
    assert estimate.seconds(-half_turn) == pytest.approx(1.0 / fast)
    assert estimate.seconds(quaternion.identity()) == pytest.approx(0.0, abs=1e-9)


def test_a_trimmed_primitive_leaves_nothing_and_stays_within_limits(nimble_table: PrimitiveTable) -> None:
    nimble_table, rng = nimble_table.single_loops, np.random.default_rng(8)
    inside = np.flatnonzero(np.degrees(quaternion.angle(nimble_table.rotation)) < 40.0)
    for index in rng.choice(inside, 5):
        rotation = nimble_table.rotation[:, index]
        needed = quaternion.product(rotation, quaternion.exponential(np.radians(rng.uniform(-0.5, 0.5, 3))))
        primitive, remaining = trim_primitive(nimble_table, needed, 1e-7)
        assert np.degrees(remaining) < 1e-4
        residual = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), needed)
        assert quaternion.angle(residual) == pytest.approx(remaining, abs=1e-12)
        assert np.degrees(np.abs(primitive.displacement_rad)).max() <= 90.0 + 1e-9


FEW_TARGETS = ["z:90", "z:45,y:20", "z:5", "x:-2"]
MORE_TARGETS = [
    "z:180",
    "x:30",
    "y:30",
    "x:30,y:-20,z:90",
    "z:-120,x:60",
    "y:-60,x:10",
    "x:-15",
    "z:-33,x:4,y:3",
]
TARGETS = [*FEW_TARGETS, *(pytest.param(target, marks=pytest.mark.prove) for target in MORE_TARGETS)]


@pytest.mark.parametrize("target", TARGETS)
def test_a_chain_is_never_slower_than_what_it_is_made_from_nor_faster_than_the_estimate(
    table: PrimitiveTable, monkeypatch: pytest.MonkeyPatch, target: str
) -> None:
    needed = unit_quaternion(target, None)
    planner = Planner.of(table, "search", GOAL_RAD, share=1.0)
    chain = planner.chain(needed)
    residual = remainder(chain.primitives, needed)
    assert float(quaternion.angle(residual)) <= GOAL_RAD
    assert chain.remaining_rad == pytest.approx(float(quaternion.angle(residual)), abs=1e-9)
    assert least_time(table, planner.time_to_go.axes[0], needed, GOAL_RAD).seconds <= chain.duration_s
    limits = table.limits_rad - table.start_rad[:, None]
    for primitive in chain.primitives:
        room = limits[list(primitive.shape.joints)]
        assert (primitive.displacement_rad >= room[:, 0] - 1e-12).all()
        assert (primitive.displacement_rad <= room[:, 1] + 1e-12).all()
    monkeypatch.setattr("tfsat_host.plan.orbit.orbit_planner.shorten_chain", lambda *_: None)
    assert chain.duration_s < planner.chain(needed).duration_s + 1e-12


def test_no_loop_is_faster_than_the_estimate_has_it(table: PrimitiveTable) -> None:
    needed = unit_quaternion("x:90", None)
    estimate = least_time(table, TimeToGo.of(table).axes[0], needed, GOAL_RAD)
    assert estimate.of == "tilt"
    for index in range(0, len(table), 7):
        moved = Rotation.from_quat(table.primitive(index).quaternion_xyzw).apply(estimate.direction)
        tilt = float(np.arccos(np.clip(moved @ estimate.direction, -1.0, 1.0)))
        assert tilt <= estimate.rate_rad_s * table.duration_s[index] + 1e-7
