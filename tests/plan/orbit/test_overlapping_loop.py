"""Loops in which joints overlap, as primitives of `plan --moving-at-once`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.orbit_flight import fly_primitive, unit_quaternion
from tfsat_host.plan.orbit.overlapping_loop import find_overlapping_primitive
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable


@pytest.fixture(scope="module")
def loop(table: PrimitiveTable) -> Primitive:
    found = find_overlapping_primitive(table, unit_quaternion("z:60", None), math.radians(1.0), 3)
    assert found is not None
    return found


def test_a_loop_turns_at_4_deg_s_about_z(loop: Primitive) -> None:
    vector = quaternion.logarithm(loop.quaternion_xyzw)
    off_axis_deg = math.degrees(math.atan2(math.hypot(*vector[:2]), vector[2]))
    assert off_axis_deg < 1.0
    # One joint at a time 3.28 deg/s.
    assert math.degrees(vector[2]) / loop.duration_s > 4.0


def test_strokes_overlap_within_ranges_and_each_joint_waits_for_itself(
    table: PrimitiveTable, loop: Primitive
) -> None:
    assert loop.spans_s is not None
    starts_s, ends_s = loop.spans_s.T
    assert starts_s[0] == 0.0 and (starts_s[1:] < ends_s[:-1] - 0.1).any()
    assert ends_s.max() == pytest.approx(loop.duration_s)
    for joint in range(3):
        own = [k for k, (mover, _) in enumerate(loop.strokes) if mover == joint]
        assert (starts_s[own[1:]] >= ends_s[own[:-1]]).all()
        angles = table.start_rad[joint] + np.cumsum([loop.strokes[k][1] for k in own])
        low, high = table.limits_rad[joint]
        assert (angles >= low - 1e-9).all() and (angles <= high + 1e-9).all()
        assert angles[-1] == pytest.approx(table.start_rad[joint])


def test_backwards_it_undoes_itself(table: PrimitiveTable, loop: Primitive) -> None:
    there, back = (fly_primitive(table.body, table, primitive) for primitive in (loop, loop.backwards))
    assert math.degrees(float(quaternion.angle(quaternion.product(there, back)))) < 1e-4


def test_a_quarter_turn_in_30_s_arrives_where_simulate_does(tfsat_host: RunCli) -> None:
    plan = tfsat_host.json("plan", "--target", "z:90", "--moving-at-once", "3", "--history", "plan.csv")
    assert plan["moving_at_once"] == 3 and plan["overlapping"]
    assert plan["reached"] and plan["least_time_s"] < plan["duration_s"] < 30.0
    starts = [stroke["start_s"] for stroke in plan["steps"][0]["strokes"]]
    assert starts == sorted(starts)
    simulation = tfsat_host.json("simulate", "--robot", "cubesat_3u", "--history", "plan.csv")
    there, end = np.array(simulation["quaternion_xyzw"]), np.array(plan["steps"][-1]["attitude_xyzw"])
    assert math.degrees(float(quaternion.angle(quaternion.product(quaternion.inverse(there), end)))) < 0.01


def test_where_no_overlapping_loop_is_found_it_is_said(tfsat_host: RunCli) -> None:
    words = " ".join(tfsat_host("plan", "--target", "x:30", "--moving-at-once", "3").stdout.split())
    assert "Joints at once: one (no faster loop of 3 joints that overlap was found)" in words


def test_more_joints_than_three_are_refused(tfsat_host: RunCli) -> None:
    assert "Error:" in tfsat_host("plan", "--target", "z:90", "--moving-at-once", "4", expect=2).stderr
