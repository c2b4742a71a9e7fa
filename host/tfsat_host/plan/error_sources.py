"""Where errors of the parameters come from, and how large they are.

Errors come from sources, independent normal deviates, and the parameters follow linearly from them: p = nominal +
matrix @ deviates. A source may shift several parameters at once, as the scale of a servo shifts the end of each of
its strokes.

    mass          a share of each body's mass
    com           each coordinate of each center of mass
    inertia       a share of each body's whole tensor, so that it remains a rigid body's: a tensor that is scaled keeps
                  its principal axes and the ratios of its moments, and with them the triangle inequality
    joint_point   each coordinate of each joint's point across its axis
    joint_axis    each of two tilts of each axis
    stroke        the end of each stroke, drawn for every stroke: play and dead band, or what a measured servo scatters
    start         the angle of a measured servo's joint at the release: anywhere within its play
    servo_scale   a joint goes 1 + error times as far as commanded, there and back; the servo's own error, which
                  is why a joint that stops short at 54.8 deg instead of 59 still comes back to where it began;
                  none of a measured servo, whose settings follow from the measurement
    servo_speed   a share of each joint's speed, or what the calibration leaves of it
    servo_delay   of each joint
    servo_acceleration   what the calibration leaves of it; speed, delay and acceleration of a measured servo err
                  together, as the covariance of their fit says
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.errors import UsageError
from tfsat_host.plan.parameters import DEG, SERVO_KINDS, Parameters
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import MAX_RELATIVE, UNCERTAIN


@dataclass(frozen=True, eq=False)
class ErrorSources:
    """d independent sources of error.

    Attributes:
        names: d names for people.
        kinds: d kinds, as the module lists them.
        sigmas: d standard deviations as people write them, with their units.
        matrix: (p, d) what one standard deviation of each does to each parameter, in the parameter's unit.
        drawn_first: So many are drawn before the others, which were added since: a seed keeps its robots.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    sigmas: tuple[str, ...]
    matrix: FloatArray
    drawn_first: int

    @property
    def parameter_sigma(self) -> FloatArray:
        """(p,) standard deviation of each parameter, in its unit."""
        return np.asarray(np.sqrt((self.matrix**2).sum(axis=1)))

    def shifts(self, deviates: FloatArray) -> FloatArray:
        """(s, p) shifts of the parameters by deviates (s, d).

        Sums in a fixed order, element by element: the same numbers from every computer, whatever BLAS it has.
        """
        shifts = np.zeros((len(deviates), len(self.matrix)))
        # The matrix is sparse: only its nonzero entries are summed, in a fixed order.
        for parameter, source in zip(*np.nonzero(self.matrix), strict=True):
            shifts[:, parameter] += self.matrix[parameter, source] * deviates[:, source]
        return shifts


def error_sources(parameters: Parameters, stated: Uncertainty) -> ErrorSources:
    """Build the error sources of a robot from its stated uncertainties.

    An uncertainty of 0 leaves its sources without effect.
    """
    part, nominal = parameters.part, parameters.nominal
    rows: list[tuple[str, str, str, FloatArray]] = []

    def add(kind: str, name: str, sigma: str, effects: dict[int, float]) -> None:
        column = np.zeros(len(nominal))
        for index, effect in effects.items():
            column[index] = effect
        rows.append((name, kind, sigma, column))

    def each(
        kind: str,
        of: str,
        sigma: float,
        unit: str,
        *,
        share: bool = False,
        numbers: Sequence[int] | None = None,
    ) -> None:
        written = f"{100 * sigma:g} %" if share else f"{sigma:.4g} {unit}"
        every = range(part[of].stop - part[of].start)
        for i in (part[of].start + number for number in (every if numbers is None else numbers)):
            add(kind, parameters.names[i], written, {i: sigma * nominal[i] if share else sigma})

    each("mass", "mass", stated.mass_relative, "", share=True)
    each("com", "com", 1e3 * stated.com_m, "mm")
    # One source scales all six entries of a tensor, which so remains a rigid body's.
    for start in range(part["inertia"].start, part["inertia"].stop, 6):
        name = parameters.names[start].removesuffix(" xx")
        entries = {i: stated.inertia_relative * nominal[i] for i in range(start, start + 6)}
        add("inertia", name, f"{100 * stated.inertia_relative:g} %", entries)
    each("joint_point", "joint_point", 1e3 * stated.joint_point_m, "mm")
    each("joint_axis", "joint_tilt", DEG * stated.joint_axis_rad, "deg")
    plan = parameters.plan
    # What was measured of a servo takes the place of what is stated of it.
    stops = {joint for joint in plan.moved_joints if plan.servos[joint].stop_std_rad is not None}
    strokes_of = {
        joint: [number for number, moved in enumerate(plan.joints) if moved == joint]
        for joint in plan.moved_joints
    }
    stated_stops = [number for number, joint in enumerate(plan.joints) if joint not in stops]
    each("stroke", "stroke_end", DEG * stated.stroke_rad, "deg", numbers=stated_stops)
    first = part["stroke_end"].start
    for joint in sorted(strokes_of.keys() - stops):
        name = parameters.joint_names[joint]
        # A servo's scale errs in proportion to the way from the start pose: back there it errs by nothing.
        way = DEG * (plan.stop_rad - plan.start_rad[joint])
        scale = {first + k: stated.stroke_relative * way[k] for k in strokes_of[joint]}
        add("servo_scale", f"{name} servo scale", f"{100 * stated.stroke_relative:g} %", scale)
    unmeasured = [number for number, servo in enumerate(plan.dynamics) if servo.covariance is None]
    each("servo_speed", "speed", stated.servo_speed_relative, "", share=True, numbers=unmeasured)
    drawn_first = len(rows)
    each("servo_delay", "delay", 1e3 * stated.servo_delay_s, "ms", numbers=unmeasured)
    for joint in sorted(stops):
        servo = plan.servos[joint]
        each("stroke", "stroke_end", DEG * (servo.stop_std_rad or 0.0), "deg", numbers=strokes_of[joint])
        # Where within its play a joint stands before the release is not known: evenly spread.
        each("start", "start", DEG * servo.play_rad / math.sqrt(12.0), "deg", numbers=[joint])
    units = np.array([unit for _, unit in SERVO_KINDS.values()])
    for number, drive in enumerate(plan.dynamics):
        if drive.covariance is None:
            continue
        # A triangular root makes independent sources of errors that hang together.
        root = np.linalg.cholesky(drive.covariance) * units[:, None]
        indices = [part[kind].start + number for kind in SERVO_KINDS]
        for i, (kind, (unit, _)) in enumerate(SERVO_KINDS.items()):
            effects = dict(zip(indices, root[:, i], strict=True))
            add(f"servo_{kind}", parameters.names[indices[i]], f"{root[i, i]:.2g} {unit}", effects)
    names, kinds, sigmas, columns = zip(*rows, strict=True)
    return ErrorSources(names, kinds, sigmas, np.column_stack(columns), drawn_first)


def uncertainty_of(robot: RobotModel, other: Mapping[str, float]) -> Uncertainty:
    """Return the robot's stated uncertainties, with the values in `other` replacing some of them.

    A robot whose file states none starts from zero.

    Raises:
        UsageError: a key is unknown, a value is not a standard deviation or too large a share, or nothing
            is stated.
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
        # A larger share could leave nothing of a mass or a rate within the deviates that are drawn.
        elif key.endswith("_relative") and value > MAX_RELATIVE:
            problem = f"{key}={value:g} is too large: five of them would leave nothing"
            cure = f"Give a share up to {MAX_RELATIVE:g}, such as --sigma {key}=0.05 for 5 %."
        if problem:
            raise UsageError(what=f"--sigma: {problem}.", meaning="Nothing was computed.", next_step=cure)
    # Figures that are given replace those of the file, key by key.
    return Uncertainty.of((robot.uncertainty or Uncertainty()).figures() | dict(other))
