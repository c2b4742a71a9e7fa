"""Both boards: of one release, the sequencer safe and not restarted, the release switches closed for both."""

from __future__ import annotations

from tfsat_host.devices.arm_refusal import describe_defects, fault_latched, first_defect
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import (
    GoNoGo,
    PreflightCheck,
    go,
    join_steps,
    judge,
    no_go,
    not_made,
)
from tfsat_host.preflight.preflight_evidence import BoardEvidence, Evidence, Failed, Missing, require
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import FIRMWARE_VERSION, PROTOCOL_HASH, SWITCH_COUNT
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.robot.absent_parts import hash_wired_parts

_FLASH: dict[str, str] = {
    "sequencer": Advice("make firmware, then: ", NextStep("flash sequencer")),
    "logger": "flash firmware/teensy_logger of this release onto the Teensy (docs/logger.md)",
}


def check_protocol(evidence: Evidence) -> PreflightCheck:
    """Check that both boards' firmware has this program's protocol specification and version."""
    boards = (evidence.sequencer_board, evidence.logger_board)
    unreached = [(board.name, board.identity) for board in boards if isinstance(board.identity, Missing)]
    if unreached:
        reasons = " ".join(f"The {who} was not identified: {missing.reason}" for who, missing in unreached)
        return not_made(reasons, join_steps(" ", (missing.next_step for _, missing in unreached)))
    ours = ".".join(map(str, FIRMWARE_VERSION))
    for board in boards:
        identity = require(board.identity)
        if identity.speaks_this_protocol and identity.firmware == ours:
            continue
        other = "another protocol than" if not identity.speaks_this_protocol else "another version than"
        return no_go(
            f"The {board.name}'s firmware {identity.firmware} is of {other} this program's {ours}.",
            Advice(_FLASH[board.name], "; or install the host package of the boards' release."),
            board=board.name,
            firmware=identity.firmware,
            protocol_hash=identity.protocol_hash,
            expected_protocol_hash=PROTOCOL_HASH.hex(),
        )
    return go(
        f"Protocol: the same on both boards and here, firmware {ours}.", protocol_hash=PROTOCOL_HASH.hex()
    )


def check_image(board: BoardEvidence) -> PreflightCheck:
    """Check that the board runs the expected image, byte for byte.

    The images are compared by the CRC that the board computes over its own flash.
    """
    name, identity, expected_image = board.name, board.identity, board.image
    if isinstance(identity, Missing):
        return not_made(f"{name.capitalize()} image: unknown.", "See protocol.")
    if identity.runs_natively:
        return go(
            f"{name.capitalize()} image: none, the emulated robot runs the sources natively.",
            natively=True,
        )
    runs = f"The {name} runs image {identity.image_crc}"
    if isinstance(expected_image, Missing):
        return not_made(
            f"{runs}; which it should run is not known: {expected_image.reason}",
            expected_image.next_step,
            image_crc=identity.image_crc,
        )
    numbers = {
        "image_crc": identity.image_crc,
        "expected_image_crc": expected_image.crc,
        "source": expected_image.source,
        "calibrated": expected_image.calibrated,
    }
    if identity.image_crc == expected_image.crc:
        whose = (
            "as when it was calibrated" if expected_image.calibrated else f"that of {expected_image.source}"
        )
        return go(f"{runs}, {whose}.", **numbers)
    # What ran at the calibration need not be right: the board may have been flashed since on purpose.
    if expected_image.calibrated:
        return no_go(
            f"{runs}; when it was calibrated it ran {expected_image.crc} ({expected_image.source}).",
            Advice(
                f"If it was flashed since, name what it runs now: --logger-image {identity.image_crc}. If not, ",
                _FLASH[name],
                ".",
            ),
            **numbers,
        )
    return no_go(
        f"{runs}, not {expected_image.crc} of {expected_image.source}.",
        Advice(
            "To run that one: ",
            _FLASH[name],
            ". If what it runs is right, as the Arduino IDE made it, name that: "
            f"--{name}-image {identity.image_crc}",
        ),
        **numbers,
    )


def check_acceptance(evidence: Evidence) -> PreflightCheck:
    """Check that the wiring of these boards was accepted on the bench; an emulated robot's needs no acceptance."""
    accepted, again = evidence.acceptance, Advice(NextStep("acceptance"))
    sequencer, logger = evidence.sequencer_board.identity, evidence.logger_board.identity
    if isinstance(sequencer, Missing) or isinstance(logger, Missing):
        return not_made("Which boards these are is not known.", "See protocol.")
    if isinstance(accepted, Failed):
        return no_go(accepted.reason, accepted.next_step)
    if isinstance(accepted, Missing) and evidence.runs_natively:
        return go("Acceptance: none needed (emulated robot).", emulated=True)
    accepted = require(accepted)
    numbers = {"file": accepted.file, "at": accepted.at.isoformat()}
    if (sequencer.serial, logger.serial) != (accepted.sequencer_serial, accepted.logger_serial):
        others = "logger" if sequencer.serial == accepted.sequencer_serial else "sequencer"
        return no_go(f"Acceptance: {accepted.file} is of another {others}.", again, **numbers)
    # With fewer parts it has looked at fewer wires.
    if accepted.parts_sha256 != hash_wired_parts(evidence.robot):
        return no_go(f"Acceptance: {accepted.file} is of other parts by its robot file.", again, **numbers)
    done = f"Acceptance of {accepted.at:%Y-%m-%d}"
    return judge(
        accepted.remaining, f"{done}: not passed: {{}}.", again, f"{done}: all steps passed.", **numbers
    )


def check_state(evidence: Evidence) -> PreflightCheck:
    """Check that the sequencer is safe, without a latched fault or EEPROM damage, from beginning to end."""
    answers = require(evidence.sequencer)
    # At both ends: a fault may latch during the preflight.
    for status in (answers.status, answers.later):
        state = status.state.name.lower()
        if status.fault != ErrorCode.NONE:
            latched = fault_latched(status.fault)
            return no_go(latched.what, latched.next_step, state=state, fault=status.fault.name.lower())
        if status.state != SequencerState.SAFE:
            return no_go(f"Sequencer: {state}, not safe.", Advice(NextStep("disarm")), state=state)
        if status.stores_damaged:
            return no_go(
                describe_defects(status.stores_damaged),
                REMEDIES[first_defect(status.stores_damaged)][2],
                state=state,
                stores_damaged=status.stores_damaged,
            )
    return go("Sequencer: safe, no fault, EEPROM valid, servos limp.", state="safe")


_RESTARTS: dict[ResetCause, tuple[str, str]] = {
    ResetCause.BROWN_OUT: (
        "its supply dipped",
        "Charge the battery and check its plugs; then switch the power off and on",
    ),
    ResetCause.WATCHDOG: (
        "its main loop hung",
        Advice(
            "Save ",
            NextStep("status", ("--json",)),
            " and report it; flash the board again, then switch the power off and on",
        ),
    ),
}


def check_restarts(evidence: Evidence) -> PreflightCheck:
    """Neither a weak supply nor a hang made it start, and neither board restarted during the preflight."""
    sequencer, logger = require(evidence.sequencer), require(evidence.logger)
    status = sequencer.later
    cause, since_s = status.reset_cause.name.lower(), status.uptime_ms / 1000
    numbers = {
        "sequencer_reset_cause": cause,
        "sequencer_uptime_s": since_s,
        "logger_uptime_s": logger.later.uptime_ms / 1000,
    }
    boards = {"sequencer": sequencer.pace, "logger": logger.pace}
    # A restart in between comes first: answers from before it are of another start.
    if restarted := [board for board, pace in boards.items() if pace is None]:
        return no_go(
            f"The {' and the '.join(restarted)} restarted during this preflight.",
            "Check supply, plugs and the emergency switch; then run this preflight again.",
            **numbers,
        )
    last = f"Last start of the sequencer, {since_s:.0f} s ago"
    if status.reset_cause in _RESTARTS:
        why, cure = _RESTARTS[status.reset_cause]
        return no_go(
            f"{last}: {cause.replace('_', ' ')}, {why}.",
            Advice(cure, ", and run this preflight again."),
            **numbers,
        )
    return go(f"{last}: {cause.replace('_', ' ')}; none since.", **numbers)


def check_battery(_evidence: Evidence) -> PreflightCheck:
    """Report the battery's voltage as not checked.

    No board has a wire to the battery, and no message carries a voltage: this never gives GO.
    """
    return PreflightCheck(
        "",
        GoNoGo.NOT_MADE,
        "Battery voltage: not wired to either board.",
        {"wired": False},
        "Measure it with a voltmeter under load, and note it.",
        optional=True,
    )


def check_switches(evidence: Evidence) -> PreflightCheck:
    """Check that both release switches are closed, for both boards, from beginning to end."""
    sequencer, logger = require(evidence.sequencer), require(evidence.logger)
    # One bit for each switch, set while it is open; open at either end counts.
    opened = {
        "sequencer": sequencer.status.switches_open | sequencer.later.switches_open,
        "logger": logger.status.switches_open | logger.later.switches_open,
    }
    closed = {board: [not bits >> bit & 1 for bit in range(SWITCH_COUNT)] for board, bits in opened.items()}
    numbers = {f"{board}_closed": states for board, states in closed.items()}
    wrong = [index + 1 for index, both in enumerate(zip(*closed.values(), strict=True)) if not all(both)]
    if not wrong:
        return go("Release switches: 1 and 2 closed, for both boards.", **numbers)
    several = len(wrong) > 1
    which = f"Release switch{'es' if several else ''} {' and '.join(map(str, wrong))} {'are' if several else 'is'}"
    by = [board for board, states in closed.items() if not all(states)]
    # Both boards see the same switches: where one alone finds it open, its wire is at fault.
    if len(by) == 1:
        return no_go(
            f"{which} open for the {by[0]} and closed for the other board.",
            f"Check the {by[0]}'s wire to the switch (docs/wiring.md), then run this preflight again.",
            **numbers,
        )
    return no_go(
        f"{which} open.",
        Advice(
            "Seat the robot in the releaser until both switches click; ", NextStep("monitor"), " shows them."
        ),
        **numbers,
    )
