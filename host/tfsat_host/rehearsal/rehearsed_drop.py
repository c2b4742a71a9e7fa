"""One drop on the emulated robot: bias, upload, preflight, record, arm, lift, wait, release, fall, land, fetch.

It goes as a careful team would go: what a preflight or a board refuses ends the day before anything is let go. Faults
change what happens at the moments between.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.arrays import FloatArray
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.last_run import holds_what_flew
from tfsat_host.devices.log_transfer import RAM
from tfsat_host.emulated.emulated_robot import FALL_S, SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import Schedule
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply
from tfsat_host.rehearsal import day as days
from tfsat_host.rehearsal.day import Day, DayRecord, NoGo, Preflight
from tfsat_host.rehearsal.faults.fault import GUARD_US, Fault, Moment
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel
from tfsat_host.run.held_maneuver import HeldManeuver

Progress = Callable[[str], None]

PREPARING_S = 300.0
"""Between power-up and the first question to a board, compressed: see `EmulatedRobot.wait`."""
HANG_US = 3 * US_PER_S
"""In the releaser before the lift: the biases are checked against this."""
KNOCK_US = 20_000
HOOK_S = 300.0
"""On the crane's hook, compressed."""
HOOK_US = 2 * US_PER_S
"""Spent there after the blow and, from its half on, after the compressed minutes."""
AFTER_LANDING_US = 900_000
RAM_TIMEOUT_S = 60.0
"""A logger whose card failed takes a drop to its end in RAM before it lists anything."""
TRUTH_PERIOD_US = 1000
STEPS = 7
"""Of the progress of one day."""
_LOST = "The logger recorded no longer: it had lost its power or its card, or had ended the recording."


@dataclass(eq=False, kw_only=True)
class Drop(DayRecord):
    """What a rehearsed day leaves behind.

    Attributes:
        card: The newest recording on the card, byte by byte; empty if there is none.
        from_ram: That recording was fetched from the logger's RAM instead.
        sequencer: Its status after the landing; None: it does not answer.
        held_maneuver: That it held then; None: it does not answer.
        recording: The logger's account of the recording; None: it does not answer, or has none.
        collected: When the card was taken out, by the team's clock.
        truth: See `EmulatedRobot.truth`; from the start of the recording.
        robot: That flew: as it was drawn, and what faults made of it.
        released_s: Virtual time at which both switches first were open; None: it was not let go.
        landed_s: Virtual time of the landing; None: it was not let go.
        refused: What ended the day before the drop; None: nothing did.
        faults: Of the day.
    """

    card: bytes
    from_ram: bool
    sequencer: SequencerStatusReply | None
    held_maneuver: HeldManeuver | None
    recording: RecordStopReply | None
    collected: datetime
    truth: FloatArray
    robot: Truth
    released_s: float | None
    landed_s: float | None
    refused: TfsatError | None
    faults: tuple[Fault, ...]

    @property
    def fall_s(self) -> float:
        """Time from the release to the landing; 0 if nothing fell."""
        return (self.landed_s or 0.0) - (self.released_s or 0.0)


def rehearse(
    schedule: Schedule,
    filed: RobotModel,
    truth: Truth,
    *,
    hex_path: Path | None = None,
    preflight: Preflight | None = None,
    faults: Sequence[Fault] = (),
    bench: bool = True,
    progress: Progress = lambda _: None,
) -> Drop:
    """Rehearses one day, from power-up to the card on the desk.

    Args:
        schedule: What to fly.
        filed: The robot as its file has it: the calibration is in its terms.
        truth: The robot that flies, but for what faults make of it.
        hex_path: The sequencer's image; None runs its core natively.
        preflight: What is checked before the recording; None: nothing is.
        faults: What goes wrong.
        bench: As of `day.begun`.
        progress: Called with what is going on.

    Raises:
        TfsatError: without a fault and a preflight, whatever a board refuses.
    """
    faults = tuple(fault.with_moving(schedule.moving_at_once) for fault in faults)
    for fault in faults:
        # Hidden mismatches change the robot itself, so they come before it is made.
        truth = fault.apply(truth)
    with EmulatedRobot(
        truth.model,
        imperfections=truth.imperfections,
        seed=truth.seed,
        session_seed=session_seed(schedule, truth, hex_path, faults),
        hex_path=hex_path,
    ) as robot:
        progress("on the bench; the gyros' biases are taken")
        day = days.begin_day(robot, schedule, filed, truth, bench=bench)

        def at(moment: Moment) -> None:
            for fault in faults:
                if fault.moment is moment:
                    # Take the time first: an injection may let time pass, or raise.
                    day.injected_s[fault.name] = robot.now_us / US_PER_S
                    fault.inject(day)

        refused = None
        try:
            _prepare(day, preflight, at, progress)
        except TfsatError as error:
            # Only faults and a NO-GO explain a refusal: any other is an error of the caller or a bug.
            if not faults and not isinstance(error, NoGo):
                raise
            refused = error
        if refused is None:
            _fall(day, truth, at, progress)
        progress("cables plugged; the recording is closed")
        return _collect_drop(day, truth, refused, faults)


def _prepare(day: Day, preflight: Preflight | None, at: Callable[[Moment], None], progress: Progress) -> None:
    """Upload the schedule, run the preflight, start recording, and arm.

    Raises what the preflight or a board refuses.
    """
    robot = day.robot
    at(Moment.POWERED)
    # Five minutes of warming and wandering biases, at no cost of computing.
    robot.wait(PREPARING_S)
    progress("uploading, reading back")
    # A maneuver of overlapping strokes flies where the team has found that the supply carries it.
    settings = day.sequencer.settings().settings
    if day.schedule.moving_at_once > settings.moving_at_once:
        day.sequencer.write_settings(replace(settings, moving_at_once=day.schedule.moving_at_once))
    day.upload = day.sequencer.upload(day.schedule)
    at(Moment.UPLOADED)
    if preflight is not None:
        progress("preflight")
        # The preflight dates the logger's recordings, for which the logger needs the time of day.
        day.logger.set_clock(round(day.unix_s() * US_PER_S))
        day.preflight = preflight.run(day)
        if not day.preflight.go and not preflight.despite:
            raise NoGo(day.blocking)
    at(Moment.CHECKED)
    progress("recording in the releaser")
    # The truth starts with the recording, so that every sample has one to be compared with.
    robot.record_truth(TRUTH_PERIOD_US)
    day.logger.start_recording(unix_us=round(day.unix_s() * US_PER_S), maneuver_crc=day.upload.stored.crc)
    # A recording that the card does not take would show only after the landing.
    day.logger.wait_for_card()
    at(Moment.RECORDING)
    # A rest before the lift, against which the evaluation checks the biases.
    robot.advance(HANG_US)
    if day.arming:
        day.sequencer.arm()
    at(Moment.ARMED)


def _fall(day: Day, truth: Truth, at: Callable[[Moment], None], progress: Progress) -> None:
    robot = day.robot
    progress("armed; cables pulled; the crane lifts, one switch is knocked")
    # From here on no host can help: the boards fly by what they store.
    for board in BoardIndex:
        robot.set_cable(board, False)
    # One switch alone is a knock: the sequencer must wait for both.
    robot.knock(1, KNOCK_US)
    robot.advance(HOOK_US // 2)
    at(Moment.LIFTED)
    # The hook's minutes are compressed; in the seconds on either side both firmwares run.
    robot.wait(HOOK_S)
    robot.advance(HOOK_US - HOOK_US // 2)
    at(Moment.RELEASE)
    progress("release, fall, landing")
    fall_us = round(FALL_S * US_PER_S)
    day.landed_us = landed_us = robot.now_us + fall_us
    robot.drop(truth.rate_rad_s.tolist())
    # Step through the fall, stopping where faults may be injected; one that took time itself is not waited for.
    for moment, t_us in (
        (Moment.FALLING, landed_us - fall_us + fall_us // 2),
        (Moment.BEFORE_LANDING, landed_us - GUARD_US),
        (Moment.LANDING, landed_us),
        (Moment.LANDED, landed_us + GUARD_US),
    ):
        _advance_to(robot, t_us)
        at(moment)
    _advance_to(robot, landed_us + GUARD_US + AFTER_LANDING_US)


def _advance_to(robot: EmulatedRobot, t_us: int) -> None:
    """Advance the robot to `t_us`, unless a fault has let that time pass already."""
    robot.advance(max(0, t_us - robot.now_us))


def _collect_drop(day: Day, robot_was: Truth, refused: TfsatError | None, faults: Sequence[Fault]) -> Drop:
    """Cables plugged, power on, the recording closed, the card taken out."""
    robot, fell = day.robot, refused is None
    # Undo what faults and the crane did: every board has its supply and its cable again.
    for board in BoardIndex:
        robot.set_power(board, True)
        robot.set_cable(board, True)
    robot.advance(SETTLE_US)
    status: SequencerStatusReply | None = None
    recording: RecordStopReply | None = None
    held_maneuver: HeldManeuver | None = None
    ram = b""
    try:
        day.reconnect()
        status = day.sequencer.status()
        recording = day.logger.stop_recording()
        held_maneuver = HeldManeuver(
            day.sequencer.read_back(), day.sequencer.identity.serial, holds_what_flew(status)
        )
    except TfsatError as error:
        # A board that lost its power has no recording to close: its card shows what there is.
        if fell:
            closed = isinstance(error, BoardError) and error.code is ErrorCode.NOT_RECORDING
            meaning = f"{error.meaning} {_LOST}" if closed else error.meaning
            day.setbacks.append(f"{error.what} {meaning}")
            # A card that failed may have left the drop in the logger's RAM, as long as it keeps its power.
            ram = _fetch_ram(day)
    return Drop(
        **{shared.name: getattr(day, shared.name) for shared in fields(DayRecord)},
        card=ram or robot.card(),
        from_ram=bool(ram),
        sequencer=status,
        held_maneuver=held_maneuver,
        recording=recording,
        collected=datetime.fromtimestamp(day.unix_s(), UTC),
        truth=robot.truth(),
        robot=robot_was,
        released_s=robot.released_us / US_PER_S if fell else None,
        landed_s=day.landed_us / US_PER_S if fell else None,
        refused=refused,
        faults=tuple(faults),
    )


def _fetch_ram(day: Day) -> bytes:
    """Fetch a drop that the card did not take from the logger's RAM; empty if there is none.

    Works as `tfsat-host log fetch ram` does.
    """
    if not day.logger.status().ram_holds_drop:
        return b""
    entries = day.logger.wait_for_listing(RAM_TIMEOUT_S).entries
    entry = next(log_entry for log_entry in entries if log_entry.number == RAM)
    image = day.logger.fetch_whole(entry)
    fetched = NextStep("log fetch", ("ram",))
    day.setbacks.append(Advice("The drop was fetched from the logger's RAM: ", fetched, "."))
    return image


def session_seed(schedule: Schedule, truth: Truth, hex_path: Path | None, faults: Sequence[Fault]) -> int:
    """Compute the seed of the logger's session ids.

    It differs with whatever makes another drop, and repeats for the same drop.
    """
    image = b"" if hex_path is None else hex_path.read_bytes()
    # A fault of size 0 changes nothing, so it must not change the ids either.
    names = tuple(fault.name for fault in faults if not fault.is_zero)
    rate = tuple(map(float, truth.rate_rad_s))
    # Hash all that makes another drop; Python's own hash would differ from process to process.
    drop = repr((truth.seed, schedule.strokes, schedule.speed_cdeg_s, rate, truth.imu, names))
    return int.from_bytes(hashlib.sha256(drop.encode() + b"\0" + image).digest()[:8], "little")
