"""A robot's summary as lines and tables; how they are drawn is left to whoever shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from tfsat_host.robot.model import RobotModel
from tfsat_host.robot.summary import Json, summary

INERTIA_CONVENTION = (
    "Inertias are tensors about the center of mass, in body axes, all parallel to the global ones at zero angles;",
    "off-diagonal entries are minus the products of inertia.",
)


class Table(NamedTuple):
    """What a table shows: texts and numbers."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str | float]]


def summary_text(robot: RobotModel) -> str:
    """The whole summary as plain text, ending with a line feed."""
    facts = summary(robot)
    parts = ["\n".join(summary_lines(facts)), *map(_drawn, summary_tables(facts))]
    return "\n\n".join(parts) + "\n"


def summary_lines(facts: Json) -> list[str]:
    """What is said of the robot as a whole, from its `summary`."""
    rows = [
        ("Robot", facts["name"]),
        ("File", facts["file"]),
        ("Figures", facts["source"] or "the file does not say where they come from"),
        ("Base", f"{facts['base']}: its attitude is the robot's attitude"),
        ("Mass", f"{facts['mass_kg']:.6g} kg"),
        ("CoM", f"{_vector(facts['com_mm'])} mm, global, at zero joint angles"),
    ]
    return [f"{label:<9}{text}" for label, text in rows] + ["", *INERTIA_CONVENTION]


def summary_tables(facts: Json) -> list[Table]:
    """The tables of a `summary`; what the robot does not have is left out."""
    tables = [_bodies(facts), _inertias(facts)]
    if facts["joints"]:
        tables += [_joints(facts["joints"]), _servos(facts["joints"])]
    if facts["imus"]:
        tables.append(_imus(facts["imus"]))
    if facts["angle_sensors"]:
        tables.append(_angle_sensors(facts["angle_sensors"]))
    if facts["uncertainty"]:
        tables.append(_uncertainty(facts["uncertainty"]))
    return tables


def _bodies(facts: Json) -> Table:
    rows = [
        (b["name"], b["mass_kg"], _vector(b["origin_mm"]), _vector(b["com_mm"]), _extent(b["corners_mm"]))
        for b in facts["bodies"]
    ]
    return Table("Bodies", ("body", "kg", "origin / mm", "CoM in body / mm", "shape in body / mm"), rows)


def _inertias(facts: Json) -> Table:
    columns = ("g m^2", "xx", "yy", "zz", "xy", "xz", "yz", "principal moments")
    rows = [_inertia(body["name"], body) for body in facts["bodies"]]
    return Table("Inertia tensors", columns, [*rows, _inertia("all, joints at zero", facts)])


def _inertia(name: str, facts: Json) -> Sequence[str | float]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = facts["inertia_g_m2"]
    entries = (float(f"{entry:.5g}") for entry in (xx, yy, zz, xy, xz, yz))
    return (name, *entries, _vector(facts["principal_moments_g_m2"]))


def _joints(joints: Sequence[Json]) -> Table:
    rows = [
        (
            joint["name"],
            f"{joint['outer']} relative to {joint['inner']}",
            _vector(joint["axis"]),
            _vector(joint["point_mm"]),
            _range(joint["limits_deg"]),
        )
        for joint in joints
    ]
    columns = ("joint", "its angle turns", "about +", "through / mm", "limits / deg")
    return Table("Joints", columns, rows)


def _servos(joints: Sequence[Json]) -> Table:
    rows = []
    for joint in joints:
        servo = joint["servo"]
        rates = (servo["average_rate_deg_s"], servo["max_rate_deg_s"], servo["acceleration_deg_s2"])
        rows.append((joint["name"], *rates, servo["start_deg"], _pulses(servo["pulses"])))
    columns = ("joint", "average deg/s", "max deg/s", "deg/s^2", "start / deg", "pulses")
    return Table("Servos", columns, rows)


def _pulses(pulses: Json | None) -> str:
    if pulses is None:
        return "none"
    return (
        f"{pulses['reference_pulse_us']:g} us at {pulses['reference_angle_deg']:g} deg, "
        f"{pulses['pulse_us_per_deg']:.6g} us/deg, {_range(pulses['range_us'])} us"
    )


def _imus(imus: Sequence[Json]) -> Table:
    rows = [
        (
            imu["body"],
            f"{imu['bus']}, 0x{imu['address']:02x}",
            _vector(imu["position_mm"]),
            " ".join(map(_vector, imu["sensor_to_body"])),
            imu["gyro_range_deg_s"],
            imu["low_pass_hz"],
        )
        for imu in imus
    ]
    columns = ("on", "bus, address", "at / mm", "rows of sensor to body", "range / deg/s", "low-pass / Hz")
    return Table("IMUs", columns, rows)


def _angle_sensors(sensors: Sequence[Json]) -> Table:
    rows = [(sensor["joint"], f"{sensor['direction']:+d}", sensor["zero_offset_deg"]) for sensor in sensors]
    return Table("Angle sensors", ("joint", "direction", "shows at zero / deg"), rows)


def _uncertainty(wrong: Json) -> Table:
    return Table("Uncertainty", ("one sigma of", "figure"), list(wrong.items()))


def _vector(values: Sequence[float]) -> str:
    return f"({', '.join(f'{value:.5g}' for value in values)})"


def _range(values: Sequence[float]) -> str:
    low, high = values
    return f"{low:g} to {high:g}"


def _extent(corners: Sequence[Sequence[float]]) -> str:
    if not corners:
        return "not stated"
    axes = list(zip(*corners, strict=True))
    return f"{_vector(list(map(min, axes)))} to {_vector(list(map(max, axes)))}"


def _drawn(table: Table) -> str:
    cells = [list(table.columns), *([_cell(value) for value in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    numeric = [isinstance(value, float) for value in table.rows[0]]
    lines = ["  ".join(_padded(row, widths, numeric)).rstrip() for row in cells]
    return "\n".join([table.title, *(f"  {line}" for line in lines)])


def _cell(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _padded(row: Sequence[str], widths: Sequence[int], numeric: Sequence[Any]) -> list[str]:
    return [
        cell.rjust(width) if right else cell.ljust(width)
        for cell, width, right in zip(row, widths, numeric, strict=True)
    ]
