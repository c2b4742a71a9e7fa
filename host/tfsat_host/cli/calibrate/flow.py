"""The steps of a command in a terminal: its certificate, what is asked and shown, and what is kept at the end."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError, NotKeptError
from tfsat_host.calibration.steps.instructions import title
from tfsat_host.cli.calibrate.options import as_typed_here, certificate_path, resuming
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.present.output import NotConfirmed, Output

if TYPE_CHECKING:
    from pathlib import Path

    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.session import Session
    from tfsat_host.calibration.solution import Solution
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.calibration.steps.step import Axis, Step
    from tfsat_host.robot import RobotModel

    Reader = Callable[[Step, Solution | Calibration], Evidence]

OF_EMULATED = "These are the errors of an emulated robot: of no use for a real one."


def measure(args: argparse.Namespace, turned: tuple[Axis, float] | None, out: Output) -> int:
    """The steps of one quantity, each until it is accepted; `turned` is a turn by hand, axis and angle in deg."""
    from tfsat_host.calibration.session import Session, steps_of, with_rest
    from tfsat_host.calibration.steps.step import StepKind
    from tfsat_host.cli.calibrate import jog
    from tfsat_host.cli.calibrate.bench import open_bench
    from tfsat_host.cli.calibrate.recording import record
    from tfsat_host.robot import load_robot

    model = load_robot(args.robot)
    jogging = getattr(args, "jog", False)
    steps = steps_of(args.quantity, args.joint if args.quantity != "bias" else None, turned)
    with open_bench(args, model, out, jog=jogging) as bench:
        campaign = open_campaign(args, bench.origin, model, out)
        before = campaign.calibration
        anew = getattr(args, "anew", False)
        if args.quantity == "misalignment" and anew:
            campaign.sensors_moved(datetime.now(UTC))
        if args.quantity in ("misalignment", "scale"):
            steps = with_rest(steps, campaign)
            note_without_zero(campaign, args, out)

        def read(step: Step, known: Solution | Calibration) -> Evidence:
            if jogging and step.kind == StepKind.SWEEP:
                return jog.sweep(step, bench, out)
            return record(step, bench, known, model, out)

        terminal = Terminal(read, len(steps), model, args, out)
        session = Session(steps, campaign, terminal, resume=args.resume, compare=not anew)
        with saying_what_is_kept(session, campaign, args, out):
            session.run()
    give_result(args, campaign, session.kept, before, model, out)
    return 0


def take_from_log(args: argparse.Namespace, out: Output) -> int:
    """Takes a rest out of a recording, judges and keeps it as one on the bench."""
    from tfsat_host.calibration.quiet_log import rest_of
    from tfsat_host.robot import load_robot
    from tfsat_host.run.certificate import origin_of_log
    from tfsat_host.sdlog.load import load

    model = load_robot(args.robot)
    with out.progress(f"Reading {args.log}", total=1.0) as advance:
        log = load(args.log, progress=advance)
    origin = origin_of_log(log.header)
    # What is to be typed next is for the robot of the recording, not for whatever is plugged in.
    here = argparse.Namespace(**{**vars(args), "emulated": origin.emulated})
    try:
        rested = rest_of(log, args.log, origin)
        campaign = open_campaign(args, origin, model, out)
        before = campaign.calibration
        newer = campaign.not_older_than(rested)
        if newer is None:
            campaign.accept(rested)
    except CalibrationError as error:
        error.next_step = as_typed_here(error.next_step, here)
        raise
    if newer is not None and newer.taken > rested.taken:
        raise _too_old(rested, newer, campaign.certificate, args)
    if newer is not None:
        out.note(f"{campaign.certificate} rests on this recording already: nothing was changed.")
    give_result(here, campaign, [rested], before, model, out)
    return 0


def _too_old(rested: Evidence, newer: Evidence, file: Path, args: argparse.Namespace) -> CalibrationError:
    other = file.with_name(f"{file.stem}-{args.log.stem}.toml")
    robot = "" if args.robot is None else f" --robot {shlex.quote(str(args.robot))}"
    return CalibrationError(
        what=f"The rest in {args.log} is of {rested.taken:%Y-%m-%d %H:%M} UTC, older than the biases in {file}, which "
        f"are of {newer.taken:%Y-%m-%d %H:%M} UTC.",
        meaning="The newest biases count: nothing was changed.",
        next_step="To look at the recording's, give them a certificate of their own: tfsat-host calibrate bias "
        f"--log {shlex.quote(str(args.log))} --out {shlex.quote(str(other))}{robot}",
    )


def open_campaign(args: argparse.Namespace, origin: Origin, model: RobotModel, out: Output) -> Campaign:
    """The certificate that the steps go into; something may be written there. Warns of recordings that are lost.

    Raises:
        CalibrationError: it is of other sensors, damaged, or its recordings are.
        TfsatError: nothing can be written there.
    """
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Subject
    from tfsat_host.output_files import check_may_write

    path = certificate_path(args, emulated=origin.emulated)
    check_may_write(path, marker=b"", force=True)  # whether what is there may be replaced, the campaign knows
    subject = Subject(model.name, origin.logger_serial, origin.who_am_i, origin.emulated)
    campaign = Campaign(path, model, subject, force=args.force)
    for sentence in campaign.left_out:
        out.warn(f"{sentence} Its step does not count any more.")
    return campaign


def note_without_zero(campaign: Campaign, args: argparse.Namespace, out: Output) -> None:
    """Says before a motion that the angles of closed joints are only known by design."""
    joints = campaign.solution().joints
    unknown = [sensors.joint for sensors in joints if sensors.zero_taken is None]
    if not unknown or out.json_mode:
        return
    which = "--all" if len(unknown) == len(joints) else f"--joint {unknown[0]}"
    out.note(
        f"Zero points of joint{'s' if len(unknown) > 1 else ''} {', '.join(map(str, unknown))} are not calibrated: "
        "what follows will be less sure for bodies beyond a closed joint.\n"
        f"  To measure them first: {as_typed_here(f'tfsat-host calibrate zero {which}', args)}"
    )


class Terminal:
    """A session's operator at a terminal.

    Args:
        read: Has a step done and reads the sensors meanwhile, with what is known of them.
        steps: How many there are.
        model: The robot.
        args: The command's.
        out: Its voice.
    """

    def __init__(
        self, read: Reader, steps: int, model: RobotModel, args: argparse.Namespace, out: Output
    ) -> None:
        self.record = read
        self._steps = steps
        self._model = model
        self._args = args
        self._out = out

    def refused(self, error: CalibrationError) -> None:
        """Asks whether to repeat it; raises the error where there is no terminal."""
        if not self._out.can_ask:
            raise error
        error.next_step = as_typed_here(error.next_step, self._args)
        self._out.error(error)
        self._out.ask("Enter repeats the step, q ends: ", meaning="This step was not accepted.", accept=("",))

    def accepted(self, step: Evidence, calibration: Calibration) -> None:
        """Says what was found."""
        from tfsat_host.calibration.findings import found_lines

        for line in () if self._out.json_mode else found_lines(step, calibration, self._model):
            self._out.note(f"  Accepted: {line}.")

    def resumed(self, number: int, step: Evidence) -> None:
        """Says that it was kept before."""
        taken = f"{step.taken.astimezone():%H:%M}"
        self._out.note(f"{number} of {self._steps}: {title(step.step)}: kept from {taken}.")


@contextmanager
def saying_what_is_kept(
    session: Session, campaign: Campaign, args: argparse.Namespace, out: Output
) -> Iterator[None]:
    """Whatever ends a session says how much of it is kept, and what goes on behind that.

    Raises:
        Interrupted: by Ctrl-C.
        TfsatError: what ended it; a person who did not go on ends it with exit code 1.
    """
    try:
        yield
    except KeyboardInterrupt:
        if not out.json_mode:
            out.note("")  # behind the prompt, and the terminal's ^C
        kept = _kept_words(session, campaign)
        raise Interrupted(what="Interrupted.", meaning=kept, next_step=resuming(args)) from None
    except NotConfirmed:
        what = "Ended before all steps were done."
        raise TfsatError(
            what=what, meaning=_kept_words(session, campaign), next_step=resuming(args)
        ) from None
    except TfsatError as error:
        error.next_step = as_typed_here(error.next_step, args)
        if session.kept:
            error.meaning = f"{error.meaning}\n{_kept_words(session, campaign)}"
        if isinstance(error, NotKeptError):
            error.next_step = f"Make room, or see that it may be written; then: {resuming(args)}"
        elif session.kept:
            error.next_step += f"\nTo go on behind the steps that are kept: {resuming(args)}"
        raise


def _kept_words(session: Session, campaign: Campaign) -> str:
    kept, total = len(session.kept), len(session.steps)
    if not kept:
        return f"None of {total} steps was accepted; what was calibrated before is unchanged."
    return f"{kept} of {total} steps {'is' if kept == 1 else 'are'} kept in {campaign.certificate}."


def give_result(
    args: argparse.Namespace,
    campaign: Campaign,
    kept: Sequence[Evidence],
    before: Calibration | None,
    model: RobotModel,
    out: Output,
) -> None:
    """The command's result, as a table or as JSON.

    Args:
        args: The command's.
        campaign: With all steps accepted.
        kept: This command's steps.
        before: What was known when it began.
        model: The robot.
        out: Its voice.
    """
    from tfsat_host.calibration.certificate.certificate import commands_of, summarized
    from tfsat_host.calibration.findings import bend_rows, found_table, largest_bends_deg
    from tfsat_host.present.terminal import show_table
    from tfsat_host.quantity import records

    calibration = campaign.calibration
    if calibration is None:
        raise ValueError("nothing was accepted")
    key, table = found_table(args.quantity, kept, before, calibration, model)
    bends = bend_rows(calibration, kept) if args.quantity == "scale" else []
    shortcomings = calibration.shortcomings()

    def show() -> None:
        show_table(table, out)
        for joint, (first, second) in largest_bends_deg(bends).items():
            out.line(
                f"The angle sensors of joint {joint} bend by at most {first:.2f} and {second:.2f} deg; "
                "the certificate takes it off."
            )
        if shortcomings:
            out.line(f"For a drop: {summarized(shortcomings)}.")
            out.line(f"Next: {as_typed_here(commands_of(shortcomings)[0], args)}")
        else:
            out.line("Nothing is missing for a drop.")
        if calibration.subject.emulated:
            out.line(OF_EMULATED)
        out.line(f"Written to {campaign.certificate}.")

    steps = {one.step.key for one in kept}
    out.result(
        {
            **({} if getattr(args, "joint", None) is None else {"joint": args.joint}),
            key: records(table.columns, table.rows),
            **({"sensors": bends} if args.quantity == "scale" else {}),
            "emulated": calibration.subject.emulated,
            "steps": [
                {
                    "key": paper.step,
                    "file": paper.file,
                    "sha256": paper.sha256,
                    "taken": paper.taken.isoformat(),
                }
                for paper in calibration.papers
                if paper.step in steps
            ],
            "missing": [
                {"name": one.name, "reason": one.reason, "command": f"tfsat-host calibrate {one.command}"}
                for one in shortcomings
            ],
            "file": str(campaign.certificate),
        },
        show,
    )
