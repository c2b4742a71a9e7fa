"""From visits to a servo map: weighted least squares, with what repeated visits and the places' bends add.

A visit's angle is a straight line in the pulse, less half the backlash in the direction of the motion, plus the
servo's scatter from arrival to arrival, plus the sensors' error. Scatter comes from visits to the same pulse from the
same side; what the places' means deviate from the line beyond that is the servo's bend. Both variances are
estimated by moments (Searle, Casella, McCulloch, "Variance Components", chapter 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Final

import numpy as np
from scipy.special import fdtri

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint
from tfsat_host.calibration.statistics import student_t_factor
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import NS_PER_US

MIN_STD_RAD: Final = np.deg2rad(0.001)
"""No sensor is better; visits without an error of their own would have no weight."""
CHANCE: Final = 0.9999
"""Of a straight servo, about so many measurements are not called bent."""


def fit_servo_map(
    points: Sequence[ServoPoint], joint: int, setting: ServoSetting, recorded_at: datetime
) -> ServoMap:
    """Fit the servo map to the visits.

    Args:
        points: In any order. Visits with an unknown direction (0) are left out.
        joint: 1 to 3.
        setting: The joint's setting in force on the board while it was measured.
        recorded_at: When that was.

    Raises:
        CalibrationError: too few visits, too small a range, or the servo is dead, reversed, slipping or bent.
    """
    directed_points = [point for point in points if point.direction]
    pulse_us = np.array([point.pulse_us for point in directed_points])
    direction = np.array([point.direction for point in directed_points], dtype=np.float64)
    reached_rad = np.array([point.reached_rad for point in directed_points])
    variance = np.maximum([point.std_rad for point in directed_points], MIN_STD_RAD) ** 2
    # A place is a pulse; a side is a pulse with the direction from which the joint arrived.
    place, side = _places(pulse_us), _places(np.column_stack([pulse_us, direction]))
    # Degrees of freedom within the sides: one mean is taken off each.
    repeats = side.shape[1] - side.shape[0]
    # Enough visits and range first: without them neither following nor fit can be judged.
    check_number(joint, place.shape[0], repeats, direction)
    check_range(joint, pulse_us, setting)
    check_following(joint, pulse_us, reached_rad, setting)

    arrival = _arrival_variance(side, reached_rad, variance, repeats)
    # Centred pulses make offset and slope nearly independent.
    middle_us = float((pulse_us.min() + pulse_us.max()) / 2)
    # Columns of middle, slope and backlash: the joint stops short by half the backlash either way.
    design = np.column_stack([np.ones(len(directed_points)), pulse_us - middle_us, -direction / 2])
    estimate, covariance, bend, excess = _least_squares(
        design, reached_rad, variance + arrival, place, repeats
    )
    # F quantile with (places - 2, repeats) degrees of freedom: only more is certainly a bend.
    by_chance = float(fdtri(place.shape[0] - 2, repeats, CHANCE))
    check_fit(joint, np.sqrt(arrival), np.sqrt(bend), certain=excess > by_chance)
    return ServoMap(
        joint=joint,
        middle_us=middle_us,
        middle_rad=float(estimate[0]),
        slope_rad_per_us=float(estimate[1]),
        backlash_rad=float(estimate[2]),
        covariance=covariance,
        repeatability_rad=float(np.sqrt(arrival)),
        repeats=repeats,
        nonlinearity_rad=float(np.sqrt(bend)),
        places=place.shape[0],
        pulse_range_us=(float(pulse_us.min()), float(pulse_us.max())),
        setting=setting,
        recorded_at=recorded_at,
    )


def _places(keys: FloatArray) -> FloatArray:
    """(groups, n): 1 where a visit belongs to the group of those with an equal key."""
    if len(keys) == 0:
        return np.zeros((0, 0))
    groups, index = np.unique(keys, axis=0, return_inverse=True)
    return np.asarray(np.arange(len(groups))[:, None] == index.reshape(1, -1), dtype=np.float64)


def _arrival_variance(side: FloatArray, reached_rad: FloatArray, variance: FloatArray, repeats: int) -> float:
    """Estimate the variance of a single arrival, without the sensors' part."""
    visits = side.sum(axis=1)
    # Deviations from the side's mean hold neither line nor bend, only scatter and noise.
    residuals = reached_rad - side.T @ (side @ reached_rad / visits)
    # Moments: subtract what the sensors' noise alone makes of the sum of squares; never below zero.
    of_sensors = variance @ (1.0 - side.T @ (1.0 / visits))
    return float(max((residuals @ residuals - of_sensors) / repeats, 0.0))


def _least_squares(
    design: FloatArray, reached_rad: FloatArray, variance: FloatArray, place: FloatArray, repeats: int
) -> tuple[FloatArray, FloatArray, float, float]:
    """Fit the line through the visits by weighted least squares.

    Returns:
        (3,) middle, slope and backlash; (3, 3) their covariance, including scatter and bends; the variance of
        the places' bends; and the ratio of the places' squared deviations to those expected from scatter
        alone.
    """
    inverse = np.linalg.inv((design.T / variance) @ design)
    # The estimate is linear in the visits: gain @ error is what any error does to it.
    gain = inverse @ (design.T / variance)
    estimate = gain @ reached_rad
    # What is left of a place's mean is its bend, common to all its visits, plus averaged scatter.
    means = place / place.sum(axis=1, keepdims=True)
    mean_residuals = means @ (reached_rad - design @ estimate)
    # What scatter alone would leave of the means, and what a bend of unit variance would.
    of_scatter = np.trace(means @ (np.diag(variance) - design @ inverse @ design.T) @ means.T)
    of_bends = np.sum((means @ (place.T - design @ gain @ place.T)) ** 2)
    bend = float(max((mean_residuals @ mean_residuals - of_scatter) / of_bends, 0.0))
    excess = float(mean_residuals @ mean_residuals / of_scatter)
    # A bend displaces all visits of its place together, so it does not average out within them.
    of_places = gain @ place.T
    covariance = (
        student_t_factor(repeats) * inverse
        + student_t_factor(len(place) - 2) * bend * of_places @ of_places.T
    )
    return estimate, covariance, bend, excess


# Two parameters of the line from five places leave three degrees of freedom, the fewest `few` takes.
MIN_PLACES: Final = 5
MIN_REPEATS: Final = 4
MIN_RANGE_DEG: Final = 20.0
"""Of the commanded angles; less does not determine the slope."""
MIN_FOLLOWING_SHARE: Final = 0.1
"""A joint that moves by less than this part of what was commanded does not follow."""
MAX_SCATTER_RAD: Final = np.deg2rad(5.0)
"""Of a single arrival. The paper's first stroke missed by 4.2 deg (section "Result"); a gear that slips
does worse."""
MAX_NONLINEARITY_RAD: Final = np.deg2rad(1.5)
"""What the places may deviate from a straight line."""
_NOTHING_KEPT = "The board keeps its servo settings."


def check_number(joint: int, places: int, repeats: int, direction: FloatArray) -> None:
    """Refuses what is too little to separate a line, backlash, bends and scatter. Raises CalibrationError."""
    if places >= MIN_PLACES and repeats >= MIN_REPEATS and len(np.unique(direction)) == 2:
        return
    raise CalibrationError(
        what=f"Joint {joint} was measured at {places} angles with {repeats} repeated visits; at least "
        f"{MIN_PLACES} and {MIN_REPEATS} are needed, opening and closing.",
        meaning=f"Slope, backlash and scatter could not be separated. {_NOTHING_KEPT}",
        next_step=Advice("Let the measurement run to its end: ", _again(joint)),
    )


def check_range(joint: int, pulse_us: FloatArray, setting: ServoSetting) -> None:
    """Refuses too small a range of commanded angles. Raises CalibrationError."""
    commanded_deg = _commanded_span_deg(pulse_us, setting)
    if commanded_deg < MIN_RANGE_DEG:
        raise CalibrationError(
            what=f"Joint {joint} was measured over {commanded_deg:.1f} deg only; at least "
            f"{MIN_RANGE_DEG:.0f} are needed.",
            meaning=f"Its slope would be little more than a guess. {_NOTHING_KEPT}",
            next_step=Advice(
                f"Widen limits_deg of joint {joint} to what it can do without touching anything (",
                NextStep("upload-servos"),
                "), then: ",
                _again(joint),
            ),
        )


def check_following(joint: int, pulse_us: FloatArray, reached_rad: FloatArray, setting: ServoSetting) -> None:
    """Refuses a servo that stays where it is, or goes the wrong way. Raises CalibrationError."""
    commanded_deg = _commanded_span_deg(pulse_us, setting)
    # An unweighted line: only size and sign of the motion are judged here.
    slope, offset_rad = (float(value) for value in np.polyfit(pulse_us, reached_rad, 1))
    followed_deg = float(np.rad2deg(slope * np.ptp(pulse_us))) * (-1.0 if setting.reversed else 1.0)
    if abs(followed_deg) < MIN_FOLLOWING_SHARE * commanded_deg:
        raise CalibrationError(
            what=f"Joint {joint} did not follow: {commanded_deg:.0f} deg were commanded, and its sensors saw "
            f"{abs(followed_deg):.1f} deg.",
            meaning=f"The servo has no power or no signal, or is broken: it would not stroke in the drop. "
            f"{_NOTHING_KEPT}",
            next_step=Advice(
                f"Check the servos' battery, the plug of servo {joint} and its horn's screw (",
                _small_angle(joint),
                " moves it), then: ",
                _again(joint),
            ),
        )
    if followed_deg < 0:
        # The zero pulse is where the fitted line crosses angle zero.
        turned = (
            f"reversed = {'false' if setting.reversed else 'true'} and zero_us = {-offset_rad / slope:.0f}"
        )
        raise CalibrationError(
            what=f"Joint {joint} moves the wrong way: it closed by {-followed_deg:.0f} deg where it was "
            f"to open "
            f"by {commanded_deg:.0f}.",
            meaning=f"Every stroke of it would be driven against the robot itself. {_NOTHING_KEPT}",
            next_step=Advice(
                "Write the settings to a file: ",
                NextStep("upload-servos", ("--show", "--out", "servos.toml")),
                f"\nThere, for joint {joint}, set {turned} (if that is not within {SERVO_PULSE_MIN_US} to "
                f"{SERVO_PULSE_MAX_US}, mount the horn again), then: ",
                NextStep("upload-servos", ("servos.toml",)),
                "\nTry a small angle, ",
                _small_angle(joint),
                ", then: ",
                _again(joint),
            ),
        )


def check_fit(joint: int, repeatability_rad: float, nonlinearity_rad: float, *, certain: bool) -> None:
    """Refuses a servo whose arrivals or places are too far from any straight line.

    Args:
        joint: 1 to 3.
        repeatability_rad: As in `ServoMap`.
        nonlinearity_rad: As in `ServoMap`.
        certain: Scatter alone does not explain the places' deviations.

    Raises:
        CalibrationError: they are.
    """
    if repeatability_rad > MAX_SCATTER_RAD:
        raise CalibrationError(
            what=f"Joint {joint} came to rest elsewhere each time: the same pulse scattered by "
            f"{np.rad2deg(repeatability_rad):.1f} deg; at most {np.rad2deg(MAX_SCATTER_RAD):.0f} are "
            f"plausible.",
            meaning=f"Its gear or horn slips, or it was touched; no settings can correct that. {_NOTHING_KEPT}",
            next_step=Advice(
                "Tighten the horn's screw, look at the gear, keep hands and cables away, then: ",
                _again(joint),
            ),
        )
    if certain and nonlinearity_rad > MAX_NONLINEARITY_RAD:
        raise CalibrationError(
            what=f"Joint {joint} is not a straight line in its pulses: its places deviate by "
            f"{np.rad2deg(nonlinearity_rad):.1f} deg; at most {np.rad2deg(MAX_NONLINEARITY_RAD):.1f} are allowed.",
            meaning="It meets a stop or a cable on its way, or the servo is worn; "
            f"the board's settings know straight lines only. {_NOTHING_KEPT}",
            next_step=Advice(
                "Free the joint over its whole range, or narrow limits_deg to what it does freely, then: ",
                _again(joint),
            ),
        )


def _commanded_span_deg(pulse_us: FloatArray, setting: ServoSetting) -> float:
    return float(np.ptp(pulse_us)) * NS_PER_US / setting.ns_per_deg


def _again(joint: int) -> NextStep:
    return NextStep("calibrate servo", ("--joint", str(joint)))


def _small_angle(joint: int) -> NextStep:
    return NextStep("jog", ("--joint", str(joint), "--from", "0", "--to", "10"))
