"""Faults in which the residual is linear: what is off by more than robot file and certificate state."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import WEIGHT_STD_RAD_S
from tfsat_host.calibration.sensors.gyro import BIAS, MOUNTING, SCALE
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.checks.cause_evidence import SOUND, Hypothesis, Words
from tfsat_host.evaluation.checks.check import UNKNOWN, SensorColumn, gyro_column
from tfsat_host.evaluation.checks.consistency import sensor_name
from tfsat_host.evaluation.checks.stated_errors import axis_std_rad
from tfsat_host.evaluation.checks.whole_residual import WholeResidual
from tfsat_host.next_step import Advice, NextStep

WORSE = 4.0
"""Times what is stated, that a fault of a stated number typically is: half of it and less is no fault."""
AXIS, WEIGHT_FELT = "joint axis", "g-sensitivity"
NO_SENSORS = frozenset({"masses", "inertias", "hinge points", "CoM", AXIS, "push", SOUND, UNKNOWN})
"""Kinds of causes of which no sensor is wrong, as far as is known."""
STATED_TOO_WELL = frozenset(
    {"gyro bias", "gyro misalignment", "gyro scale", WEIGHT_FELT, "timing", "certificate"}
)
"""Kinds that last the whole drop: with greater ± the certificate is right."""
_SCALE, _TURNED_RAD, _BIAS_RAD_S = 0.01, np.deg2rad(0.5), np.deg2rad(0.3)
_SLIPPED_RAD, _LATE_S, _PUSHED = np.deg2rad(1.0), 2e-3, 0.01
_CUT_OFF_RAD_S = np.deg2rad(10.0)
_PLATEAU, _PLATEAU_KNOT_S, _FAST_RAD_S = 0.93, 0.025, np.deg2rad(30.0)
"""Readings above such a share of the greatest may be cut off; what they lack may change from knot to knot."""
_RELEASE_S = 0.05
ROBOT = Advice("with the robot file: ", NextStep("robot"))
LOOK = Advice(
    "Look at its samples: ", NextStep("decode"), "; leave the sensor out or repair it before the next drop"
)
CLOCK = Advice("Look at the late samples: ", NextStep("decode"), "; check the logger: ", NextStep("status"))


def stated_faults(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield faults in which a stated quantity is off by more than its file says throughout; quick to try."""
    if residuals.model is not None:
        yield from _robot_files(residuals)
    yield from _leaning_axes(residuals)
    yield from _changed_gyros(residuals)
    yield from _heavy_gyros(residuals)
    yield from _late_gyros(residuals)
    yield from _bad_certificates(residuals)


def passing_faults(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield faults that happen at one time, which is to be found."""
    yield from _bias_steps(residuals)
    yield from _slipped_sensors(residuals)
    yield from _cut_off(residuals)
    if residuals.model is not None:
        yield from _pushes(residuals)


def _robot_files(residuals: WholeResidual) -> Iterator[Hypothesis]:
    assert residuals.model is not None
    offsets = residuals.model.fit.offsets
    groups = {
        "masses": [kind == "mass" for kind in offsets.kinds],
        "inertias": [kind == "inertia" for kind in offsets.kinds],
        "hinge points": [kind == "point" for kind in offsets.kinds],
        "CoM": [kind == "com" and k >= offsets.sought for k, kind in enumerate(offsets.kinds)],
    }
    for kind, chosen in groups.items():
        if not any(chosen):
            continue
        columns = WORSE * residuals.stack(None, residuals.model.by_offsets[:, chosen])
        names = np.array(offsets.names)[chosen]
        units, stds = np.array(offsets.units)[chosen], WORSE * offsets.prior_std[chosen]
        what = f"the CoM of {names[0].split(' CoM')[0]}" if kind == "CoM" else f"the {kind}"

        # Defaults bind the values of this turn of the loop: the words are asked for after it.
        def words(
            numbers: FloatArray,
            what: str = what,
            names: FloatArray = names,
            units: FloatArray = units,
            stds: FloatArray = stds,
        ) -> str:
            k = int(np.abs(numbers).argmax())
            return (
                f"the robot file: {what} would have to be off by more than stated, most of all {names[k]} "
                f"by {numbers[k] * stds[k]:+.1f} {units[k]}"
            )

        step = Advice("Weigh the bodies, measure the hinges, compare ", ROBOT)
        yield Hypothesis(kind, columns, words, step)


def _leaning_axes(residuals: WholeResidual) -> Iterator[Hypothesis]:
    # A file that states exact axes gives a fault no size: half a degree.
    std = WORSE * (axis_std_rad(residuals.data) or np.deg2rad(0.5))

    def words(numbers: FloatArray) -> str:
        off_deg = np.rad2deg(std * np.linalg.norm(numbers.reshape(-1, 2), axis=1))
        joint = int(off_deg.argmax())
        return (
            f"the robot file: the axis of joint {joint + 1} leans by {off_deg[joint]:.1f} deg, more than its file "
            "allows"
        )

    step = Advice("Measure the hinges, compare ", ROBOT)
    yield Hypothesis(AXIS, std * residuals.by_tilts, words, step)


def _changed_gyros(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Another bias, mounting or scale: three numbers each."""
    for body, calibrated in enumerate(residuals.data.calibration.gyros):
        bias_time, columns = calibrated.bias_recorded_at, residuals.by_gyros.parameters[:, body]
        gyro = f"gyro of body {body + 1}:"
        since = f" since {bias_time:%Y-%m-%d %H:%M} UTC" if bias_time else ""

        def bias(numbers: FloatArray, gyro: str = gyro, since: str = since) -> str:
            off = list_numbers(np.rad2deg(_BIAS_RAD_S * numbers))
            return f"{gyro} stale calibration, its bias has changed by {off} deg/s{since}"

        def misalignment(numbers: FloatArray, gyro: str = gyro) -> str:
            off_deg = np.rad2deg(_TURNED_RAD * np.linalg.norm(numbers))
            return f"{gyro} stale calibration, its misalignment has changed by {off_deg:.2f} deg"

        def scale(numbers: FloatArray, gyro: str = gyro) -> str:
            # The Jacobian is taken at the rates as shown, which are off by the same factor.
            off = _SCALE * numbers / (1.0 - _SCALE * numbers)
            return f"{gyro} its scale factor is {list_numbers(100.0 * off)} % off the calibrated one"

        # A wrong range scales the whole reading, its bias too.
        ranged = columns[:, SCALE] + columns[:, BIAS] * (calibrated.bias_rad_s / calibrated.scale)
        again = {kind: Advice(NextStep(f"calibrate {kind}")) for kind in ("bias", "misalignment", "scale")}
        faults = (
            ("bias", _BIAS_RAD_S * columns[:, BIAS], bias),
            ("misalignment", _TURNED_RAD * columns[:, MOUNTING], misalignment),
            ("scale", _SCALE * columns[:, SCALE], scale),
            ("scale", _SCALE * ranged, scale),
        )
        for kind, free, words in faults:
            yield Hypothesis(f"gyro {kind}", free, words, again[kind], sensor=gyro_column(body))


def list_numbers(numbers: FloatArray) -> str:
    """Three of them."""
    # Adding zero takes the sign off a zero.
    return "/".join(f"{round(float(number), 2) + 0.0:+.2f}" for number in numbers) + " (x/y/z)"


def _heavy_gyros(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield the fault that all gyros' biases change more with their weight than the data sheet states."""
    # In the fall alone: what the weight makes a gyro show at rest is part of its bias.
    biases = residuals.by_gyros.in_fall[:, :, :3].reshape(residuals.size, -1)

    def words(numbers: FloatArray) -> str:
        off = np.rad2deg(WORSE * WEIGHT_STD_RAD_S * np.sqrt((numbers**2).mean()))
        return f"g-sensitivity of the gyros: their biases changed by {off:.2f} deg/s rms when they lost their weight"

    yield Hypothesis(
        WEIGHT_FELT,
        WORSE * WEIGHT_STD_RAD_S * biases,
        words,
        Advice(
            "Calibrate each gyro's bias in several poses, or state a greater g-sensitivity: ",
            NextStep("calibrate bias"),
        ),
    )


def _late_gyros(residuals: WholeResidual) -> Iterator[Hypothesis]:
    for body in range(residuals.data.bodies):
        gyro = gyro_column(body)
        yield late(gyro.name, residuals.by_gyros.delay[:, [body]])._replace(sensor=gyro)
    every = residuals.by_gyros.delay.sum(axis=1, keepdims=True)
    yield late("clock slip: all gyros against the angle sensors", every)


def late(name: str, column: FloatArray) -> Hypothesis:
    """Build the hypothesis of a delay, one number.

    Its `column` (size, 1) is the effect of a delay of one second.
    """

    def words(numbers: FloatArray) -> str:
        ms = 1e3 * _LATE_S * float(numbers[0])
        return f"{name} {'late' if ms > 0.0 else 'early'} by {abs(ms):.1f} ms"

    return Hypothesis("timing", _LATE_S * column, words, CLOCK)


def _bad_certificates(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield the fault that gyros and angle sensors are off by more than their certificate states."""
    gyros = residuals.data.calibration.gyros
    parts = [residuals.by_gyros.parameters[:, b] @ root_of(gyro.covariance) for b, gyro in enumerate(gyros)]
    columns = WORSE * np.concatenate([*parts, residuals.stack(residuals.stated.by_sensors)], axis=1)
    cause = "the certificate: its gyros and angle sensors are off by several times what it states"
    step = Advice("Calibrate again: ", NextStep("calibrate show"))
    yield Hypothesis("certificate", columns, fixed_words(cause), step)


def _since(columns: FloatArray, blocks: int) -> FloatArray:
    """(size, blocks, q) what lasts from each block on, of columns (size, blocks q) that last for one."""
    # Reverse cumulative sum over the blocks: a step at one is all blocks from there on.
    each = columns.reshape(len(columns), blocks, -1)
    return np.asarray(each[:, ::-1].cumsum(axis=1)[:, ::-1])


def by_blocks(residuals: WholeResidual, body: int) -> FloatArray:
    """(size, 3 blocks) by what a gyro's axes show less, block by block, in typical biases."""
    data, gyro = residuals.data, residuals.data.calibration.gyros[body]
    within = np.repeat(np.eye(data.blocks), data.block.counts, axis=1)
    axes = -_BIAS_RAD_S * (gyro.rotation @ gyro.inverse_response)
    # (blocks, 3, n, 3): one sensor axis shows less within one block; the last axis is the body's.
    rates = within[:, None, :, None] * axes.T[None, :, None, :]
    return residuals.by_gyro(body, rates.reshape(-1, len(data.t_s), 3))


def _bias_steps(residuals: WholeResidual) -> Iterator[Hypothesis]:
    data = residuals.data
    for body in range(data.bodies):
        steps = _since(by_blocks(residuals, body), data.blocks)
        for block, edge in enumerate(data.block.edges):
            yield _step(gyro_column(body), float(data.t_s[edge]), steps[:, block])


def _step(gyro: SensorColumn, at_s: float, columns: FloatArray) -> Hypothesis:
    when = "at the release" if at_s < _RELEASE_S else f"at {at_s:.1f} s"

    def words(numbers: FloatArray) -> str:
        return (
            f"{gyro.name}: its bias jumped by {list_numbers(np.rad2deg(_BIAS_RAD_S * numbers))} deg/s {when}"
        )

    step = "Replace this IMU: it did not bear the drop"
    return Hypothesis("bias step", columns, words, step, sensor=gyro)


def _slipped_sensors(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield angle sensors that slip at some time; from then on only the joint's other sensor is right."""
    data = residuals.data
    for joint, sensor in np.ndindex(data.joints, 2):
        rows = data.along(joint, sensor)
        # The joint's geometry by its other sensor alone, but this one's rows as it showed them.
        sensor_residual = data.with_one(joint, sensor, np.full(len(data.t_s), np.nan))
        sensor_residual[rows] = data.residual[rows]
        slip_columns = np.zeros((residuals.size, data.blocks))
        slip_columns[rows] = -_SLIPPED_RAD * np.eye(data.blocks)
        for block, edge in enumerate(data.block.edges):
            # For some of its block it had not slipped yet, unless it was before the release.
            parts = (slip_columns[:, block + 1 :], slip_columns[:, [block]]) if block else (slip_columns,)
            columns = np.stack([part.sum(axis=1) for part in parts], axis=1)
            hypothesis = _slip(joint, sensor, float(data.t_s[edge]), columns)
            yield hypothesis._replace(
                left=residuals.with_sensors(sensor_residual), sensor=data.angle_sensor(joint, sensor)
            )


def _slip(joint: int, sensor: int, at_s: float, columns: FloatArray) -> Hypothesis:
    def words(numbers: FloatArray) -> str:
        off_deg = float(np.rad2deg(_SLIPPED_RAD * numbers[0]))
        if at_s < _RELEASE_S:
            return (
                f"angle sensors of joint {joint + 1}: stale calibration, the zero point of one has moved by "
                f"{abs(off_deg):.2f} deg against the other's"
            )
        return f"{sensor_name(joint, sensor)} slipped by {off_deg:+.2f} deg at {at_s:.1f} s"

    step = Advice(NextStep("calibrate zero", ("--joint", str(joint + 1))))
    return Hypothesis("slipped sensor", columns, words, step)


def _cut_off(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield gyros that saturate at some limit although no count is at full scale."""
    data = residuals.data
    for body, gyro in enumerate(data.calibration.gyros):
        # With the low-pass in them: taking it off makes corners overshoot.
        readings = data.lagging_rad_s[:, body]
        lacking = [
            np.outer(hat, axis)
            for axis_rates, axis in zip(readings.T, (gyro.rotation @ gyro.inverse_response).T, strict=True)
            for hat in _plateaus(data.t_s, np.abs(axis_rates))
        ]
        if not lacking:
            continue
        at_deg_s = np.rad2deg(np.abs(readings).max())
        cause = (
            f"gyro of body {body + 1}: saturation without a flag, its rates are cut off, at {at_deg_s:.0f} deg/s or "
            "less"
        )
        columns = _CUT_OFF_RAD_S * residuals.by_gyro(body, np.array(lacking))
        step = Advice("Set a wider range: ", NextStep("logger-settings"))
        yield Hypothesis("saturation", columns, fixed_words(cause), step, sensor=gyro_column(body))


def _plateaus(t_s: FloatArray, reading: FloatArray) -> Iterator[FloatArray]:
    """(n,) what readings near the greatest one may lack, knot by knot."""
    greatest = float(reading.max())
    if greatest < _FAST_RAD_S:
        return
    knots = np.arange(t_s[0], t_s[-1] + _PLATEAU_KNOT_S, _PLATEAU_KNOT_S)
    near = reading > _PLATEAU * greatest
    # Hat functions: what a plateau lacks may be any curve that is straight between the knots.
    for hat in np.eye(len(knots)):
        shape = np.interp(t_s, knots, hat)
        if (near & (shape > 0.0)).any():
            yield shape


def _pushes(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield pushes from outside, which change the momentum."""
    assert residuals.model is not None
    by_momentum, t_s = residuals.model.by_momentum, residuals.model.t_s
    # Inner blocks only: a step needs a momentum before it and one after.
    for at in range(1, len(t_s) - 1):
        step = by_momentum.copy()
        step[: at + 1] = 0.0
        # In the block of the push the momentum is neither the old nor the new one.
        during = np.zeros_like(step)
        during[at] = by_momentum[at]
        pushed = _PUSHED * np.concatenate([step, during], axis=2).reshape(-1, 6)
        cause = f"a push from outside at {t_s[at]:.1f} s: something touched the robot"
        yield Hypothesis(
            "push",
            residuals.stack(None, pushed),
            fixed_words(cause),
            "Look at the video, and at what hangs on the robot in the fall",
        )


def fixed_words(cause: str) -> Words:
    """Build the words of a cause that does not depend on the fault's numbers."""
    return lambda _: cause
