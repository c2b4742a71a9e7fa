"""The steps of an acceptance, in the order in which each rests on those before it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from typing import Final

from tfsat_host.acceptance import angle_wiring, imu_wiring
from tfsat_host.acceptance.bench import Bench, StillArmed, Task
from tfsat_host.acceptance.bench_run import check_supply, check_time
from tfsat_host.acceptance.hand_motion import find_opening_mistake, find_tilting_mistake
from tfsat_host.acceptance.record import Acceptance, StepResult
from tfsat_host.acceptance.servo_check import check_servos, closed_readings
from tfsat_host.acceptance.switch_wiring import check_switches
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.errors import Interrupted, TfsatError, UsageError
from tfsat_host.preflight.checks.card import judge_recording
from tfsat_host.preflight.logger_queries import Trace, judge_trial, record_and_remove
from tfsat_host.preflight.preflight_check import PreflightCheck, judge, no_go, not_made
from tfsat_host.protocol.enums import CardState, LoggerState, SequencerState
from tfsat_host.protocol.limits import SWITCH_COUNT

REST_S = 10.0
MOTION_S = 8.0
MAX_TRIES = 3
CARD_S = 60.0
Made = list[tuple[str, PreflightCheck]]


def _boards(bench: Bench, _before: Acceptance) -> Made:
    """Check that both boards are ready for all that follows."""
    sequencer, logger = bench.sequencer.status(), bench.logger.status()
    wrong = (
        [] if sequencer.state == SequencerState.SAFE else [f"the sequencer is {sequencer.state.name.lower()}"]
    )
    if logger.state not in (LoggerState.IDLE, LoggerState.STOPPED):
        wrong.append(f"the logger is {logger.state.name.lower()}")
    if logger.ram_holds_drop:
        wrong.append("the logger's RAM holds a drop that no card has (tfsat-host log fetch ram)")
    if logger.card != CardState.READY:
        wrong.append(f"the card is {logger.card.name.lower().replace('_', ' ')}")
    identities = "; ".join(board.identity.describe() for board in (bench.sequencer, bench.logger))
    found = f"{identities[:1].upper()}{identities[1:]}."
    return [
        (
            "boards",
            judge(
                wrong,
                "Boards: {}.",
                "Disarm, stop recordings, put in a card that works; repeat the step.",
                found,
            ),
        )
    ]


def _rest(bench: Bench, _before: Acceptance) -> Made:
    """Read the IMUs at rest."""
    bench.hands.do(Task.REST)
    samples = bench.read(REST_S)
    at_rest = imu_wiring.check_rest(samples, imu_wiring.answering(samples))
    return [("imus-answer", imu_wiring.check_answers(samples, bench.robot)), ("imus-at-rest", at_rest)]


def _motion(bench: Bench, _before: Acceptance) -> Made:
    """Have each joint opened, then the robot tilted; read IMUs and angle sensors."""
    joints = [
        _read_motion(bench, Task.OPEN_AND_CLOSE, joint, partial(find_opening_mistake, joint))
        for joint in bench.joints
    ]
    tilt = _read_motion(bench, Task.TILT, 0, find_tilting_mistake)
    loose, answers = imu_wiring.answering_throughout([*joints, tilt])
    still = tilt.t_s <= tilt.t_s[0] + angle_wiring.START_S
    travels = [angle_wiring.travel_deg(samples) for samples in joints]
    sensors = angle_wiring.check_sensors(travels, bench.robot)
    closed = closed_readings([angle_wiring.start_rad(samples) for samples in joints])
    made = [
        *([("imus-when-moved", loose)] if loose else []),
        ("angle-sensors", replace(sensors, evidence={**sensors.evidence, "closed_rad": closed})),
        ("joint-ranges", angle_wiring.check_ranges(travels, bench.robot)),
    ]
    if not answers.any():
        return [*made, ("imus-by-body", _see("imus-answer"))]
    turned = [imu_wiring.turned_rad(samples) for samples in joints]
    up, about_x = tilt.accel_m_s2[still].mean(axis=0), imu_wiring.turned_rad(tilt)
    places = imu_wiring.check_places(turned, answers)
    # Of an IMU on another body the robot file says nothing.
    axes = _see("imus-by-body") if places.blocks else imu_wiring.check_axes(up, about_x, answers, bench.robot)
    return [("imus-by-body", places), ("imu-axes", axes), *made]


def _read_motion(
    bench: Bench, task: Task, number: int, find_mistake: Callable[[SensorSamples], str]
) -> SensorSamples:
    """Have a motion done and read it, again where hands did not do what was asked. Raises TfsatError: too often."""
    mistake = ""
    for _ in range(MAX_TRIES):
        if mistake:
            bench.note(f"  {mistake}. Once more:")
        bench.hands.do(task, number)
        samples = bench.read(MOTION_S)
        mistake = find_mistake(samples)
        if not mistake:
            return samples
    raise TfsatError(
        what=f"{mistake}.",
        meaning="Nothing was concluded from the motions.",
        next_step="Repeat the step.",
    )


def _switches(bench: Bench, _before: Acceptance) -> Made:
    """Have each switch pressed, and ask both boards what they see."""
    seen = []
    for number in range(SWITCH_COUNT + 1):
        bench.hands.do(Task.PRESS if number else Task.FREE_SWITCHES, number)
        bench.sequencer.wait(0.5)
        sequencer, logger = bench.sequencer.status(), bench.logger.status()
        seen.append({"sequencer": sequencer.switches_open, "logger": logger.switches_open})
    return [("switches", check_switches(seen))]


def _card(bench: Bench, before: Acceptance) -> Made:
    """Record for a minute and read it back."""
    if blocking := _blocking(before, "boards"):
        return [("card", _see(blocking))]

    def wait() -> None:
        with bench.progress("Recording onto the card", CARD_S) as advance:
            for _ in range(round(CARD_S)):
                bench.logger.wait(1.0)
                advance(1.0)

    trace = Trace()
    try:
        trial = record_and_remove(bench.logger, bench.logger.status(), trace, wait, judge_trial)
    finally:
        if trace.left:
            bench.note(f"  {trace.left}")
    return [("card", judge_recording(trial))]


def _time(bench: Bench, before: Acceptance) -> Made:
    """Let the logger date the sequencer's strokes."""
    if blocking := _blocking(before, "boards", "switches"):
        return [("stroke-line", _see(blocking))]
    names = ("stroke-line", "clock-ratio", "stroke-times", "release-dates")
    closed = None if _blocking(before, "angle-sensors") else before.evidence("angle-sensors", "closed_rad")
    return list(zip(names, check_time(bench, closed), strict=False))


def _servos(bench: Bench, before: Acceptance) -> Made:
    """Jog each joint."""
    if blocking := _blocking(before, "angle-sensors"):
        return [("servos", _see(blocking))]
    closed = before.evidence("angle-sensors", "closed_rad")
    return list(zip(("servos", "end-stops"), check_servos(bench, closed), strict=True))


def _supply(bench: Bench, before: Acceptance) -> Made:
    """Start servos together."""
    blocking = _blocking(before, "switches", "angle-sensors", "servos")
    closed = before.evidence("angle-sensors", "closed_rad")
    return [("supply", _see(blocking) if blocking else check_supply(bench, closed))]


@dataclass(frozen=True, slots=True)
class AcceptanceStep:
    """A step.

    Attributes:
        name: For people and in the record.
        title: What is looked at.
        make: Does it, given what was shown before.
    """

    name: str
    title: str
    make: Callable[[Bench, Acceptance], Made]


STEPS: Final = (
    AcceptanceStep("boards", "Boards and card", _boards),
    AcceptanceStep("rest", "IMUs at rest", _rest),
    AcceptanceStep("motion", "IMUs and angle sensors, moved by hand", _motion),
    AcceptanceStep("switches", "Release switches", _switches),
    AcceptanceStep("card", f"A recording of {CARD_S:g} s", _card),
    AcceptanceStep("time", "Loopback of time, servos without power", _time),
    AcceptanceStep("servos", "Servos", _servos),
    AcceptanceStep("supply", "Supply, servos starting together", _supply),
)

OF_SEQUENCER: Final = ("boards", "switches", "time", "servos", "supply")
"""Steps that another sequencer ends: they look at its wires. Another logger ends all of them."""


def _blocking(before: Acceptance, *names: str) -> str:
    """Return the first of these checks that was not passed; empty: all were."""
    passed = {check.name for check in before.checks if not check.blocks}
    return next((name for name in names if name not in passed), "")


def _see(check: str) -> PreflightCheck:
    return not_made(f"It waits for {check}, which has to be right first.", f"See {check}.")


def make_step(step: AcceptanceStep, bench: Bench, before: Acceptance) -> StepResult:
    """Do a step; what a board refuses is its finding.

    Raises:
        Interrupted, KeyboardInterrupt: a person ended the session.
        StillArmed: the sequencer could not be disarmed.
        PortError: the link to a board broke; the sequencer was disarmed.
        UsageError: there is nobody to ask.
    """
    try:
        made = step.make(bench, before)
    except StillArmed:
        raise
    except BaseException as error:
        # Whatever went wrong, nothing stays armed or driven.
        bench.disarm()
        if not isinstance(error, TfsatError) or isinstance(error, Interrupted | PortError | UsageError):
            raise
        made = [(step.name, no_go(f"{step.title}: {error.what} {error.meaning}".rstrip(), error.next_step))]
    checks = tuple(replace(check, name=name) for name, check in made)
    return StepResult(step.name, datetime.now(UTC), checks)
