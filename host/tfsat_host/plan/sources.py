"""Where errors come from: independent normal deviates, and what each does to the parameters.

The parameters follow linearly from the deviates: p = nominal + matrix @ deviates. A source may shift several
parameters at once, as the scale of a servo shifts the end of each of its strokes.

    mass          a share of each body's mass
    com           each coordinate of each center of mass
    inertia       a share of each body's whole tensor, so that it remains a rigid body's: a tensor that is scaled keeps
                  its principal axes and the ratios of its moments, and with them the triangle inequality
    joint_point   each coordinate of each joint's point across its axis
    joint_axis    each of two tilts of each axis
    stroke        the end of each stroke, anew for every stroke: play and dead band
    servo_scale   a joint goes 1 + error times as far as told, there and back; the servo's own error, which
                  is why a joint that stops short at 54.8 deg instead of 59 still comes back to where it began
    servo_speed   a share of each joint's speed
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tfsat_host.errors import UsageError
from tfsat_host.plan.parameters import Parameters
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import GREATEST_SHARE, UNCERTAIN, FloatArray

_DEG = float(np.degrees(1.0))


@dataclass(frozen=True, eq=False)
class ErrorSources:
    """d independent sources of error.

    Attributes:
        names: d names for people.
        kinds: d kinds, as the module lists them.
        sigmas: d standard deviations as people write them, with their units.
        matrix: (p, d) what one standard deviation of each does to each parameter, in the parameter's unit.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    sigmas: tuple[str, ...]
    matrix: FloatArray

    @property
    def parameter_sigma(self) -> FloatArray:
        """(p,) standard deviation of each parameter, in its unit."""
        return np.asarray(np.sqrt((self.matrix**2).sum(axis=1)))

    def shifts(self, deviates: FloatArray) -> FloatArray:
        """(s, p) shifts of the parameters by deviates (s, d).

        Sums in a fixed order, element by element: the same numbers from every computer, whatever BLAS it has.
        """
        shifts = np.zeros((len(deviates), len(self.matrix)))
        for parameter, source in zip(*np.nonzero(self.matrix), strict=True):
            shifts[:, parameter] += self.matrix[parameter, source] * deviates[:, source]
        return shifts


def error_sources(parameters: Parameters, stated: Uncertainty) -> ErrorSources:
    """The sources of a robot whose uncertainties are `stated`; a figure of 0 leaves a source without effect."""
    part, nominal = parameters.layout.slices(), parameters.nominal
    rows: list[tuple[str, str, str, FloatArray]] = []

    def add(kind: str, name: str, sigma: str, effects: dict[int, float]) -> None:
        column = np.zeros(len(nominal))
        for index, effect in effects.items():
            column[index] = effect
        rows.append((name, kind, sigma, column))

    def each(kind: str, of: str, sigma: float, unit: str, *, share: bool = False) -> None:
        written = f"{100 * sigma:g} %" if share else f"{sigma:g} {unit}"
        for i in range(part[of].start, part[of].stop):
            add(kind, parameters.names[i], written, {i: sigma * nominal[i] if share else sigma})

    each("mass", "mass", stated.mass_relative, "", share=True)
    each("com", "com", 1e3 * stated.com_m, "mm")
    for start in range(part["inertia"].start, part["inertia"].stop, 6):
        name = parameters.names[start].removesuffix(" xx")
        entries = {i: stated.inertia_relative * nominal[i] for i in range(start, start + 6)}
        add("inertia", name, f"{100 * stated.inertia_relative:g} %", entries)
    each("joint_point", "joint_point", 1e3 * stated.joint_point_m, "mm")
    each("joint_axis", "joint_tilt", _DEG * stated.joint_axis_rad, "deg")
    each("stroke", "stroke_end", _DEG * stated.stroke_rad, "deg")
    first, plan = part["stroke_end"].start, parameters.plan
    for joint, speed in zip(plan.moved_joints, range(part["speed"].start, part["speed"].stop), strict=True):
        name = parameters.names[speed].removesuffix(" speed")
        way = _DEG * (plan.target_rad - plan.start_rad[joint])
        scale = {
            first + k: stated.stroke_relative * way[k]
            for k, moved in enumerate(plan.joints)
            if moved == joint
        }
        add("servo_scale", f"{name} servo scale", f"{100 * stated.stroke_relative:g} %", scale)
    each("servo_speed", "speed", stated.servo_speed_relative, "", share=True)
    names, kinds, sigmas, columns = zip(*rows, strict=True)
    return ErrorSources(names, kinds, sigmas, np.column_stack(columns))


def uncertainty_of(robot: RobotModel, other: Mapping[str, float]) -> Uncertainty:
    """What the robot's file states, or nothing uncertain, with `other` figures for some of its keys.

    Raises:
        UsageError: a key is unknown, or a figure is no standard deviation or too large a share; or nothing is stated.
    """
    if robot.uncertainty is None and not other:
        raise UsageError(
            what=f"{robot.path} states no uncertainty.",
            meaning="Nothing was computed: without standard deviations there is nothing to draw.",
            next_step="Add a table [uncertainty] to the file, or state some: --sigma com_mm=3 --sigma stroke_deg=1",
        )
    for key, value in other.items():
        problem = cure = ""
        if key not in UNCERTAIN:
            problem, cure = f"{key!r} is no uncertainty", f"Known are: {', '.join(UNCERTAIN)}."
        elif not (math.isfinite(value) and value >= 0.0):
            problem, cure = f"{key}={value:g} is no standard deviation", f"Give 0 or more: --sigma {key}=0"
        elif key.endswith("_relative") and value > GREATEST_SHARE:
            problem = f"{key}={value:g} is too large: five of them would leave nothing"
            cure = f"Give a share up to {GREATEST_SHARE:g}, such as --sigma {key}=0.05 for 5 %."
        if problem:
            raise UsageError(what=f"--sigma: {problem}.", meaning="Nothing was computed.", next_step=cure)
    return Uncertainty.of((robot.uncertainty or Uncertainty()).stated() | dict(other))
