"""`tfsat-host acceptance`: two people and a robot on the bench, step by step."""

from __future__ import annotations

import argparse
import signal
import time
from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.boards import open_jog_client, open_logger, open_port
from tfsat_host.cli.stopping import SIGNALS, SUSPEND, handle_signals
from tfsat_host.cli.usage import FORCE, add_options, device
from tfsat_host.errors import Interrupted, TfsatError, UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import check_may_write
from tfsat_host.present.output import GREEN, RED, Output
from tfsat_host.present.terminal import show_rows, write_verdict
from tfsat_host.quantity import record, records

if TYPE_CHECKING:
    from tfsat_host.acceptance.bench import Bench, Task
    from tfsat_host.acceptance.record import Acceptance, StepResult
    from tfsat_host.acceptance.wiring_faults import WiringFault
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.robot import RobotModel

LEAD_S = 5.0
"""With `--yes` a task begins so long after it was announced."""
REOPEN_TIMEOUT_S = 20.0
"""A sequencer that restarted is back by then: its bootloader takes 8 s."""
_MARK = {"go": "ok", "no-go": "WRONG", "not-made": "NOT MADE"}
"""By a check's verdict."""
_USAGE = f"""
Find every sensor, switch, servo and wire in its place before a robot is calibrated: two people at the bench, half an
hour. A wire that is wrong is named with its pin. Each step is kept in acceptance.json with a page, acceptance.html, for
which preflight asks; an interrupted acceptance goes on at its step. docs/acceptance.md shows the steps.

--only STEP...      do these steps alone, and keep the others: boards rest motion switches card time servos supply
--out DIR           folder of record and page (default: the current one)
{FORCE}
--robot FILE        a robot file, or the name of a robot that tfsat brings along (default: drop_tower)
--logger-port PORT  serial port of the logger, in addition to the sequencer's --port; without it TFSAT_LOGGER_PORT,
                    else the one port that looks like this board
--fault NAME        with --emulated: a wiring fault that must be named; may be given more than once
--list-faults       what may be wired wrongly with --fault
{device("sequencer")}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the steps, the folder, the robot, and the faults of an emulated one."""
    add_options(parser, _USAGE, robot=str, fault={"action": "append", "default": []})


def run(args: argparse.Namespace, out: Output) -> int:
    """Does what is left to do, step by step, and shows the verdict."""
    from tfsat_host.acceptance.record import COLUMNS, EMULATED_FILE, FILE, MADE_BY
    from tfsat_host.acceptance.wiring_faults import FAULT, WIRING_FAULTS
    from tfsat_host.robot.absent_parts import load_robot_of_boards, require_all_parts

    if args.list_faults:
        faults = list(WIRING_FAULTS.values())
        out.result({"faults": records(FAULT, faults)}, lambda: show_rows(FAULT, faults, out))
        return 0
    model = load_robot_of_boards(args.robot)
    if args.fault:
        require_all_parts(model)
    # A closed terminal, a `kill` and Ctrl-Z are a Ctrl-C: the sequencer is disarmed, the joint let go.
    with (
        handle_signals([*SIGNALS, *SUSPEND], signal.default_int_handler),
        (_open_emulated if args.emulated else _open_boards)(args, model, out) as bench,
    ):
        # By the boards' own word: a served robot is found as boards are.
        name = EMULATED_FILE if bench.logger.identity.runs_natively else FILE
        file = (args.out or Path()) / name
        check_may_write(file, marker=MADE_BY.encode(), force=args.force)
        acceptance = _do_steps(_begin(file, args, bench, out), args.only or (), file, bench, out)
    page = file.with_suffix(".html")
    columns = record(COLUMNS, acceptance)
    out.result({**columns, "file": str(file), "page": str(page)}, partial(_show, acceptance, page, out))
    return ExitCode.REFUSED if acceptance.remaining else 0


def _begin(file: Path, args: argparse.Namespace, bench: Bench, out: Output) -> Acceptance:
    """Take up the acceptance that lies there, or begin one; another sequencer ends the steps that concern it.

    Raises UsageError: it is of another robot; or no such step exists.
    """
    from tfsat_host.acceptance.record import Acceptance, AcceptedBoard, read_acceptance
    from tfsat_host.acceptance.steps import OF_SEQUENCER, STEPS
    from tfsat_host.robot.absent_parts import hash_wired_parts

    names = tuple(step.name for step in STEPS)
    if unknown := set(args.only or ()) - set(names):
        raise UsageError(
            what=f"There is no step {min(unknown)!r}.",
            meaning="Nothing was done.",
            next_step=f"Steps: {', '.join(names)}.",
        )
    sequencer, logger = (AcceptedBoard.of(board.identity) for board in (bench.sequencer, bench.logger))
    robot = hash_wired_parts(bench.robot)
    fresh = Acceptance(bench.logger.identity.runs_natively, robot, names, sequencer, logger)
    if not file.exists() or args.force:
        return fresh
    before = read_acceptance(file)
    # By serial numbers: a board that was flashed again has the same wires.
    was = (before.logger.serial, before.parts_sha256, before.steps_due)
    if was != (logger.serial, robot, names):
        raise UsageError(
            what=f"{file} is of another logger, or of other parts by the robot file.",
            meaning="Nothing was done; that record is unchanged.",
            next_step="Name another folder with --out; --force begins anew in its place.",
        )
    if before.sequencer.serial != sequencer.serial:
        out.note(f"The sequencer is another one: {', '.join(OF_SEQUENCER)} are done again; all else is kept.")
        before = before.without(OF_SEQUENCER)
    # What is asked for again counts no more, even if it is interrupted.
    return replace(before.without(args.only or ()), sequencer=sequencer, logger=logger)


def _do_steps(
    acceptance: Acceptance, only: Collection[str], file: Path, bench: Bench, out: Output
) -> Acceptance:
    """Do `only` these steps, or all that are left; each is written, with the page, before the next begins.

    Raises Interrupted: a person ended the session, or the link to a board broke.
    """
    from tfsat_host.acceptance.steps import STEPS, make_step
    from tfsat_host.devices.serial_ports import PortError

    # What boards and card are ready for is of now, not of when the acceptance began.
    begins = {"boards"} if only or acceptance.remaining else set()
    try:
        for number, step in enumerate(STEPS, 1):
            heading = f"Step {number} of {len(STEPS)}: {step.title}"
            # A step may end what rests on it: what is left is looked up anew each time.
            if step.name not in {*begins, *(only or acceptance.remaining)}:
                done = step.name in {result.name for result in acceptance.steps}
                out.note(f"{heading}: {'done before' if done else 'not asked for'}")
                continue
            again = True
            while again:
                out.note(f"\n{heading}")
                result = make_step(step, bench, acceptance)
                acceptance = acceptance.with_step(result)
                _keep(acceptance, file)
                _tell(result, out)
                again = not result.passed and out.can_ask and _ask(out, "r: repeat it", "r") == "r"
    except (KeyboardInterrupt, Interrupted, PortError) as error:
        kept = "Nothing is kept"
        if acceptance.steps:
            _keep(acceptance, file)
            kept = f"{len(acceptance.steps)} of {len(STEPS)} steps are kept in {file}"
        raise Interrupted(
            what=error.what if isinstance(error, PortError) else "Interrupted.",
            meaning=f"{kept}; nothing is armed, no joint is driven.",
            next_step=Advice("Go on at this step: ", NextStep("acceptance")),
        ) from error
    return acceptance


def _keep(acceptance: Acceptance, file: Path) -> None:
    """Write record and page."""
    from tfsat_host.acceptance.page import render_page
    from tfsat_host.acceptance.record import write_acceptance
    from tfsat_host.whole_file import write_whole

    write_acceptance(acceptance, file)
    write_whole(file.with_suffix(".html"), render_page(acceptance).encode())


def _tell(result: StepResult, out: Output) -> None:
    for check in result.checks:
        out.note(f"  {_MARK[check.verdict.value]}: {check.sentence}")
        if check.blocks and not check.follows:
            out.note(f"  Next: {check.next_step}")


def _ask(out: Output, other: str = "", keys: str = "") -> str:
    """Wait for Enter or one of the keys. Raises Interrupted for q."""
    choices = ", ".join(filter(None, ("Enter: go on", other, "q: stop here")))
    key = out.ask_key(f"  {choices} ", meaning="This step was not done.", keys=f"\n{keys}q")
    if key == "q":
        raise Interrupted(what="Stopped.", meaning="", next_step="")
    return key


def _show(acceptance: Acceptance, page: Path, out: Output) -> None:
    color = RED if acceptance.remaining else GREEN
    wrong = [check for check in acceptance.checks if check.blocks]
    for check in wrong:
        out.line(f"{check.name}: {check.sentence}")
    out.line(f"Page: {page}")
    if acceptance.remaining:
        mend = "mend that, then " if wrong else ""
        out.line(Advice(f"Next: {mend}", NextStep("acceptance"), " (done steps are kept)"))
    else:
        out.line(
            Advice("Steps again: ", NextStep("acceptance", ("--only", "STEP")), "; all of them: --force")
        )
    write_verdict(acceptance.verdict_line, color, out)


class _TwoPeople:
    """The people at the bench: told what to do; a key says that it is done."""

    def __init__(self, robot: RobotModel, out: Output) -> None:
        self._robot = robot
        self._out = out

    def do(self, task: Task, number: int = 0) -> None:
        """Announce the task and wait. Raises UsageError without a terminal, Interrupted for q."""
        from tfsat_host.acceptance.bench import MOVING, Task, describe_task

        for line in describe_task(task, number, self._robot):
            self._out.note(f"  {line}")
        if task is Task.LET_GO:
            return
        if self._out.yes and task in MOVING:
            raise UsageError(
                what="--yes arms nothing and moves no joint of a robot.",
                meaning="The steps before this one are kept.",
                next_step=Advice("Go on in a terminal: ", NextStep("acceptance")),
            )
        if self._out.yes:
            time.sleep(LEAD_S)
        else:
            _ask(self._out)


@contextmanager
def _open_boards(args: argparse.Namespace, model: RobotModel, out: Output) -> Iterator[Bench]:
    from tfsat_host.acceptance.bench import Bench

    if args.fault:
        raise UsageError(
            what="--fault is of the emulated robot.", meaning="Nothing was done.", next_step="Add --emulated."
        )
    at_logger = argparse.Namespace(emulated=False, port=args.logger_port)
    with open_jog_client(args, out) as sequencer, open_logger(at_logger, out) as logger:

        def reopen() -> JogClient:
            return _reopen(args, out)

        people = _TwoPeople(model, out)
        yield Bench(model, sequencer, logger, people, reopen, out.note, out.progress, _hold_signals_back)


def _hold_signals_back() -> AbstractContextManager[None]:
    return handle_signals([*SIGNALS, *SUSPEND], lambda *_: None)


def _reopen(args: argparse.Namespace, out: Output) -> JogClient:
    """Find a sequencer that restarted, under whatever port it comes back. Raises TfsatError: not in time."""
    from tfsat_host.devices.jogging import JogClient

    deadline_s = time.monotonic() + REOPEN_TIMEOUT_S
    while True:
        try:
            return JogClient.connect(open_port("sequencer", args.port, out))
        except TfsatError:
            if time.monotonic() > deadline_s:
                raise
            time.sleep(0.5)


@contextmanager
def _open_emulated(args: argparse.Namespace, model: RobotModel, out: Output) -> Iterator[Bench]:
    from tfsat_host.acceptance.bench import Bench
    from tfsat_host.acceptance.emulated_hands import EmulatedHands
    from tfsat_host.acceptance.wiring_faults import emulate_faults
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.emulated.emulated_robot import BoardIndex
    from tfsat_host.emulated.emulated_transport import EmulatedTransport

    with emulate_faults(_faults_named(args.fault), model, out.note) as (robot, servo_faults):
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        yield Bench(
            model,
            sequencer,
            logger,
            EmulatedHands(robot, servo_faults),
            lambda: sequencer,
            out.note,
            out.progress,
        )


def _faults_named(names: list[str]) -> list[WiringFault]:
    from tfsat_host.acceptance.wiring_faults import WIRING_FAULTS

    if unknown := set(names) - set(WIRING_FAULTS):
        raise UsageError(
            what=f"There is no wiring fault {min(unknown)!r}.",
            meaning="Nothing was done.",
            next_step=Advice(NextStep("acceptance", ("--list-faults",)), " lists them."),
        )
    return [WIRING_FAULTS[name] for name in names]
