"""The steps of a calibration one after the other: done, judged, kept; repeated where refused, resumed where ended."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.step import Step, StepKind, rest
from tfsat_host.cli.advice import Interrupted
from tfsat_host.cli.calibrate.campaign import NotKept, keep
from tfsat_host.cli.calibrate.options import as_typed_here, resuming
from tfsat_host.cli.calibrate.prompts import title
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import NotConfirmed, Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.progress import Known
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.robot import RobotModel

    Reader = Callable[[Step, Known], Evidence]

REST_HOLDS = timedelta(minutes=15)
"""For so long a bias may stand for a motion: it drifts with the temperature."""
RESUME_WITHIN = timedelta(hours=1)


class Ended(TfsatError):
    """The person ended the calibration at a prompt (exit code 1)."""


class Flow:
    """One command's steps.

    Attributes:
        steps: In order.
        kept: Of them, those that were accepted, in this run or (with `--resume`) before.

    Args:
        steps: What the command measures.
        campaign: Judges and keeps.
        read: Has a step done and reads the sensors meanwhile, with what is known of them.
        model: The robot.
        args: The command's.
        out: Its voice.
    """

    def __init__(
        self,
        steps: Sequence[Step],
        campaign: Campaign,
        read: Reader,
        model: RobotModel,
        args: argparse.Namespace,
        out: Output,
    ) -> None:
        self.steps = tuple(steps)
        self.kept: list[Evidence] = []
        self._campaign = campaign
        self._read = read
        self._model = model
        self._args = args
        self._out = out

    def run(self) -> None:
        """Every step, until each is accepted.

        Raises:
            CalibrationError: a step was refused, and nobody is there to repeat it.
            Ended: the person did not want to go on.
            Interrupted: by Ctrl-C.
            NotKept: a step could not be written.
            TfsatError: the logger or the operator failed.
        """
        with self._saying_what_is_kept():
            for number, step in enumerate(self.steps, 1):
                before = self._accepted_before(step)
                if before is not None:
                    self._out.note(
                        f"{number} of {len(self.steps)}: {title(step)}: kept from {_clock(before)}."
                    )
                    self.kept.append(before)
                    continue
                self.kept.append(self._repeated(step))

    def _repeated(self, step: Step) -> Evidence:
        """Once, and again after a refusal while a person says so."""
        from tfsat_host.cli.calibrate.results import found

        while True:
            evidence = self._read(step, self._known())
            anew = step.kind == StepKind.ZERO and self._args.anew
            try:
                calibration = keep(self._campaign, evidence, self._args, anew=anew)
            except CalibrationError as error:
                if not self._out.can_ask:
                    raise
                error.next_step = as_typed_here(error.next_step, self._args)
                self._out.error(error)
                self._out.ask(
                    "Enter repeats the step, q ends: ", meaning="This step was not accepted.", accept=("",)
                )
                continue
            if not self._out.json_mode:
                for line in found(evidence, calibration, self._model):
                    self._out.note(f"  Accepted: {line}.")
            return evidence

    def _known(self) -> Known:
        from tfsat_host.calibration.progress import Known

        now = self._campaign.calibration or self._campaign.solution()
        return Known(now.gyros, now.joints, self._model)

    def _accepted_before(self, step: Step) -> Evidence | None:
        """With `--resume`, the recording that stands for the step."""
        if not self._args.resume:
            return None
        return recent(self._campaign, step, RESUME_WITHIN)

    @contextmanager
    def _saying_what_is_kept(self) -> Iterator[None]:
        """Whatever ends the flow says how much of it is kept, and what goes on behind that."""
        try:
            yield
        except KeyboardInterrupt:
            if not self._out.json_mode:
                self._out.note("")  # behind the prompt, and the terminal's ^C
            raise self._of_what_is_kept(Interrupted, "Interrupted.") from None
        except NotConfirmed:
            raise self._of_what_is_kept(Ended, "Ended before all steps were done.") from None
        except NotKept as error:
            if self.kept:
                error.meaning = f"{error.meaning}\n{self._kept_words()}"
            raise
        except TfsatError as error:
            error.next_step = as_typed_here(error.next_step, self._args)
            if self.kept:
                error.meaning = f"{error.meaning}\n{self._kept_words()}"
                error.next_step = (
                    f"{error.next_step}\nTo go on behind the steps that are kept: {resuming(self._args)}"
                )
            raise

    def _of_what_is_kept(self, kind: type[TfsatError], what: str) -> TfsatError:
        return kind(what=what, meaning=self._kept_words(), next_step=resuming(self._args))

    def _kept_words(self) -> str:
        if not self.kept:
            return f"None of {len(self.steps)} steps was accepted; what was calibrated before is unchanged."
        return (
            f"{len(self.kept)} of {len(self.steps)} steps {'is' if len(self.kept) == 1 else 'are'} kept "
            f"in {self._campaign.certificate}."
        )


def with_rest(steps: Sequence[Step], campaign: Campaign) -> tuple[Step, ...]:
    """The steps, after a rest where no recent one tells the biases."""
    return tuple(steps) if recent(campaign, rest(), REST_HOLDS) is not None else (rest(), *steps)


def recent(campaign: Campaign, step: Step, within: timedelta) -> Evidence | None:
    """The step's recording, if it is no older than that and the robot has not landed since."""
    landing = None if campaign.calibration is None else campaign.calibration.last_landing
    for evidence in campaign.evidence:
        fresh = datetime.now(UTC) - evidence.taken <= within
        if evidence.step == step and fresh and (landing is None or evidence.taken > landing):
            return evidence
    return None


def _clock(evidence: Evidence) -> str:
    return f"{evidence.taken.astimezone():%H:%M}"
