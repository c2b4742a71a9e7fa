"""One drop, evaluated: what the robot did, whether the model knew, and how sure both are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray, describe_fields
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.evaluation.checks.check import Cause, Check, SensorColumn
from tfsat_host.evaluation.clocks import Clocks
from tfsat_host.evaluation.com_fit.identifiability import Identifiability
from tfsat_host.evaluation.com_fit.model_comparison import ModelComparison
from tfsat_host.evaluation.com_fit.paper_swarm import SwarmFit
from tfsat_host.evaluation.fall_instants import FallInstants
from tfsat_host.evaluation.laser_velocity import ReleaseVelocity
from tfsat_host.evaluation.micro_gravity import MicroGravity
from tfsat_host.evaluation.motion.attitude import BodyMotion
from tfsat_host.evaluation.motion.motion import InitialRate, Motion
from tfsat_host.evaluation.rest import Rest
from tfsat_host.evaluation.standing_joints import JointRest
from tfsat_host.evaluation.strokes import FlownStroke
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

SENSED = frozenset({"rates", "attitudes", "strokes"})
"""What gyros and angle sensors tell without the model: wrong by what their certificate is wrong by."""
CERTIFICATE, AXES_FILED = "certificate", "robot file's joint axes"


@dataclass(frozen=True, eq=False)
class Turn:
    """How a body has turned from the release to the end of the evaluation.

    Attributes:
        angle_rad: Of the whole rotation: the reorientation.
        std_rad: Its standard deviation.
        rotation_vector_rad: (3,) axes of the body at the release.
        covariance: (3, 3) of the attitude, the same axes, rad^2.
        euler_zyx_rad: (3,).
        bridged: Some of its gyro's samples are missing and were bridged from other bodies.
    """

    angle_rad: float
    std_rad: float
    rotation_vector_rad: FloatArray
    covariance: FloatArray
    euler_zyx_rad: FloatArray
    bridged: bool

    @classmethod
    def of(cls, body: BodyMotion) -> Turn:
        """Compute the turn of one body."""
        angle, std = body.reorientation_rad()
        last: Rotation = body.attitude[-1]
        return cls(
            angle,
            std,
            last.as_rotvec(),
            body.covariance(),
            euler_zyx_rad(last.as_matrix()),
            bool(body.bridged.any()),
        )

    @classmethod
    def withheld(cls) -> Turn:
        """Return a withheld turn: NaN throughout."""
        return cls(np.nan, np.nan, np.full(3, np.nan), np.full((3, 3), np.nan), np.full(3, np.nan), False)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """One drop, evaluated; times after the release.

    Attributes:
        log: The recording.
        model: The robot as its file has it.
        calibration: What it was evaluated with; what stood in for something missing is in `notes`.
        schedule: What was commanded; None: unknown.
        notes: What could not be used, and what stood in for it; a sentence each.
        rest: Before the release.
        instants: Release and landing as the accelerometers felt them.
        micro_gravity: Its quality.
        clocks: Of sequencer and video against the logger's; None without a schedule.
        release_velocity: By the laser spots; None without them.
        motion: Joint angles, rates, attitudes.
        turns: Of bodies 1 to 4.
        initial_rates: Of bodies 1 to 4, between release and first stroke.
        strokes: Commanded and flown.
        standing: What the joints did while nothing commanded them; empty without a schedule.
        explained: The model against the measurement, before and after its correction.
        identifiability: What the data can tell of the correction, and what not.
        checks: Of integrity, without any truth.
        swarm: The paper's search for the same correction; None: not asked for.
        widening: Factor on the standard deviations of `widened`, so that the sensors do not contradict each other.
        widened: `CERTIFICATE` or `AXES_FILED`.
        withheld: Names of the results that are not given (NaN), as of `Check.protects`, each with the check that failed
            farthest above its limit.
        widest: Times that the stated errors were taken in vain; 1: not tried, as greater errors describe no such cause.
        left_out: The one sensor that the results do without, as it contradicts all others; None: all were used.
    """

    log: DropLog
    model: RobotModel
    calibration: Calibration
    schedule: Schedule | None
    notes: tuple[str, ...]
    rest: Rest
    instants: FallInstants
    micro_gravity: MicroGravity
    clocks: Clocks | None
    release_velocity: ReleaseVelocity | None
    motion: Motion
    turns: tuple[Turn, ...]
    initial_rates: tuple[InitialRate, ...]
    strokes: tuple[FlownStroke, ...]
    standing: tuple[JointRest, ...]
    explained: ModelComparison
    identifiability: Identifiability
    checks: tuple[Check, ...]
    swarm: SwarmFit | None
    widening: float = 1.0
    widened: str = CERTIFICATE
    withheld: Mapping[str, str] = field(default_factory=dict)
    widest: float = 1.0
    left_out: SensorColumn | None = None

    __repr__ = describe_fields

    def is_given(self, *results: str) -> bool:
        """Return whether none of these results is withheld.

        Without names, none of those that gyros and angle sensors measure.
        """
        return not self.withheld.keys() & (set(results) or SENSED)

    @property
    def reorientation(self) -> Turn:
        """Of body 1: the paper's."""
        return self.turns[0]

    def with_withheld(self, withheld: Mapping[str, str]) -> Evaluation:
        """Without the results of these names."""
        return replace(
            self,
            withheld=withheld,
            turns=tuple(Turn.withheld() if "attitudes" in withheld else turn for turn in self.turns),
            initial_rates=tuple(
                InitialRate.withheld() if "rates" in withheld else rate for rate in self.initial_rates
            ),
            # Strokes come of gyros and angle sensors together: any result of either withholds them.
            strokes=tuple(
                stroke.withheld() if SENSED & withheld.keys() else stroke for stroke in self.strokes
            ),
            standing=() if SENSED & withheld.keys() else self.standing,
            # Body 2's turning, by its gyro, was taken off the spots: without rates no velocity.
            release_velocity=None if "rates" in withheld else self.release_velocity,
        )

    @property
    def failed_checks(self) -> tuple[Check, ...]:
        """Those that say that something is wrong."""
        return tuple(check for check in self.checks if check.verdict == "failed")

    @property
    def causes(self) -> tuple[Cause, ...]:
        """What failed checks may come from, the likeliest first; empty if there was nothing to compare causes of."""
        return next((check.causes for check in self.failed_checks if check.causes), ())
