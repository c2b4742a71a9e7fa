"""What an evaluation is worth, in one word, one sentence and the reasons.

`good`: nothing speaks against any number. `doubtful`: the numbers are there, but something failed a check, is missing
or was stood in for. `failed`: there are no numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.com_fit.prediction import ModelComparison
from tfsat_host.evaluation.evaluation import CERTIFICATE, Evaluation
from tfsat_host.evaluation.laser_velocity import ReleaseVelocity
from tfsat_host.evaluation.strokes import FlownStroke
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.sdlog.contradictions import two_releases
from tfsat_host.sdlog.summary import grave_warnings

Level = Literal["good", "doubtful", "failed"]

OFF_SHARE = 0.15
"""Of a stroke: a servo as the paper's came 7 % short; what misses by more was not the stroke that was commanded."""
CERTAIN_STDS = 3.0


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

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as a dict for JSON."""
        return {"level": self.level, "sentence": self.sentence, "reasons": list(self.reasons)}


def verdict_of(
    found: Evaluation, against_calibration: Sequence[str] = (), against_maneuver: Sequence[str] = ()
) -> Verdict:
    """Judge one drop.

    Args:
        found: The evaluation.
        against_calibration: Objections to the certificate that the evaluation itself cannot see: that it is of
            other sensors, or how old it is. Sentences.
        against_maneuver: Why the maneuver's file is not what was commanded. Sentences.
    """
    failed = [check.sentence for check in found.failed_checks]
    moved = [one.remark for one in found.standing if one.unexpected]
    groups: tuple[tuple[str, Iterable[str]], ...] = (
        (f"{len(failed)} check{'' if len(failed) == 1 else 's'} failed", failed),
        ("results are withheld", _withheld(found)),
        (
            f"all ± are as if the {found.widened} were {found.widening:.1f} times less sure",
            _widening_reasons(found),
        ),
        ("the recording is not whole", _of_recording(found)),
        ("the calibration does not hold as it is", against_calibration),
        ("another maneuver than maneuver.toml was flown", against_maneuver),
        ("something stands in for data that is missing", found.notes),
        ("not every stroke was flown as commanded", _of_strokes(found.strokes)),
        ("a joint moved where it should stand", moved),
        ("the fall was not as it should be", _of_fall(found)),
        (_of_model(found.explained), found.explained.withheld if found.gives() else ()),
    )
    present = {sentence: list(reasons) for sentence, reasons in groups}
    sentence = "; ".join(one for one, reasons in present.items() if reasons)
    kind = "EMULATED robot. " if found.log.is_emulated else ""
    if not sentence:
        return Verdict("good", kind + _good(found), ())
    reasons = tuple(dict.fromkeys(reason for some in present.values() for reason in some))
    return Verdict("doubtful", f"{kind}{sentence[:1].upper()}{sentence[1:]}.", reasons)


def _withheld(found: Evaluation) -> Iterator[str]:
    names = [name for name in found.withheld if name != "offsets"]
    if not names:
        return
    by_name = {check.name: check for check in found.checks}
    worst = (by_name[name] for name in dict.fromkeys(found.withheld[name] for name in names))
    checks = ", ".join(f"{check.name} ({check.excess:.2g} times its limit)" for check in worst)
    why = (
        f"errors {found.widest:.3g} times as great as stated do not explain it"
        if found.widest > 1.0
        else "no greater errors of the certificate describe such a fault"
    )
    yield f"Withheld, with all that follows from it: {', '.join(names)}. Failed: {checks}; {why}."


def _widening_reasons(found: Evaluation) -> Iterator[str]:
    if found.widening > 1.0:
        certified = found.widened == CERTIFICATE
        next_step = "Calibrate again: tfsat-host calibrate show." if certified else "Measure the hinges."
        yield (
            f"The sensors contradict each other with the ± of the {found.widened}, and with {found.widening:.1f} times "
            f"as great ones they do not: all standard deviations hold those. {next_step}"
        )


def refusal_verdict(error: TfsatError) -> Verdict:
    """Return the verdict on a drop that cannot be evaluated."""
    return Verdict("failed", error.what, tuple(text for text in (error.meaning, error.next_step) if text))


def _good(found: Evaluation) -> str:
    passed = sum(check.verdict == "passed" for check in found.checks)
    checks = "the one check passed" if passed == 1 else f"all {passed} checks passed"
    missed = int((~found.log.imu_valid).sum() + (~found.log.angle_valid).sum())
    samples = "no sample is missing" if missed == 0 else f"single missed readings ({missed}) are bridged"
    return f"Nothing speaks against it: {checks}, {samples}, the calibration holds."


def _of_recording(found: Evaluation) -> Iterator[str]:
    """Yield where the recording ends early, and the grave warnings of `decode` without their details."""
    last_s = float(found.log.t_s[-1])
    if found.instants.landing is None and last_s < FALL_US / 1e6:
        yield (
            f"The recording ends {last_s:.2f} s after the release, in the fall: all numbers are of what came before."
        )
    of_release = two_releases(found.log.release)
    yield from (line for line in grave_warnings(found.log) if not line.startswith(" ") and line != of_release)


def _of_strokes(strokes: Sequence[FlownStroke]) -> Iterator[str]:
    for stroke in strokes:
        name = f"Stroke {stroke.number} (joint {stroke.joint})"
        if stroke.remark:
            yield f"{name}: {stroke.remark}"
        elif abs(stroke.short_rad) > max(
            OFF_SHARE * abs(stroke.commanded_rad), CERTAIN_STDS * stroke.size_std_rad
        ):
            came, commanded = np.rad2deg([stroke.size_rad, stroke.commanded_rad])
            yield (
                f"{name} went {came:+.1f} deg instead of {commanded:+.1f} deg: if that is no fault of the servo, "
                "another maneuver was flown than this one."
            )


def _of_fall(found: Evaluation) -> Iterator[str]:
    of_release = two_releases(found.log.release)
    if of_release is not None:
        yield of_release
    yield from found.instants.findings
    yield from found.micro_gravity.findings
    if found.clocks is not None:
        for clock in (found.clocks.sequencer, found.clocks.video):
            yield from clock.findings if clock else ()
    if found.release_velocity is not None:
        yield from _of_release(found.release_velocity)


def _of_release(velocity: ReleaseVelocity) -> Iterator[str]:
    if velocity.downward_judged == "outside":
        speed = velocity.downward
        yield (
            f"The robot left the release mechanism at {speed.value_mm_s:.0f} ± {speed.std_mm_s:.0f} mm/s downwards: "
            "outside what the facility permits."
        )
    if velocity.transversal_judged == "outside" and velocity.transversal_speed is not None:
        speed = velocity.transversal_speed
        yield (
            f"The robot drifted sideways at {speed.value_mm_s:.0f} ± {speed.std_mm_s:.0f} mm/s: more than the "
            "facility permits."
        )


def _of_model(explained: ModelComparison) -> str:
    """Format why the correction of the model is unusable.

    The model is blamed only if it explains the motion neither as filed nor corrected.
    """
    if explained.explains_before or explained.explains_after:
        return "the correction of the model cannot be used"
    return "the model does not explain the motion, corrected or not"
