"""The curves and the replay of the report, against each other and against free fall."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.report.reported_drop import drop_of, evaluate_run, numbers, plots, series
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.report.contents.attitude_charts import euler_angles
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.replay import body_poses


def test_every_line_fits_its_axis(drop: Any) -> None:
    for plot in drop["plots"]:
        x = drop["t_s"] if plot["x"] is None else plot["x"]
        assert np.all(np.diff(x) > 0.0)
        assert len({line["label"] for line in plot["series"]}) == len(plot["series"]), plot["id"]
        for line in plot["series"]:
            assert len(line["values"]) == len(x)
            assert line["std"] is None or len(line["std"]) == len(x)
            # A line of gaps alone has a name in the legend and nothing to show.
            assert any(value is not None for value in line["values"])
    assert {
        "euler",
        "rates",
        "joints",
        "momentum",
        "momentum_spectrum",
        "rate_spectrum",
        "attitude_error",
    } <= {plot["id"] for plot in drop["plots"]}


def test_attitude_curves_differ_by_the_attitude_error(drop: Any) -> None:
    curves, errors = series(plots(drop)["euler"]), series(plots(drop)["attitude_error"])
    bands = {curve["label"]: curve["std"] for curve in plots(drop)["euler"]["series"]}
    # The errors are as late as the gyros: only at rest they are the same, but for what joint rates and joint angles
    # tell differently.
    late = np.array(drop["t_s"]) > 2.3
    for axis in "xyz":
        measured = curves[f"φ{axis} measured"]
        for model in ("nominal model", "fitted model"):
            apart = measured - curves[f"φ{axis} {model}"] - errors[f"δφ{axis} {model}"]
            # The corrected model stands next to gyros without the errors that the fit found in them; the measured curve
            # is the gyros' with them: they are apart by these, and no further than its band allows.
            band = np.array(bands[f"φ{axis} measured"], dtype=np.float64)[late]
            allowance = 2.0 * band if model == "fitted model" else 0.0
            assert np.all(np.abs(apart[late]) < 0.04 + allowance)


def test_models_begin_where_the_measured_attitude_is() -> None:
    curves = {line.label: line.values for line in charts_of(evaluate_run())["euler"].lines}
    for axis in "xyz":
        measured = curves[f"φ{axis} measured"]
        for model in ("nominal model", "fitted model"):
            predicted = curves[f"φ{axis} {model}"]
            first = int(np.isfinite(predicted).argmax())
            assert np.isnan(predicted[:first]).all() and 0.02 < evaluate_run().motion.t_s[first] < 0.05
            assert (
                predicted[first] == pytest.approx(measured[first], abs=1e-9) and abs(measured[first]) > 1e-3
            )


def test_deviation_of_the_euler_angles_is_that_of_the_attitude() -> None:
    evaluation = evaluate_run()
    body, angles = evaluation.motion.bodies[0], euler_angles(evaluation)
    middle = int(np.searchsorted(body.t_s, 1.4))  # the joints are open, all three angles away from zero
    rng = np.random.default_rng(1)
    turns = rng.multivariate_normal(np.zeros(3), body.covariance(middle), 20_000)
    sample_angles = euler_zyx_rad((Rotation.from_rotvec(turns) * body.attitude[middle]).as_matrix())
    assert angles.std_rad[middle] == pytest.approx(sample_angles.std(axis=0), rel=0.03)


def test_momentum_is_calmer_after_the_correction(drop: Any) -> None:
    averaged, spectrum = plots(drop)["momentum"], plots(drop)["momentum_spectrum"]
    for axis in "xyz":
        lines = series(averaged)
        before, after = (np.nanstd(lines[f"h{axis} {word} model"]) for word in ("nominal", "fitted"))
        # Without torque the momentum is constant: what is left of its changes is the model's error.
        assert after < 0.3 * before
    assert spectrum["log_x"] and spectrum["log_y"] and spectrum["band"][1] == 5.0
    low = np.array(spectrum["x"]) <= 5.0
    lines = series(spectrum)
    assert np.all(lines["hy fitted model"][low].max() < 0.3 * lines["hy nominal model"][low].max())


def test_forces_show_gravity_until_the_release_and_none_after(drop: Any) -> None:
    forces, t_s = series(plots(drop)["forces"]), np.array(drop["t_s"])
    for body in "1234":
        force = forces[f"body {body}"]
        # Hanging, an accelerometer shows 1 g.
        assert np.median(force[t_s < -0.05]) == pytest.approx(1.0, abs=0.05)
        # Falling, and before the first stroke at 0.7 s, it shows nothing.
        assert np.median(force[(t_s > 0.1) & (t_s < 0.6)]) < 0.02


def test_replay_turns_about_the_center_of_mass(drop: Any) -> None:
    evaluation, moved_bodies = evaluate_run(), body_poses(evaluate_run())
    model, offsets = evaluation.model, evaluation.explained.driven.offsets
    corrected = offsets.correct(evaluation.explained.fit.values)
    ghost = moved_bodies.predicted
    assert drop["replay"]["model"][0][0] == [None] * 7  # the release has not settled
    for moved, body in ((moved_bodies.measured, corrected), (ghost[20:], offsets.body)):
        com, share = body.com_m - model.origin_m, body.mass_kg / body.mass_kg.sum()
        rotation = (
            Rotation.from_quat(moved[..., 3:].reshape(-1, 4)).as_matrix().reshape(*moved.shape[:2], 3, 3)
        )
        center = np.einsum("b,kbi->ki", share, moved[..., :3] + np.einsum("kbij,bj->kbi", rotation, com))
        assert np.abs(center).max() < 1e-9
        # Neighbours keep their hinge: the same point by either body's frame.
        for joint in range(model.n_joints):
            ends = [
                moved[:, b, :3] + rotation[:, b] @ (body.joint_point_m[joint] - model.origin_m[b])
                for b in (int(model.joint_inner[joint]), int(model.joint_outer[joint]))
            ]
            assert np.abs(ends[0] - ends[1]).max() < 1e-9
    last = [Rotation.from_quat(poses[-1][0][3:]) for poses in (moved_bodies.measured, ghost)]
    apart_deg = np.rad2deg((last[0].inv() * last[1]).magnitude())
    expected = numbers(drop)["Attitude error, nominal model"]["value"]
    assert apart_deg == pytest.approx(expected, rel=0.1)


def test_boxes_are_the_robot_files(drop: Any) -> None:
    # Body 2 of robots/drop_tower.toml, from its corner, m.
    assert drop["replay"]["bodies"][1] == {"name": "body 2", "boxes_m": [[[0, 0, 0], [0.1, 0.1, 0.112]]]}


CHECK = "gyros of bodies 3 and 4"


def kinds_drawn(drop: Any) -> dict[str, set[str]]:
    """Return the kinds of lines of each plot that a check can withhold."""
    # What a failed check is judged by stays visible.
    evidence = ("gyro_residuals", "window", "forces")
    return {
        plot["id"]: {line["kind"] for line in plot["series"]}
        for plot in drop["plots"]
        if plot["id"] not in evidence
    }


def test_curves_that_a_failed_check_withholds_are_not_drawn() -> None:
    withheld = dict.fromkeys(("rates", "attitudes", "strokes", "offsets"), CHECK)
    drop = drop_of(evaluate_run().with_withheld(withheld))
    kinds_by_plot = kinds_drawn(drop)
    assert kinds_by_plot.pop("joints") == {"commanded"}
    assert set().union(*kinds_by_plot.values()) == set()
    by_id = plots(drop)
    for name in kinds_by_plot:
        assert by_id[name]["withheld"] == f"withheld: “{CHECK}” (check failed)"
        assert by_id[name]["caption"] == "", "its numbers are withheld, too"
    assert by_id["joints"]["withheld"] == f"measured withheld: “{CHECK}” (check failed)"
    assert by_id["forces"]["series"] and by_id["gyro_residuals"]["series"], "the check's own evidence stays"
    assert drop["replay"] is None and drop["no_replay"] == f"Replay withheld: “{CHECK}” (check failed)"
    assert drop["prediction"]["rows"][0][1] == "withheld"


def test_a_withheld_correction_withholds_the_fitted_model_only() -> None:
    drop = drop_of(evaluate_run().with_withheld({"offsets": "momentum throughout the fall"}))
    kinds_by_plot, by_id = kinds_drawn(drop), plots(drop)
    assert kinds_by_plot["euler"] == {"measured", "before"} and kinds_by_plot["attitude_error"] == {"before"}
    assert not any("after" in kinds for kinds in kinds_by_plot.values())
    note = "fitted model withheld: “momentum throughout the fall” (check failed)"
    assert {by_id[name]["withheld"] for name in ("euler", "momentum", "rate_spectrum")} == {note}
    assert by_id["rates"]["withheld"] == ""
    assert drop["replay"] is not None


def test_a_withheld_micro_gravity_is_not_drawn() -> None:
    forces = plots(drop_of(evaluate_run().with_withheld({"micro-gravity": "gravity at rest"})))["forces"]
    assert forces["series"] == [] and forces["withheld"] == "withheld: “gravity at rest” (check failed)"
