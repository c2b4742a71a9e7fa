"""The robot file that a drop shows: what stands in it, and how well it predicts the next drop of the same robot."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.commanded import evaluate
from tests.evaluation.drops import few_of
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.model_comparison import EXPECTED_DISTANCE
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate as evaluation_of
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.hidden import draw_hidden, hidden_drop
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.robot.loading import parse_robot
from tfsat_host.run.corrected_robot import MARKER, corrected_robot, corrections

FILED = load_robot()
ROBOT = 3


@cache
def fallen(robot: int, day: int = 0, a_deg: float = 59.0, b_deg: float = 70.0) -> Evaluation:
    """Evaluate a drop of a hidden robot with its file's model.

    On another `day` the initial rates and the noise differ.
    """
    truth = draw_hidden(FILED, robot)
    if day:
        # The same robot with another day's rates and noise.
        other = draw_hidden(FILED, 1000 + day)
        truth = replace(truth, rate_rad_s=other.rate_rad_s, seed=other.seed)
    drop = hidden_drop(schedule_maneuver(four_stroke(a_deg, b_deg)), FILED, truth)
    return evaluation_of(drop.log, FILED, drop.calibration, drop.schedule)


def again(evaluation: Evaluation, model: RobotModel) -> Evaluation:
    """Evaluate the same drop with another robot file."""
    return evaluation_of(evaluation.log, model, evaluation.calibration, evaluation.schedule)


def correct_robot(evaluation: Evaluation) -> RobotModel:
    return parse_robot(corrected_robot(evaluation), Path("corrected.toml"))


@pytest.mark.parametrize("robot", few_of(ROBOT, *range(4, 10)))
def test_the_next_drop_is_predicted_by_it(robot: int) -> None:
    model = correct_robot(fallen(robot))
    for next_drop in (fallen(robot, 1), fallen(robot, 2, 80.0, 50.0)):
        as_filed = next_drop.explained.nominal.error
        by_it = again(next_drop, model).explained.nominal.error
        # The filed model must be wrong by enough that a correction can show.
        assert np.rad2deg(as_filed.final_norm_rad) > 0.2
        assert by_it.final_norm_rad < min(np.deg2rad(0.07), 0.05 * as_filed.final_norm_rad)
        # A robot file says not how far the correction itself is uncertain.
        assert by_it.mahalanobis < 3.0 * EXPECTED_DISTANCE


def test_all_that_the_fit_found_stands_in_it() -> None:
    evaluation = fallen(ROBOT)
    fit = evaluation.explained.fit
    # Hinge tilts come from the sensors' errors, not from the model's parameters.
    tilt_rad = evaluation.explained.driven.flown.correct(fit.errors).tilt_rad
    expected_body, there = (
        fit.offsets.correct(fit.values).tilt_hinges(tilt_rad),
        Multibody.of(correct_robot(evaluation)),
    )
    for name in ("mass_kg", "com_m", "inertia_kg_m2", "joint_axis", "joint_point_m"):
        # 2e-6: the file is written to so many digits.
        np.testing.assert_allclose(
            getattr(there, name), getattr(expected_body, name), rtol=0.0, atol=2e-6, err_msg=name
        )
    np.testing.assert_allclose(there.inertia_kg_m2, expected_body.inertia_kg_m2, rtol=0.0, atol=2e-9)
    assert np.abs(tilt_rad).max() > 1e-3, "a hinge that leans is needed to see that it stands there"


def test_each_change_has_its_deviation_and_its_drop_above_what_stood_there() -> None:
    evaluation = fallen(ROBOT)
    text = corrected_robot(evaluation)
    lines = text.splitlines()
    assert text.startswith(MARKER.decode()) and f"{evaluation.log.session:08x}" in lines[0]
    changes = list(corrections(evaluation))
    # Mass, CoM and inertia a body, axis and point a joint.
    assert len(changes) == 3 * FILED.n_bodies + 2 * FILED.n_joints
    for change in changes:
        at = lines.index(f"# drop {evaluation.log.session:08x}: {change.words()}")
        assert lines[at + 1].startswith(f"# {change.path[-1]} = ")
        assert lines[at + 2].startswith(f"{change.path[-1]} = ")
    # What was not changed, comments included, is the file's own.
    other_lines = [line for line in lines if line not in corrected_robot_lines(lines)]
    assert set(FILED.path.read_text().splitlines()) >= {
        line for line in other_lines[3:] if line.startswith("#")
    }


def corrected_robot_lines(lines: list[str]) -> set[str]:
    """Return the lines that state changes, old and new."""
    starts = [at for at, line in enumerate(lines) if line.startswith("# drop ")]
    return {lines[at + k] for at in starts for k in range(3)}


def test_the_deviations_are_those_of_the_fit() -> None:
    evaluation = fallen(ROBOT)
    stated = {correction.path: correction.std for correction in corrections(evaluation)}
    fit = evaluation.explained.fit
    random = np.random.default_rng(1)
    # Draws from the covariance of the fit; their spread must be the stated one.
    far = random.multivariate_normal(np.zeros(len(fit.covariance)), fit.covariance, 600)
    p = len(fit.values)
    samples_by_path: dict[object, list[FloatArray]] = {}
    for deviation in far:
        # A tenth of a deviation: what is not linear stays small.
        other = replace(
            fit, values=fit.values + 0.1 * deviation[:p], errors=fit.errors + 0.1 * deviation[p + 3 :]
        )
        for change in corrections(with_fit(evaluation, other)):
            samples_by_path.setdefault(change.path, []).append(change.value)
    for path, std in stated.items():
        np.testing.assert_allclose(
            10.0 * np.std(samples_by_path[path], axis=0), std, rtol=0.15, atol=1e-4, err_msg=str(path)
        )


def with_fit(evaluation: Evaluation, fit: ModelFit) -> Evaluation:
    return replace(evaluation, explained=replace(evaluation.explained, fit=fit))


def test_a_file_with_tensors_in_tables_of_their_own_is_corrected_too(tmp_path: Path) -> None:
    evaluation = fallen(ROBOT)
    text = FILED.path.read_text()
    i = text.index("inertia_g_m2 =")
    line = text[i : text.index("\n", i)]
    table = "[body.inertia_g_m2]\nxx = 3.97\nxy = 0.01\nxz = 0.08\nyy = 4.10\nyz = -0.09\nzz = 2.27\n"
    # The same tensor in another form: a table of its own instead of products in a line.
    boxes = "boxes_mm = [[[0, 0, 0], [100, 100, 168]]]\n"
    text = text.replace(line + "\n" + boxes, boxes + table).replace('= "products"', '= "tensor"')
    for old in ("xy = -0.01", "xz = -0.07", "yz = 0.08", "xz = -0.09", "yz = 0.09", "yz = -0.01"):
        # The file has products of inertia, a tensor has them negated.
        text = text.replace(old, old.replace("= -", "= +") if "= -" in old else old.replace("= ", "= -"))
    other = tmp_path / "other.toml"
    # Byte order mark and Windows line ends, as an editor may leave them.
    other.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    model = load_robot(other)
    np.testing.assert_allclose(model.inertia_kg_m2, FILED.inertia_kg_m2)
    same, mine = correct_robot(evaluation), correct_robot(replace(evaluation, model=model))
    np.testing.assert_allclose(mine.inertia_kg_m2, same.inertia_kg_m2, rtol=0.0, atol=1e-12)


def test_entries_that_share_a_line_are_refused(tmp_path: Path) -> None:
    inner = tmp_path / "inline.toml"
    text = FILED.path.read_text().replace("[uncertainty]", "[uncertainty]\n")
    head, body = text.split("[[body]]", 1)
    first, rest = body.split("[[body]]", 1)
    rows = [row.strip() for row in first.splitlines() if row and not row.startswith("#")]
    # Six entries of body 1, which become one inline table.
    assert rest and len(rows) == 6
    inner.write_text(text)
    evaluation = replace(fallen(ROBOT), model=replace(FILED, path=inner))
    inner.write_text(head + "body = [{" + ", ".join(rows) + "}]\n")
    with pytest.raises(TfsatError, match="shares a line") as refused:
        corrected_robot(evaluation)
    assert "mass_kg of body 1" in refused.value.what


def test_a_center_of_mass_outside_of_its_body_makes_no_robot(tmp_path: Path) -> None:
    evaluation = fallen(ROBOT)
    fit = evaluation.explained.fit
    at = fit.offsets.names.index("body 4 CoM y")
    far = fit.values.copy()
    # 9 mm off: outside of body 4's box.
    far[at] = -9.0
    with pytest.raises(TfsatError, match="makes no robot") as refused:
        corrected_robot(with_fit(evaluation, replace(fit, values=far)))
    assert "outside of the boxes" in refused.value.what


def test_nothing_is_filed_of_a_correction_that_is_withheld_or_not_called_for() -> None:
    evaluation = fallen(ROBOT)
    failed = replace(evaluation.checks[0], verdict="failed", protects=("offsets",))
    with pytest.raises(TfsatError, match="withheld"):
        corrected_robot(replace(evaluation, checks=(failed,)))
    # By a file that is right: one corrected by another drop is as uncertain as this drop is.
    own = again(fallen(ROBOT, 2), draw_hidden(FILED, ROBOT).model)
    text = corrected_robot(replace(own, model=replace(own.model, path=FILED.path)))
    assert "Nothing is changed" in text
    assert text.endswith(FILED.path.read_text()), "the file as it was, below the heading"


def test_the_command_writes_it_and_says_what_to_type_next(run: Path) -> None:
    result = evaluate("run", "--corrected-robot", "corrected.toml")
    # What was flown, which need not be 59/70.
    assert result.code == 0
    assert "tfsat-host simulate --file run/maneuver.toml --robot corrected.toml" in " ".join(
        result.err.split()
    )
    assert load_robot("corrected.toml").mass_kg.sum() == pytest.approx(2.847, rel=0.05)
    assert evaluate("run", "--corrected-robot", "corrected.toml").code == 0, "its own file is written again"
    mine = run.parent / "mine.toml"
    mine.write_text("")
    # A file that the program did not write is never overwritten.
    assert evaluate("run", "--corrected-robot", "mine.toml").code == 1 and mine.read_text() == ""
    several = evaluate("run", "run/SD.bin", "--corrected-robot", "other.toml")
    assert several.code == 2 and "of one drop" in several.err and not Path("other.toml").exists()
