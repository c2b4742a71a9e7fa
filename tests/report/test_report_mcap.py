"""The evaluated drop as MCAP, read back by mcap's own reader and decoded by the schemas that the file carries."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from tests.paths import REPOSITORY
from tests.report.reported_drop import evaluate_run, report_drop
from tfsat_host.output_files import was_made_with
from tfsat_host.report.contents.replay import body_poses
from tfsat_host.report.foxglove_export import MARKER, write_evaluated_mcap

Topics = dict[str, list[tuple[int, Any]]]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("mcap") / "SD.evaluated.mcap"
    write_evaluated_mcap(report_drop(), place)
    return place


@pytest.fixture(scope="module")
def topics(path: Path) -> Topics:
    """(log time in ns, message) by topic."""
    messages_by_topic: Topics = defaultdict(list)
    before_ns = 0
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            assert message.log_time >= before_ns, channel.topic
            before_ns = message.log_time
            messages_by_topic[channel.topic].append((message.log_time, decoded))
    return messages_by_topic


def unix_ns(t_s: Any) -> list[int]:
    log = evaluate_run().log
    offset_us = log.origin_us + (log.unix_offset_us or 0)
    # In whole microseconds, as the logger counts: only then is the comparison exact.
    return [1000 * int(value) for value in np.rint(np.asarray(t_s) * 1e6).astype(np.int64) + offset_us]


def test_the_file_is_the_reports(path: Path) -> None:
    assert was_made_with(path, MARKER)


def test_the_recording_is_in_it_and_its_quick_look_is_not(topics: Topics) -> None:
    log = evaluate_run().log
    assert [time_ns for time_ns, _ in topics["/body_1/imu"]] == unix_ns(log.t_s)
    assert not [topic for topic in topics if topic.startswith("/quick_look")]


def test_joint_angles_come_with_their_deviations(topics: Topics) -> None:
    motion = evaluate_run().motion
    for joint in motion.joints:
        messages = topics[f"/evaluated/joint_{joint.joint}"]
        assert [time_ns for time_ns, _ in messages] == unix_ns(motion.t_s)
        rows = np.array([(m.angle_deg, m.angle_deg_std, m.rate_deg_s) for _, m in messages])
        rate = motion.fused.joint_rate_rad_s[:, joint.joint - 1]
        expected = np.rad2deg(np.column_stack([joint.angle_rad, joint.std_rad(), rate]))
        # The same numbers in another unit: no tolerance but rounding.
        np.testing.assert_allclose(rows, expected, rtol=1e-14)


def test_bodies_stand_where_the_replay_shows_them(topics: Topics) -> None:
    moved = body_poses(evaluate_run())
    for place, prefix, poses in (
        ("evaluated", "", moved.measured),
        ("model_filed", "model_filed/", moved.predicted),
    ):
        has_pose = np.isfinite(poses).all(axis=(1, 2))
        for body in range(4):
            messages = topics[f"/{place}/tf/body_{body + 1}"]
            assert [time_ns for time_ns, _ in messages] == unix_ns(moved.t_s[has_pose])
            assert {(m.parent_frame_id, m.child_frame_id) for _, m in messages} == {
                ("world", f"{prefix}body_{body + 1}")
            }
            # The last pose depends on the whole motion before it.
            last = messages[-1][1]
            place_m = (last.translation.x, last.translation.y, last.translation.z)
            turn = (last.rotation.x, last.rotation.y, last.rotation.z, last.rotation.w)
            np.testing.assert_allclose((*place_m, *turn), poses[has_pose][-1, body], rtol=1e-14)


def test_body_1_turns_as_far_as_was_found(topics: Topics) -> None:
    first, last = (topics["/evaluated/tf/body_1"][k][1].rotation for k in (0, -1))
    turns = [Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)) for turn in (first, last)]
    turned_deg = np.rad2deg((turns[0].inv() * turns[1]).magnitude())
    # By the base's gyro and the joints' angles, where the evaluation has body 1's own gyro.
    assert turned_deg == pytest.approx(np.rad2deg(evaluate_run().reorientation.angle_rad), abs=0.05)


def test_attitude_errors_of_both_models(topics: Topics) -> None:
    explained = evaluate_run().explained
    for place, sides in (("model_filed", explained.nominal), ("model_corrected", explained.fitted)):
        last = topics[f"/{place}/body_1/attitude_error"][-1][1]
        final, std = np.rad2deg(sides.error.final_rad), np.rad2deg(sides.error.std_rad[-1])
        np.testing.assert_allclose((last.z_deg, last.y_deg, last.x_deg), final, rtol=1e-14)
        np.testing.assert_allclose((last.z_deg_std, last.y_deg_std, last.x_deg_std), std, rtol=1e-14)


def test_momentum_of_the_corrected_model_is_calmer(topics: Topics) -> None:
    def spread(place: str) -> float:
        vectors = [m.momentum_g_m2_s for _, m in topics[f"/{place}/momentum_averaged"]]
        return float(np.std([(v.x, v.y, v.z) for v in vectors], axis=0).max())

    assert spread("model_corrected") < 0.3 * spread("model_filed")


def test_rates_and_euler_angles(topics: Topics) -> None:
    evaluation = evaluate_run()
    rates = [(m.rate_deg_s.x, m.rate_deg_s.y, m.rate_deg_s.z) for _, m in topics["/evaluated/body_2/rate"]]
    np.testing.assert_allclose(np.radians(rates), evaluation.motion.bodies[1].rate_rad_s, rtol=1e-13)
    last = topics["/evaluated/body_1/euler"][-1][1]
    final = np.rad2deg(evaluation.reorientation.euler_zyx_rad)
    np.testing.assert_allclose((last.z_deg, last.y_deg, last.x_deg), final, atol=1e-9)
    assert 0.0 < last.z_deg_std < 0.1


def test_boxes_hang_on_the_frames(topics: Topics) -> None:
    [(time_ns, scene)] = topics["/evaluated/scene"]
    # Once, at the release: the boxes move with their frames.
    assert [time_ns] == unix_ns([0.0])
    frames = {message.child_frame_id for topic in topics if "/tf/" in topic for _, message in topics[topic]}
    # Four bodies as measured and four of the model.
    assert {entity.frame_id for entity in scene.entities} == frames and len(frames) == 8
    body_2 = next(entity for entity in scene.entities if entity.frame_id == "body_2")
    [cube] = body_2.cubes
    assert (cube.size.x, cube.size.y, cube.size.z) == pytest.approx((0.1, 0.1, 0.112))
    assert cube.pose.position.z == pytest.approx(0.056) and cube.color.a == 1.0
    assert body_2.frame_locked


def test_verdict_and_strokes_are_told_in_words(topics: Topics) -> None:
    log_lines = [(time_ns, message.message) for time_ns, message in topics["/evaluated/log"]]
    texts = [text for _, text in log_lines]
    verdict = report_drop().verdict
    assert f"{verdict.level}: {verdict.sentence}" in texts
    stroke = evaluate_run().strokes[0]
    [begin] = [
        time_ns for time_ns, text in log_lines if text.startswith("1: joint 1") and not text.endswith("ends")
    ]
    [end] = [
        time_ns for time_ns, text in log_lines if text.startswith("1: joint 1") and text.endswith("ends")
    ]
    assert [begin, end] == unix_ns([stroke.start_s, stroke.end_s])


@pytest.mark.parametrize(
    ("results", "remaining_topics"),
    [
        (("rates", "attitudes", "strokes", "offsets"), {"/evaluated/log"}),
        (("offsets",), {"/evaluated/body_1/euler", "/model_filed/body_1/euler"}),
    ],
)
def test_what_a_failed_check_withholds_is_not_written(
    results: tuple[str, ...], remaining_topics: set[str], tmp_path: Path
) -> None:
    withheld = dict.fromkeys(results, "momentum throughout the fall")
    write_evaluated_mcap(report_drop(evaluate_run().with_withheld(withheld)), tmp_path / "withheld.mcap")
    with (tmp_path / "withheld.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    names = {channel.topic for channel in summary.channels.values()}
    written = {name for name in names if name.startswith(("/evaluated/", "/model_"))}
    assert remaining_topics <= written and not any(name.startswith("/model_corrected/") for name in written)
    assert len(results) == 1 or written == remaining_topics
    assert "/body_1/imu" in names, "the recording itself is not withheld"


def test_the_layout_for_foxglove_shows_what_is_in_the_file(topics: Topics) -> None:
    """Each curve's topic and field are there; each panel that is configured stands in the layout."""
    layout = json.loads((REPOSITORY / "docs" / "foxglove-layout.json").read_text(encoding="utf-8"))
    panels = layout["configById"]
    curves = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    assert len(curves) > 15
    for curve in curves:
        topic, *fields = curve.split(".")
        value = topics[topic][0][1]
        for name in fields:
            value = getattr(value, name)
        assert isinstance(value, float), curve
    assert {"/evaluated/scene"} == set(panels["3D!tfsat"]["topics"]) <= set(topics)
    assert panels["RosOut!words"]["topicToRender"] in topics
    shown = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))
    assert sorted(shown) == sorted(panels)


def test_every_topic_is_documented(topics: Topics) -> None:
    documented = re.findall(
        r"`(/[a-zN_/]+)`", (REPOSITORY / "docs" / "report.md").read_text(encoding="utf-8")
    )
    topic_names = {
        re.sub(r"_\d", "_N", topic) for topic in topics if topic.startswith(("/evaluated", "/model"))
    }
    assert set(documented) == topic_names
