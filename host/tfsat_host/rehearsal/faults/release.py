"""Faults of the switches, the lift and the release."""

from __future__ import annotations

from tfsat_host.emulated.robot import BoardIndex
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, during
from tfsat_host.rehearsal.moment import Moment

BOUNCE_US = 50_000
KNOCK_US = 4_000
JOLT_US = 6_000
"""Both switches open for 5 ms are a release, whoever opened them; closed again for 200 ms, a false one."""


def _stuck_closed(day: Day) -> None:
    day.robot.faults.switch(1, "stuck-closed")


def _stuck_open(day: Day) -> None:
    day.robot.faults.switch(1, "stuck-open")


def _bounce(day: Day) -> None:
    day.robot.faults.bounce(BOUNCE_US)


def _knock_both(day: Day) -> None:
    for switch in (1, 2):
        day.robot.knock(switch, KNOCK_US)


def _jolt(day: Day) -> None:
    for switch in (1, 2):
        day.robot.knock(switch, JOLT_US)


def _not_armed(day: Day) -> None:
    day.arming = False


def _cable_pulled(day: Day) -> None:
    day.robot.set_cable(BoardIndex.SEQUENCER, False)


RELEASE_FAULTS = (
    Fault(
        "switch-stuck-closed",
        "Switch 1 shows closed for ever, and only switch 2 opens at the release.",
        Moment.ARMED,
        _stuck_closed,
        during(Moment.POWERED, Moment.RELEASE, Outcome.STANDS_STILL),
        noticed="holds no release",
        morning=(),
        part="switch 1",
    ),
    Fault(
        "switch-stuck-open",
        "Switch 1 shows open while the robot hangs in the releaser.",
        Moment.POWERED,
        _stuck_open,
        {
            **during(Moment.POWERED, Moment.RECORDING, Outcome.NOT_DROPPED),
            **during(Moment.ARMED, Moment.RELEASE, Outcome.FLIES),
        },
        noticed="A release switch is open (switch 1)",
        morning=("switches",),
        part="switch 1",
    ),
    Fault(
        "switch-bounce",
        f"Both switches' contacts chatter for {BOUNCE_US // 1000} ms at the release.",
        Moment.RELEASE,
        _bounce,
        during(Moment.POWERED, Moment.RELEASE, Outcome.FLIES),
        noticed="edges fit two releases",
    ),
    Fault(
        "lift-knock",
        f"A blow in the lift opens both switches for {KNOCK_US // 1000} ms.",
        Moment.LIFTED,
        _knock_both,
        {Moment.LIFTED: Outcome.FLIES},
    ),
    Fault(
        "crane-jolt",
        f"A jolt on the crane opens both switches for {JOLT_US // 1000} ms, as a release does, and the robot hangs on.",
        Moment.LIFTED,
        _jolt,
        {Moment.LIFTED: Outcome.FLIES},
        noticed="false release",
    ),
    Fault(
        "release-before-arming",
        "The robot is let go although nobody has armed it.",
        Moment.POWERED,
        _not_armed,
        during(Moment.POWERED, Moment.RECORDING, Outcome.STANDS_STILL),
        noticed="did not move",
    ),
    Fault(
        "cable-pulled-while-armed",
        "The sequencer's cable is pulled right after arming.",
        Moment.ARMED,
        _cable_pulled,
        {Moment.ARMED: Outcome.FLIES},
    ),
)
