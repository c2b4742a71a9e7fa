"""Faults of the release: switches, blows on the crane, arming, the cable."""

from __future__ import annotations

from functools import partial

from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Moment, Outcome, break_part, outcomes_between


def _knock(day: Day, open_us: int) -> None:
    for switch in (1, 2):
        day.robot.knock(switch, open_us)


FAULTS = (
    Fault(
        "switch-stuck-closed",
        "Switch 1 shows closed, and only switch 2 opens at the release.",
        Moment.ARMED,
        outcomes_between(Moment.POWERED, Moment.RELEASE, Outcome.STANDS_STILL),
        action=break_part("switch", 1, "stuck-closed"),
        noticed="has no release",
        preflight=(),
        part="switch 1",
    ),
    Fault(
        "switch-stuck-open",
        "Switch 1 shows open while the robot hangs in the releaser.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.RECORDING, Outcome.NOT_DROPPED)
        | outcomes_between(Moment.ARMED, Moment.RELEASE, Outcome.FLIES),
        action=break_part("switch", 1, "stuck-open"),
        noticed="A release switch is open (switch 1)",
        preflight=("switches",),
        part="switch 1",
    ),
    Fault(
        "switch-bounce",
        "Both switches' contacts chatter for 50 ms at the release.",
        Moment.RELEASE,
        outcomes_between(Moment.POWERED, Moment.RELEASE, Outcome.FLIES),
        action=break_part("bounce", 50_000),
        noticed="edges fit two releases",
    ),
    Fault(
        "lift-knock",
        "A blow in the lift opens both switches for 4 ms.",
        Moment.LIFTED,
        {Moment.LIFTED: Outcome.FLIES},
        action=partial(_knock, open_us=4_000),
    ),
    Fault(
        "crane-jolt",
        "A jolt on the crane opens both switches for 6 ms, as a release does, and the robot hangs on.",
        Moment.LIFTED,
        {Moment.LIFTED: Outcome.FLIES},
        # Both switches open for 5 ms are a release, whoever opened them; closed again for 200 ms, a false one.
        action=partial(_knock, open_us=6_000),
        noticed="false release",
    ),
    Fault(
        "release-before-arming",
        "The robot is released although it is not armed.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.RECORDING, Outcome.STANDS_STILL),
        action=lambda day: setattr(day, "arming", False),
        noticed="did not move",
    ),
    Fault(
        "cable-pulled-while-armed",
        "The sequencer's cable is pulled right after arming.",
        Moment.ARMED,
        {Moment.ARMED: Outcome.FLIES},
        action=lambda day: day.robot.set_cable(BoardIndex.SEQUENCER, False),
    ),
)
