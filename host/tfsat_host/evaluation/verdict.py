"""What an evaluation is worth, in one word, one sentence and the reasons.

`good`: all checks passed, nothing is missing. `doubtful`: the numbers are there, but a check failed, data are missing
or default values were used. `failed`: there are no numbers.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.com_fit.model_comparison import ModelComparison
from tfsat_host.evaluation.evaluated_drop import CERTIFICATE, Evaluation
from tfsat_host.evaluation.laser_velocity import ReleaseVelocity
from tfsat_host.evaluation.strokes import FlownStroke
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.quantity import Columns, fields
from tfsat_host.robot.absent_parts import ignore_absent
from tfsat_host.sdlog.contradictions import two_releases
from tfsat_host.sdlog.log_summary import grave_warnings

_LOG = logging.getLogger(__name__)

Level = Literal["good", "doubtful", "failed"]

OFF_SHARE = 0.15
"""Of a stroke: a servo as the paper's came 7 % short; what misses by more was not the stroke that was commanded."""
CERTAIN_STDS = 3.0
_EMULATED = "EMULATED robot. "


@dataclass(frozen=True, slots=True)
class Verdict:
    """What an evaluation is worth.

    Attributes:
        level: See the module.
        sentence: Why, in short; first, whether the robot was an emulated one.
        reasons: Why, at length; a sentence or more each. Empty if it is good.
    """

    level: Level
    sentence: str
    reasons: tuple[str, ...]

    def line(self) -> str:
        """Return level and sentence as a screen shows them, an emulated robot named at the end."""
        return self._line(self.sentence.removeprefix(_EMULATED).rstrip("."))

    def brief(self) -> str:
        """Return level and first finding, and how many reasons there are: the last line on a screen."""
        if self.level == "failed":
            return self._line(self.sentence.partition(". ")[0].rstrip("."))
        first, *others = self.sentence.removeprefix(_EMULATED).rstrip(".").split("; ")
        if self.level == "good":
            first, others = first.partition(", ")[0], []
        more = f"; {len(self.reasons)} reasons in all" if others else ""
        return self._line(first + more)

    def _line(self, sentence: str) -> str:
        emulated = " (emulated robot)" if self.sentence.startswith(_EMULATED) else ""
        # Joined clauses have a capital for JSON; an error's sentence keeps its own.
        text = sentence[:1].lower() + sentence[1:] if self.level == "doubtful" else sentence
        return f"{self.level.upper()}: {text}{emulated}"


VERDICT: Columns = fields("level sentence reasons")


def verdict_of(
    evaluation: Evaluation, against_calibration: Sequence[str] = (), against_maneuver: Sequence[str] = ()
) -> Verdict:
    """Judge one drop.

    Args:
        evaluation: The evaluation.
        against_calibration: Objections to the certificate that the evaluation itself cannot see: that it is of
            other sensors, or how old it is. Sentences.
        against_maneuver: Why the maneuver's file is not what was commanded. Sentences.
    """
    for check in evaluation.checks:
        _LOG.debug("check %s: %s", check.name, check.sentence)
    failed = [check.sentence for check in evaluation.failed_checks]
    moved = [rest.remark for rest in evaluation.standing if rest.unexpected]
    groups: tuple[tuple[str, Iterable[str]], ...] = (
        (f"{len(failed)} check{'' if len(failed) == 1 else 's'} failed", failed),
        (f"{evaluation.left_out.name} left out" if evaluation.left_out else "", _left_out(evaluation)),
        ("results are withheld", _withheld(evaluation)),
        (
            f"all ± are widened: the {evaluation.widened} taken {evaluation.widening:.1f} times as uncertain",
            _widening_reasons(evaluation),
        ),
        ("the recording is incomplete", _of_recording(evaluation)),
        ("the calibration is not valid for this drop", against_calibration),
        ("another maneuver than maneuver.toml was flown", against_maneuver),
        ("default values are used for missing data", evaluation.notes),
        ("not every stroke was flown as commanded", _of_strokes(evaluation.strokes)),
        ("a joint moved between its strokes", moved),
        ("the fall differs from a free fall with this maneuver", _of_fall(evaluation)),
        (_of_model(evaluation.explained), evaluation.explained.withheld if evaluation.is_given() else ()),
    )
    # Generators give their reasons once, but these are needed twice.
    present = {sentence: list(reasons) for sentence, reasons in groups}
    sentence = "; ".join(clause for clause, reasons in present.items() if reasons)
    kind = _EMULATED if evaluation.log.is_emulated else ""
    if not sentence:
        return Verdict("good", kind + _good(evaluation), ())
    # Groups may share a reason: keep the first of each, in order.
    reasons = tuple(dict.fromkeys(reason for some in present.values() for reason in some))
    return Verdict("doubtful", f"{kind}{sentence[:1].upper()}{sentence[1:]}.", reasons)


def _left_out(evaluation: Evaluation) -> Iterator[str]:
    if evaluation.left_out is not None:
        yield (
            f"All numbers are without the {evaluation.left_out.name}: the other sensors agree, and bridge it with "
            "larger uncertainty."
        )


def _withheld(evaluation: Evaluation) -> Iterator[str]:
    names = [name for name in evaluation.withheld if name != "offsets"]
    if not names:
        return
    by_name = {check.name: check for check in evaluation.checks}
    # Several results may fall to one check: name each check once.
    worst = (by_name[name] for name in dict.fromkeys(evaluation.withheld[name] for name in names))
    checks = ", ".join(f"{check.name} ({check.excess:.2g} times its limit)" for check in worst)
    why = "no greater errors of the certificate describe such a fault"
    if evaluation.widest > 1.0:
        why = f"errors {evaluation.widest:.3g} times the stated ones do not explain it"
    yield f"Withheld, with derived results: {', '.join(names)}. Failed: {checks}; {why}."


def _widening_reasons(evaluation: Evaluation) -> Iterator[str]:
    if evaluation.widening > 1.0:
        next_step = "Measure the hinges."
        if evaluation.widened == CERTIFICATE:
            next_step = Advice("Calibrate again: ", NextStep("calibrate show"), ".")
        yield Advice(
            f"The sensors contradict each other with the ± of the {evaluation.widened}, and with "
            f"{evaluation.widening:.1f} times as great ones they do not: all standard deviations hold those. ",
            next_step,
        )


def refusal_verdict(error: TfsatError) -> Verdict:
    """Return the verdict on a drop that cannot be evaluated."""
    return Verdict("failed", error.what, tuple(text for text in (error.meaning, error.next_step) if text))


def _good(evaluation: Evaluation) -> str:
    passed = sum(check.verdict == "passed" for check in evaluation.checks)
    log = ignore_absent(evaluation.log, evaluation.model, missed=False)
    missed = int((~log.imu_valid).sum() + (~log.angle_valid).sum())
    samples = "no samples lost" if missed == 0 else f"no samples lost ({missed} single readings bridged)"
    return f"{passed} of {passed} checks passed, {samples}, calibration valid."


def _of_recording(evaluation: Evaluation) -> Iterator[str]:
    """Yield where the recording ends early, and the grave warnings of `decode` without their details."""
    last_s = float(evaluation.log.t_s[-1])
    if evaluation.instants.landing is None and last_s < FALL_US / 1e6:
        yield (
            f"The recording ends {last_s:.2f} s after the release, in the fall: all numbers are of what came before."
        )
    # Two releases are a matter of the fall, told there; indented lines are details of the one above.
    of_release = two_releases(evaluation.log.release)
    log = ignore_absent(evaluation.log, evaluation.model, missed=False)
    yield from (line for line in grave_warnings(log) if not line.startswith(" ") and line != of_release)


def _of_strokes(strokes: Sequence[FlownStroke]) -> Iterator[str]:
    for stroke in strokes:
        name = f"Stroke {stroke.number} (joint {stroke.joint})"
        if stroke.remark:
            yield f"{name}: {stroke.remark}"
        elif abs(stroke.short_rad) > max(
            OFF_SHARE * abs(stroke.commanded_rad), CERTAIN_STDS * stroke.size_std_rad
        ):
            # Beyond a servo's error and the measurement's: the file may be of another maneuver.
            came, commanded = np.rad2deg([stroke.size_rad, stroke.commanded_rad])
            yield (
                f"{name} went {came:+.1f} deg instead of {commanded:+.1f} deg: if that is no fault of the servo, "
                "another maneuver was flown than this one."
            )


def _of_fall(evaluation: Evaluation) -> Iterator[str]:
    of_release = two_releases(evaluation.log.release)
    if of_release is not None:
        yield of_release
    yield from evaluation.instants.findings
    yield from evaluation.micro_gravity.findings
    if evaluation.clocks is not None:
        for clock in (evaluation.clocks.sequencer, evaluation.clocks.video):
            yield from clock.findings if clock else ()
    if evaluation.release_velocity is not None:
        yield from _of_release(evaluation.release_velocity)


def _of_release(velocity: ReleaseVelocity) -> Iterator[str]:
    # Only an interval that lies wholly outside makes a drop doubtful; an uncertain one does not.
    for speed, judged, label in (
        (velocity.downward, velocity.downward_judged, "Release velocity, downwards"),
        (velocity.transversal_speed, velocity.transversal_judged, "Transversal velocity"),
    ):
        if judged == "outside" and speed is not None:
            yield f"{label}: {speed.value_mm_s:.0f} ± {speed.std_mm_s:.0f} mm/s, outside what the facility permits."


def _of_model(explained: ModelComparison) -> str:
    """Format why the correction of the model is unusable.

    The model is blamed only if it explains the motion neither as filed nor corrected.
    """
    if explained.nominal_explains or explained.fitted_explains:
        return "the correction of the model cannot be used"
    return "the model does not explain the motion, corrected or not"
