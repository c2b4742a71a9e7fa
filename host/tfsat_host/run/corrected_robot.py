"""The robot file that a drop shows: as filed, with each number that the drop corrected, its ± and the drop with it.

All numbers of the fit are changed together, those that the drop tells little of too: they go together, and the next
drop is predicted by all of them. The file's `[uncertainty]` stays: it has no room for what goes together.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from datetime import datetime
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.config import with_entry
from tfsat_host.dynamics.multibody import across
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.model_comparison import ModelComparison
from tfsat_host.evaluation.com_fit.offsets import Kind, Parameter
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.model_result import correction_sentences, worth_of
from tfsat_host.robot import RobotFileError, RobotModel
from tfsat_host.robot.loading import parse_robot
from tfsat_host.run.files import CORRECTED_MARKER

MARKER = CORRECTED_MARKER
_DECIMALS = 6
_AXES = tuple("xyz")
_ENTRIES = {f"{'xyz'[i]}{'xyz'[k]}": (i, k) for i, k in combinations_with_replacement(range(3), 2)}
"""Of an inertia in a robot file."""


class Correction(NamedTuple):
    """What changes in one entry of a robot file, in the file's units.

    Attributes:
        path: Of the entry: `("body", 0, "com_mm")`.
        names: k names of its numbers; empty for a single number.
        change: (k,) what is added.
        std: (k,)
        value: (k,) after it.
    """

    path: tuple[str | int, ...]
    names: tuple[str, ...]
    change: FloatArray
    std: FloatArray
    value: FloatArray

    @property
    def entry(self) -> object:
        """As the file has it."""
        numbers = np.round(self.value, _DECIMALS).tolist()
        if self.path[-1] == "inertia_g_m2":
            return dict(zip(self.names, numbers, strict=True))
        return numbers if self.names else numbers[0]

    def words(self) -> str:
        """Format the changes with their standard deviations.

        Such as `x +0.52 ± 0.31, y -0.20 ± 0.30, z +0.11 ± 0.09`.
        """
        rows = zip(self.names or ("",), self.change.tolist(), self.std.tolist(), strict=True)
        return ", ".join(f"{name} {change:+.3g} ± {std:.2g}".strip() for name, change, std in rows)


def corrected_robot(evaluation: Evaluation, recorded: datetime | None = None) -> str:
    """Format the corrected robot file.

    Below its heading it is as filed where no correction is called for. `recorded` is the time of the release,
    if known.

    Raises:
        TfsatError: the correction is withheld, the file has entries of which several share a line, or the
            result is no robot, as with a center of mass outside of its body.
    """
    worth, text = worth_of(evaluation), _text(evaluation.model)
    # What its own checks withhold must not reach the file that the next drop is predicted with.
    if worth == "withheld":
        raise _refusal(
            " ".join(correction_sentences(evaluation)), "Cure what the checks name, and drop again."
        )
    drop = f"drop {evaluation.log.session:08x}"
    when = "" if recorded is None else f" of {recorded:%Y-%m-%d %H:%M:%S} UTC"
    heading = [f"{CORRECTED_MARKER.decode()}: {drop}{when}, of {evaluation.model.path.name}."]
    if worth == "not called for":
        heading += ["# Nothing is changed: the robot as filed explains the drop."]
    else:
        heading += ["# Each change stands with its standard deviation above what the file had, as comments."]
        for correction in corrections(evaluation):
            text = _with(text, correction, f"{drop}: {correction.words()}")
    text = "\n".join((*heading, "", text))
    # Read the result as any robot file: a fit may move a center of mass out of its body.
    try:
        parse_robot(text, evaluation.model.path)
    except RobotFileError as error:
        raise _refusal(
            f"The correction makes no robot. {error.what}",
            "Check that entry in the robot file: the drop contradicts it.",
        ) from error
    return text


def corrections(evaluation: Evaluation) -> Iterator[Correction]:
    """Yield the correction of each entry of the robot file that a drop changes."""
    fit, filed = evaluation.explained.fit, evaluation.model
    # With all offsets of the fit, nuisance parameters too: they are correlated with the others.
    body = fit.offsets.correct(fit.values)
    pairs = tuple(np.array(list(_ENTRIES.values())).T)
    # A file may give products of inertia, which stand negated in the tensor.
    signs = 1e3 * np.where(np.eye(3, dtype=bool), 1.0, -1.0 if _has_products(filed) else 1.0)[pairs]
    for b in range(filed.n_bodies):
        mass = np.array([filed.mass_kg[b], body.mass_kg[b]])
        # A mass is m e^x: its slope by x is the mass itself.
        std = _std(fit, "mass", b, lambda parameter: parameter.shape * body.mass_kg[parameter.of, None])
        yield from _find_corrections(("body", b, "mass_kg"), (), mass[:1], mass[1:], std)
        # Multibody counts from the global origin at zero angles, the file from the body's frame.
        com = 1e3 * (body.com_m[b] - filed.origin_m[b])
        std = _std(fit, "com", b, lambda parameter: 1e3 * parameter.shape)
        yield from _find_corrections(("body", b, "com_mm"), _AXES, 1e3 * filed.com_m[b], com, std)
        old, new = (signs * of.inertia_kg_m2[b][pairs] for of in (filed, body))
        # Fitted is the strain E of the second moments: the chain rule gives the tensor's entries.
        std = _std(
            fit,
            "inertia",
            b,
            lambda parameter: signs * fit.offsets.inertia_slope(parameter, fit.values)[pairs],
        )
        yield from _find_corrections(("body", b, "inertia_g_m2"), tuple(_ENTRIES), old, new, std)
    for j in range(filed.n_joints):
        old, new = (1e3 * of.joint_point_m[j] for of in (filed, body))
        std = _std(fit, "point", j, lambda parameter: 1e3 * parameter.shape)
        yield from _find_corrections(("joint", j, "point_mm"), _AXES, old, new, std)
    yield from _axes(evaluation.explained)


def _axes(explained: ModelComparison) -> Iterator[Correction]:
    """Yield the corrections of the hinge axes, which are estimated among the sensor errors."""
    fit, kinematics = explained.fit, explained.driven.flown
    # The covariance is in the order offsets, momentum, sensor errors; the hinges' tilts are among the last.
    filed, first = fit.offsets.body, len(fit.offsets) + len(fit.momentum_kg_m2_s)
    tilted = filed.tilt_hinges(kinematics.correct(fit.errors).tilt_rad).joint_axis
    for j, (old, new) in enumerate(zip(filed.joint_axis, tilted, strict=True)):
        # A turn u moves the axis a by u x a.
        slope = np.cross(across(old), old).T @ kinematics.tilt_errors[j]
        std = _root(slope @ fit.covariance[first:, first:] @ slope.T)
        yield from _find_corrections(("joint", j, "axis"), _AXES, old, new, std)


def _std(fit: ModelFit, kind: Kind, of: int, slope: Callable[[Parameter], FloatArray]) -> FloatArray | None:
    """(k,) of numbers with a slope (k,) by each parameter, in SI; None: the file takes them for exact."""
    of_it = [
        (at, parameter)
        for at, parameter in enumerate(fit.offsets.parameters)
        if (parameter.kind, parameter.of) == (kind, of)
    ]
    if not of_it:
        return None
    # (k, m) slopes by the entry's m parameters, from each one's unit to SI.
    slopes = np.column_stack([parameter.si * slope(parameter) for _, parameter in of_it])
    # First-order propagation with the correlations among these parameters, the others marginalized.
    places = [at for at, _ in of_it]
    return _root(slopes @ fit.covariance[np.ix_(places, places)] @ slopes.T)


def _root(covariance: FloatArray) -> FloatArray:
    # Rounding may leave a variance just below zero.
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _find_corrections(
    path: tuple[str | int, ...],
    names: tuple[str, ...],
    old: FloatArray,
    new: FloatArray,
    std: FloatArray | None,
) -> Iterator[Correction]:
    """Yield the correction of the entry, if its rounded value changes."""
    # Compare as written: a change below the last decimal of the file is none.
    if std is not None and (np.round(new, _DECIMALS) != np.round(old, _DECIMALS)).any():
        yield Correction(path, names, new - old, std, new)


def _has_products(filed: RobotModel) -> bool:
    return bool(tomllib.loads(_text(filed))["inertia_off_diagonals"] == "products")


def _text(filed: RobotModel) -> str:
    return filed.path.read_text(encoding="utf-8-sig").replace("\r\n", "\n")


def _with(text: str, correction: Correction, comment: str) -> str:
    try:
        return with_entry(text, correction.path, correction.entry, comment)
    except KeyError as error:
        where = f"{correction.path[-1]} of {correction.path[0]} {int(correction.path[1]) + 1}"
        raise _refusal(
            f"{where} shares a line of the robot file with other entries.",
            "Give each entry a line of its own, as robots/drop_tower.toml does.",
        ) from error


def _refusal(what: str, next_step: str) -> TfsatError:
    return TfsatError(what=what, meaning="No corrected robot was written.", next_step=next_step)
