"""MCAP, read back by mcap's own reader and decoded by the schemas that the file carries."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foxglove import messages
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from tests.cli.process import RunCli
from tests.sdlog.encoder import drop_with_release
from tests.sdlog.motion import RATE_COUNTS, moving_log
from tests.sdlog.test_values import write
from tfsat_host.evaluation.body_frames import body_frames
from tfsat_host.quantity import record
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.export_mcap import METADATA_NAME, QUICK_LOOK, BodyFrames, write_mcap
from tfsat_host.sdlog.log_summary import METADATA
from tfsat_host.sdlog.protobuf_rows import FRAME_TRANSFORM, RowEncoder, foxglove_kind, message_class

NO_FRAMES = BodyFrames((), (), ())
ANGLES = [f"joint{joint}_sensor{number}_deg" for joint in (1, 2, 3) for number in (1, 2)]

Topics = dict[str, list[tuple[int, Any]]]


@pytest.fixture
def log(tmp_path: Path) -> DropLog:
    return load(write(tmp_path / "SD.bin", drop_with_release()[0].image()))


def write_topics(log: DropLog, path: Path, frames: BodyFrames | None = None) -> Topics:
    """(log time in ns, message) by topic, in the order of the file, which is by time."""
    write_mcap(log, path, body_frames(log, load_robot()) if frames is None else frames)
    topics: Topics = defaultdict(list)
    before_ns = 0
    with path.open("rb") as file:
        # Decoded by the schema in the file, not by ours.
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            # By time: a viewer reads it once and in order.
            assert message.log_time >= before_ns, channel.topic
            before_ns = message.log_time
            assert message.publish_time == message.log_time
            stamp = decoded.timestamp
            assert stamp.seconds * 1_000_000_000 + stamp.nanos == message.log_time
            topics[channel.topic].append((message.log_time, decoded))
    return topics


def test_every_reading_comes_back(log: DropLog, tmp_path: Path) -> None:
    topics = write_topics(log, tmp_path / "SD.mcap")
    # Nanoseconds of the logger's clock, microseconds times 1000.
    times_ns = (log.t_us * 1000).tolist()
    for body in range(4):
        messages = topics[f"/body_{body + 1}/imu"]
        assert [time_ns for time_ns, _ in messages] == times_ns
        rate = [(m.rate_deg_s.x, m.rate_deg_s.y, m.rate_deg_s.z) for _, m in messages]
        # In the message as degrees, in the log as radians.
        np.testing.assert_allclose(np.radians(rate), log.rate_rad_s[:, body], rtol=1e-14)
        force = [
            (m.specific_force_m_s2.x, m.specific_force_m_s2.y, m.specific_force_m_s2.z) for _, m in messages
        ]
        np.testing.assert_array_equal(force, log.specific_force_m_s2[:, body])
        warmth = [m.temperature_c for _, m in messages]
        np.testing.assert_allclose(warmth, log.temperature_c[:, body], rtol=1e-14)
        assert [m.clipped for _, m in messages] == log.clipped[:, body].tolist()
    assert [time_ns for time_ns, _ in topics["/angle_sensors"]] == times_ns
    angles = np.radians([[getattr(m, name) for name in ANGLES] for _, m in topics["/angle_sensors"]])
    np.testing.assert_allclose(angles, log.sensor_angle_rad, rtol=1e-14)


def test_switches_are_told_where_they_change_and_ten_times_a_second(log: DropLog, tmp_path: Path) -> None:
    shown = write_topics(log, tmp_path / "SD.mcap")["/release_switches"]
    rows = {time_us * 1000: row for row, time_us in enumerate(log.t_us.tolist())}
    told = [rows[time_ns] for time_ns, _ in shown]
    states = [(m.switch1_open, m.switch2_open) for _, m in shown]
    assert states == [tuple(row) for row in log.switch_open[told].tolist()]
    # Held from message to message they are the recording's.
    held = np.array(states)[np.searchsorted(told, np.arange(len(log)), side="right") - 1]
    assert np.array_equal(held, log.switch_open)
    # Drawn as a line from message to message they are its steps: each change has the samples on its both sides.
    changes = np.flatnonzero((np.diff(log.switch_open.astype(np.int8), axis=0) != 0).any(axis=1))
    assert set(changes) | set(changes + 1) <= set(told)
    assert max(np.diff(log.t_us[told])) < 0.11e6
    assert len(told) < len(log) / 10


def test_invalid_readings_are_left_out(log: DropLog, tmp_path: Path) -> None:
    imu_valid, angle_valid, clipped = log.imu_valid.copy(), log.angle_valid.copy(), log.clipped.copy()
    # Body 2 for ten samples, body 4 throughout, one angle and all angles of a sample, and two clip flags.
    imu_valid[10:20, 1] = False
    imu_valid[:, 3] = False
    angle_valid[5, 2] = angle_valid[7] = False
    clipped[30, 0] = clipped[40, 2] = True
    holed = replace(log, imu_valid=imu_valid, angle_valid=angle_valid, clipped=clipped)
    # Without frames: the test is about readings.
    topics = write_topics(holed, tmp_path / "SD.mcap", NO_FRAMES)
    assert [t for t, _ in topics["/body_2/imu"]] == (log.t_us[imu_valid[:, 1]] * 1000).tolist()
    rate = [m.rate_deg_s.x for _, m in topics["/body_2/imu"]]
    np.testing.assert_allclose(np.radians(rate), log.rate_rad_s[imu_valid[:, 1], 1, 0], rtol=1e-14)
    # A sensor without a single reading has no topic.
    assert "/body_4/imu" not in topics
    # Beside a sensor that answered another one's missing reading is no number; without any there is no message.
    shown = np.array([[getattr(m, name) for name in ANGLES] for _, m in topics["/angle_sensors"]])
    assert len(shown) == len(log) - 1
    assert np.argwhere(np.isnan(shown)).tolist() == [[5, 2]]
    assert len(topics["/body_1/imu"]) == len(log)
    for body, row in ((1, 30), (3, 40)):
        assert [i for i, (_, m) in enumerate(topics[f"/body_{body}/imu"]) if m.clipped] == [row]


def test_events_in_numbers_and_in_words(log: DropLog, tmp_path: Path) -> None:
    topics = write_topics(log, tmp_path / "SD.mcap")
    got = [(m.t_us, m.t_s, m.event, m.index, m.arg, m.value) for _, m in topics["/events"]]
    events = log.events
    assert got == [(e.t_us, log.seconds(e.t_us), e.name, e.index, e.arg, e.value) for e in events]
    lines = [(m.level, m.message) for _, m in topics["/log"]]
    info = next(m.INFO for _, m in topics["/log"])
    assert (info, "stroke index=3 arg=0 value=0") in lines
    # The line that names t = 0 stands at the release's time.
    at_ns, zero = next((t, m) for t, m in topics["/log"] if m.message.startswith("t = 0"))
    assert (at_ns, zero.message) == (log.origin_us * 1000, "t = 0: release")


def test_what_is_wrong_with_a_recording_is_its_first_message(tmp_path: Path) -> None:
    blocks = drop_with_release()[0].blocks
    # A block in the middle and the end are missing.
    damaged = load(write(tmp_path / "SD.bin", b"".join(blocks[:30] + blocks[31:-1])))
    topics = write_topics(damaged, tmp_path / "SD.mcap")
    first = [m.message for t, m in topics["/log"] if t == damaged.t_us[0] * 1000 and m.level == m.WARNING]
    assert any("samples are lost" in line for line in first)
    assert any("recording has no end" in line for line in first)
    assert any("uncalibrated quick look" in line for line in first)


def test_transforms_of_a_known_motion(tmp_path: Path) -> None:
    log = moving_log(tmp_path / "SD.bin")
    topics = write_topics(log, tmp_path / "SD.mcap")
    frames = {topic: messages for topic, messages in topics.items() if topic.startswith("/quick_look/tf/")}
    # The tree as a viewer draws it: who hangs from whom.
    tree = {
        (message.parent_frame_id, message.child_frame_id)
        for messages in frames.values()
        for _, message in messages
    }
    expected = {("world", "body_3"), ("body_3", "body_2"), ("body_3", "body_4"), ("body_2", "body_1")}
    assert tree == expected
    assert set(frames) == {f"/quick_look/tf/{child}" for _, child in expected}

    rate_rad_s = np.radians(np.array(RATE_COUNTS) / 65.5)
    start_ns = frames["/quick_look/tf/body_3"][0][0]
    for time_ns, message in frames["/quick_look/tf/body_3"]:
        q = message.rotation
        truth = Rotation.from_rotvec(rate_rad_s * (time_ns - start_ns) / 1e9)
        # Exact to 1e-9: only numbers were converted.
        assert (Rotation.from_quat((q.x, q.y, q.z, q.w)) * truth.inv()).magnitude() < 1e-9
    _, opened = frames["/quick_look/tf/body_2"][-1]
    place, q = opened.translation, opened.rotation
    # The hinge's place and the quarter turn about it.
    assert (place.x, place.y, place.z) == pytest.approx((0.102, 0.0, 0.202))
    assert (q.x, q.y, q.z, q.w) == pytest.approx((0, np.sqrt(0.5), 0, np.sqrt(0.5)))
    assert topics["/quick_look/joint_3"][-1][1].angle_deg == pytest.approx(90.0)


@pytest.mark.parametrize("length", [1, 127, 128, 300])
def test_names_of_any_length_are_encoded(length: int) -> None:
    kind = foxglove_kind("FrameTransform", FRAME_TRANSFORM)
    encoder = RowEncoder.of(kind, {"parent_frame_id": "p" * length, "child_frame_id": "child"})
    (encoded,) = encoder.encode(np.array([1_500_000]), [np.array([number]) for number in range(7)])
    decoded = message_class(kind).FromString(encoded)
    assert (decoded.parent_frame_id, decoded.child_frame_id) == ("p" * length, "child")
    assert (decoded.timestamp.nanos, decoded.translation.y, decoded.rotation.w) == (500_000_000, 1.0, 6.0)


def test_quick_looks_are_marked_in_their_channels(tmp_path: Path) -> None:
    log = moving_log(tmp_path / "SD.bin")
    write_topics(log, tmp_path / "SD.mcap")
    with (tmp_path / "SD.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for channel in summary.channels.values():
        marked = channel.metadata.get("quality") == QUICK_LOOK
        # Quick looks are marked; what the sensors said is not.
        assert marked is channel.topic.startswith("/quick_look/")
    assert len(summary.channels) == 3 + 4 + 1 + 3 + 4


def test_schemas_are_whole_and_foxglove_s_own(tmp_path: Path) -> None:
    log = moving_log(tmp_path / "SD.bin")
    write_topics(log, tmp_path / "SD.mcap")
    with (tmp_path / "SD.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    schemas = {schema.name: schema for schema in summary.schemas.values()}
    # One schema per message: a viewer shows each once.
    assert len(schemas) == len(summary.schemas), "a schema is registered once"
    for name, schema in schemas.items():
        assert schema.encoding == "protobuf"
        pool = DescriptorPool()
        files = {file.name: file for file in FileDescriptorSet.FromString(schema.data).file}
        added: set[str] = set()
        for file_name in files:
            add_with_dependencies(pool, files, file_name, added)
        assert pool.FindMessageTypeByName(name).fields_by_name["timestamp"].number == 1
    # Foxglove's own schemas, unchanged.
    assert schemas["foxglove.FrameTransform"].data == messages.FrameTransform.get_schema().data
    assert schemas["foxglove.Log"].data == messages.Log.get_schema().data


def add_with_dependencies(
    pool: DescriptorPool, files: dict[str, FileDescriptorProto], name: str, added: set[str]
) -> None:
    """Add a file after its dependencies; raise if the set lacks one of them."""
    if name in added:
        return
    added.add(name)
    for dependency in files[name].dependency:
        add_with_dependencies(pool, files, dependency, added)
    pool.Add(files[name])


def test_metadata_says_what_the_recording_is(log: DropLog, tmp_path: Path) -> None:
    write_topics(log, tmp_path / "SD.mcap")
    with (tmp_path / "SD.mcap").open("rb") as file:
        records = {entry.name: entry.metadata for entry in make_reader(file).iter_metadata()}
    facts = records[METADATA_NAME]
    for name, value in record(METADATA, log).items():
        # Strings stand as they are, everything else as JSON.
        assert (facts[name] if isinstance(value, str) else json.loads(facts[name])) == value
    assert (facts["clock"], facts["unix_offset_us"]) == ("since power-up", "null")


def test_times_are_unix_time_if_the_logger_knew_it(tmp_path: Path) -> None:
    at_us = 1_790_000_000_000_000
    log = moving_log(tmp_path / "SD.bin", wall_clock_us=at_us)
    topics = write_topics(log, tmp_path / "SD.mcap")
    start_us = int(log.t_us[0])
    # Unix time, from the header's wall clock and the block's own time.
    assert [t for t, _ in topics["/body_1/imu"]] == [(at_us + t - start_us) * 1000 for t in log.t_us.tolist()]
    # A copy of the header was written later, and says the time of that moment.
    copied = replace(log, header_time_us=log.header_time_us + 1000)
    # The header was written a millisecond later than the samples say.
    assert write_topics(copied, tmp_path / "copy.mcap")["/body_1/imu"][0][0] == (at_us - 1000) * 1000


def test_the_same_log_gives_the_same_file(log: DropLog, tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_mcap(log, tmp_path / name, NO_FRAMES)
    # No clock and no random number in the file.
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_decode_writes_it_and_knows_its_own_again(tfsat_host: RunCli) -> None:
    moving_log(tfsat_host.folder / "SD.bin")
    assert tfsat_host.json("decode", "SD.bin", "--format", "mcap")["files"] == {"mcap": "SD.mcap"}
    tfsat_host("decode", "SD.bin", "--format", "mcap")
    with (tfsat_host.folder / "SD.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert "/quick_look/tf/body_3" in {channel.topic for channel in summary.channels.values()}
    (tfsat_host.folder / "SD.mcap").write_bytes(b"somebody's")
    refused = tfsat_host("decode", "SD.bin", "--format", "mcap", expect=1)
    # Somebody's own file is not overwritten.
    assert "not made by this command" in refused.stderr
