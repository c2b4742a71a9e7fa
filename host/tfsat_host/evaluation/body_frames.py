"""Where the bodies pointed in the fall, at first sight: to look at, not to measure with.

The base body's attitude is its gyro integrated from the release, less the bias of its rest before; the other
bodies follow by the angle sensors, counted from that rest. No calibration: mounting as designed, scales as
in the datasheet, joints taken to be at zero before the release.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import BoolArray
from tfsat_host.evaluation.motion.attitude import integrate_rates
from tfsat_host.evaluation.quick_look import BIAS_GUARD_S, MIN_BIAS_S
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.export_mcap import BodyFrames, FrameTrack, JointTrack

WORLD = "world"
REST_S = 3.0
"""The rest is this much before the guard; earlier, people may still have been at the robot."""
STILL_DEG_S = 2.0
"""A rate that spreads by more is no rest: the gyro's own noise is a tenth of it."""
BRIDGED_S = 0.02
"""Over a longer hole in the base's rates the attitude is not carried: a stroke turns it by degrees."""


@dataclass(frozen=True, eq=False)
class _Spans:
    """Samples of the rest before the release, and of the fall: (n,) bool each."""

    rest: BoolArray
    fall: BoolArray


def body_frames(log: DropLog, model: RobotModel) -> BodyFrames:
    """Return the frames of all bodies from release to landing; anything unknown is a note, not an error."""
    if log.release_us is None:
        return BodyFrames((), (), ("No body transforms: the recording holds no release.",))
    spans = _Spans(
        rest=(log.t_s < -BIAS_GUARD_S) & (log.t_s >= -BIAS_GUARD_S - REST_S),
        fall=(log.t_s >= 0.0) & (log.t_us < _landing_us(log, log.release_us)),
    )
    notes = [
        "Body transforms and joint angles are an uncalibrated quick look: gyro less its rest before the "
        "release, angle sensors counted from that rest. Positions in the world are not measured."
    ]
    base = _base_track(log, model, spans, notes)
    joints = tuple(
        track for joint in range(model.n_joints) if (track := _joint_track(log, model, joint, spans, notes))
    )
    tracks = (*((base,) if base else ()), *_outer_tracks(model, joints))
    return BodyFrames(tracks, joints, tuple(notes))


def frame_name(name: str) -> str:
    """Return a body's or joint's name as used in frames and topics: `body 3` becomes `body_3`."""
    return name.replace(" ", "_")


def _landing_us(log: DropLog, release_us: int) -> int:
    """Return the time of the landing that the logger saw, or of the end of the longest fall."""
    ends = [event.t_us for event in log.events if event.name == "landing" and event.t_us > release_us]
    return min([release_us + FALL_US, *ends])


def _base_track(log: DropLog, model: RobotModel, spans: _Spans, notes: list[str]) -> FrameTrack | None:
    name = model.body_names[model.base]
    index = next(i for i, imu in enumerate(model.imus) if imu.body == model.base)
    valid = log.imu_valid[:, index]
    rest, fall = np.flatnonzero(spans.rest & valid), np.flatnonzero(spans.fall & valid)
    if not len(rest) or np.ptp(log.t_s[rest]) < MIN_BIAS_S:
        notes.append(f"No attitude: less than {MIN_BIAS_S:g} s of {name}'s gyro before the release.")
        return None
    if len(fall) < 2:
        notes.append(f"No attitude: {name}'s gyro gave nothing in the fall.")
        return None
    rates = log.rate_rad_s[:, index]
    spread = float(np.rad2deg(rates[rest].std(axis=0).max()))
    # Motion at rest spoils the bias, not the picture: note it and go on.
    if spread > STILL_DEG_S:
        notes.append(f"{name} moved before the release (±{spread:.1f} deg/s): its attitude will drift.")
    t_s = log.t_s[fall]
    # Prepend the release: a hole right after it counts, too.
    holes = np.flatnonzero(np.diff(t_s, prepend=0.0) > max(BRIDGED_S, 1.5 / log.header.rate_hz))
    if len(holes):
        # Attitude cannot be carried over a hole: keep what comes before the first.
        fall, t_s = fall[: holes[0]], t_s[: holes[0]]
        until_s = t_s[-1] if len(t_s) else 0.0
        notes.append(f"The attitude ends {until_s:.3f} s after the release: {name}'s gyro has a hole there.")
    if not len(fall):
        return None
    clipped = int(np.count_nonzero(log.clipped[fall, index]))
    if clipped:
        notes.append(f"{clipped} readings of {name} are clipped: the attitude lags behind the truth.")
    mounting = model.imus[index].sensor_to_body
    # Take off the bias in sensor axes, where it lives; then turn the rows into body axes.
    attitude = integrate_rates(t_s, (rates[fall] - rates[rest].mean(axis=0)) @ mounting.T)
    return FrameTrack(
        parent=WORLD,
        child=frame_name(name),
        t_us=log.t_us[fall],
        translation_m=np.zeros((len(fall), 3)),
        quaternion_xyzw=attitude.as_quat(),
    )


def _joint_track(
    log: DropLog, model: RobotModel, joint: int, spans: _Spans, notes: list[str]
) -> JointTrack | None:
    """Compute a joint's angle as the mean of its sensors that answered, each counted from its own rest."""
    name = model.joint_names[joint]
    total = np.zeros(len(log))
    answered = np.zeros(len(log), int)
    for index, sensor in enumerate(model.angle_sensors):
        valid = log.angle_valid[:, index]
        if sensor.joint != joint or not (spans.rest & valid).any():
            continue
        turned = log.sensor_angle_rad[:, index]
        # Average on the unit circle: the rest may lie at the sensor's wrap.
        zero = np.angle(np.exp(1j * turned[spans.rest & valid]).mean())
        # Wrap after the zero is taken off: within half a turn of rest there is no jump.
        change = sensor.direction * wrap_angle(turned - zero)
        total[valid] += change[valid]
        answered += valid
    tracked_rows = spans.fall & (answered > 0)
    if not tracked_rows.any():
        notes.append(f"No angle of {name}: none of its sensors answered both before the release and after.")
        return None
    return JointTrack(frame_name(name), log.t_us[tracked_rows], total[tracked_rows] / answered[tracked_rows])


def _outer_tracks(model: RobotModel, joints: tuple[JointTrack, ...]) -> tuple[FrameTrack, ...]:
    """Build the outer bodies' tracks from the base outward, each in the frame of the body it hangs on."""
    by_name = {track.name: track for track in joints}
    tracks = []
    reached = [model.base]
    # Breadth first from the base: the list grows while it is walked.
    for parent in reached:
        for joint in range(model.n_joints):
            inner, outer = int(model.joint_inner[joint]), int(model.joint_outer[joint])
            if parent not in (inner, outer):
                continue
            child = outer if parent == inner else inner
            if child in reached:
                continue
            # A joint without a track still leads on to the bodies beyond it.
            reached.append(child)
            track = by_name.get(frame_name(model.joint_names[joint]))
            if track is not None:
                # The joint's angle is that of the outer body relative to the inner one.
                sense = 1.0 if child == outer else -1.0
                tracks.append(_hinge_track(model, parent, child, joint, sense, track))
    return tuple(tracks)


def _hinge_track(
    model: RobotModel, parent: int, child: int, joint: int, sense: float, track: JointTrack
) -> FrameTrack:
    turn = Rotation.from_rotvec(sense * track.angle_rad[:, None] * model.joint_axis[joint])
    # The child turns about the hinge, not about its origin: parent's origin to hinge, then the turned arm.
    hinge = model.joint_point_m[joint] - model.origin_m[parent]
    arm = model.origin_m[child] - model.joint_point_m[joint]
    return FrameTrack(
        parent=frame_name(model.body_names[parent]),
        child=frame_name(model.body_names[child]),
        t_us=track.t_us,
        translation_m=hinge + turn.apply(arm),
        quaternion_xyzw=turn.as_quat(),
    )
