"""What the sequencer says of itself, and the release switches as both boards see them."""

from __future__ import annotations

from tfsat_host.devices.arm_refusal import describe_defects, first_defect
from tfsat_host.preflight.check import Check, Verdict, go, no_go
from tfsat_host.preflight.evidence import Evidence, Missing, unreached
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.protocol.remedies import REMEDIES


def check_state(evidence: Evidence) -> Check:
    """It is safe, with no fault latched and nothing damaged in its EEPROM, from beginning to end."""
    name = "sequencer-state"
    answers = evidence.sequencer
    if isinstance(answers, Missing):
        return unreached(name, answers)
    for status in (answers.status, answers.later):
        state = status.state.name.lower()
        if status.fault != ErrorCode.NONE:
            what, _, cure = REMEDIES[status.fault]
            return no_go(
                name,
                f"A fault is latched: {what[:1].lower()}{what[1:]}",
                f"{cure} Only tfsat-host disarm clears the fault.",
                state=state,
                fault=status.fault.name.lower(),
            )
        if status.state != SequencerState.SAFE:
            return no_go(name, f"It is {state}, not safe.", "tfsat-host disarm", state=state)
        if status.stores_damaged:
            return no_go(
                name,
                describe_defects(status.stores_damaged),
                REMEDIES[first_defect(status.stores_damaged)][2],
                state=state,
                stores_damaged=status.stores_damaged,
            )
    return go(name, "Safe: no fault, EEPROM whole, servos limp.", state="safe")


def check_restarts(evidence: Evidence) -> Check:
    """Neither a weak supply nor a hang made it start, and neither board restarted while it was looked at."""
    name = "restarts"
    if isinstance(evidence.sequencer, Missing):
        return unreached(name, evidence.sequencer)
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    status = evidence.sequencer.later
    numbers = {
        "sequencer_reset_cause": status.reset_cause.name.lower(),
        "sequencer_uptime_s": status.uptime_ms / 1000,
        "logger_uptime_s": evidence.logger.later.uptime_ms / 1000,
    }
    restarted = [
        board
        for board, pace in (("sequencer", evidence.sequencer.pace), ("logger", evidence.logger.pace))
        if pace is None
    ]
    if restarted:
        return no_go(
            name,
            f"The {' and the '.join(restarted)} restarted during this preflight.",
            "Check supply, plugs and the emergency switch; then run this preflight again.",
            **numbers,
        )
    if status.reset_cause in (ResetCause.BROWN_OUT, ResetCause.WATCHDOG):
        why, cure = {
            ResetCause.BROWN_OUT: (
                "its supply dipped",
                "Charge the battery and check its plugs; then switch the power off and on",
            ),
            ResetCause.WATCHDOG: (
                "its main loop hung",
                "Save tfsat-host status --json and report it; flash the board again, then switch the power off and on",
            ),
        }[status.reset_cause]
        return no_go(
            name,
            f"The sequencer's last start, {status.uptime_ms / 1000:.0f} s ago, was no switching on: {why}.",
            f"{cure}, and run this preflight again.",
            **numbers,
        )
    return go(
        name,
        f"The sequencer's last start, {status.uptime_ms / 1000:.0f} s ago: "
        f"{status.reset_cause.name.lower().replace('_', ' ')}; none since.",
        **numbers,
    )


def check_battery(_evidence: Evidence) -> Check:
    """No board has a wire to the battery, and no message carries a voltage: this never says GO."""
    return Check(
        "battery",
        Verdict.NOT_MADE,
        "Not wired: neither board measures the battery's voltage.",
        {"wired": False},
        "Measure it with a voltmeter under load, and note it.",
        optional=True,
    )


def check_switches(evidence: Evidence) -> Check:
    """Both release switches are closed, for both boards, from beginning to end."""
    name = "switches"
    if isinstance(evidence.sequencer, Missing):
        return unreached(name, evidence.sequencer)
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    seen = {
        "sequencer": evidence.sequencer.status.switches_open | evidence.sequencer.later.switches_open,
        "logger": evidence.logger.status.switches_open | evidence.logger.later.switches_open,
    }
    closed = {board: [not bits >> bit & 1 for bit in range(SWITCH_COUNT)] for board, bits in seen.items()}
    numbers = {f"{board}_closed": states for board, states in closed.items()}
    wrong = [
        number for number in range(1, SWITCH_COUNT + 1) if not all(c[number - 1] for c in closed.values())
    ]
    if not wrong:
        return go(name, "Both release switches are closed, for both boards.", **numbers)
    which = f"Release switch{'es' if len(wrong) > 1 else ''} {' and '.join(map(str, wrong))}"
    by = [board for board, states in closed.items() if not all(states)]
    if len(by) == 1:
        return no_go(
            name,
            f"{which} {'are' if len(wrong) > 1 else 'is'} open for the {by[0]} and closed for the other board.",
            f"Check the {by[0]}'s wire to the switch (docs/wiring.md), then run this preflight again.",
            **numbers,
        )
    return no_go(
        name,
        f"{which} {'are' if len(wrong) > 1 else 'is'} open.",
        "Seat the robot in the releaser until both switches click; tfsat-host monitor shows them.",
        **numbers,
    )
