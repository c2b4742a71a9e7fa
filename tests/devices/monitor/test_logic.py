"""What the live view works out: degrees, rates, gaps, and how often it may ask."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import pytest

from tfsat_host.devices.client import Client
from tfsat_host.devices.monitoring import LoggerWatch, SequencerWatch, StreamMeter, convert
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.record import Payload
from tfsat_host.robot import AngleSensor

SCALES = msg.LiveReply(1, 280, 131.0, 16384.0, 4096, 3, bytes([0x68] * 4), (0,) * 4, (0,) * 6)
SENSORS = [AngleSensor(joint, direction, math.pi) for joint in range(3) for direction in (1, -1)]


def sample(index: int = 0, time_us: int = 0, flags: int = 0x3FF, angle: int = 2048) -> msg.LiveSampleStream:
    imus = tuple(msg.ImuReading((0, 0, 0), 0, (131 * body, -262, 0)) for body in range(1, 5))
    return msg.LiveSampleStream(index, time_us, msg.Sample(0, flags, imus, (angle,) * 6))


def live(index: int, time_us: int) -> LiveSample:
    return LiveSample.from_payload(sample(index, time_us).encode())


def test_rates_are_degrees_per_second_and_angles_degrees() -> None:
    reading = convert(sample(angle=2048 + 1024), SCALES, SENSORS)
    assert [body.rate_deg_s for body in reading.bodies] == [(1, -2, 0), (2, -2, 0), (3, -2, 0), (4, -2, 0)]
    assert [sensor.joint for sensor in reading.angles] == [1, 1, 2, 2, 3, 3]
    assert {sensor.sensor_deg for sensor in reading.angles} == {270 + 180 / 4096}
    assert [round(sensor.joint_deg) for sensor in reading.angles] == [90, -90] * 3


def test_an_angle_beyond_half_a_turn_is_shown_as_the_nearer_one() -> None:
    zero = [AngleSensor(0, 1, math.radians(350))] * 6
    assert convert(sample(angle=0), SCALES, zero).angles[0].joint_deg == pytest.approx(10 + 180 / 4096)


def test_flags_say_what_is_valid() -> None:
    reading = convert(sample(flags=0b1000_00_101010_0101), SCALES, SENSORS)
    assert [body.valid for body in reading.bodies] == [True, False, True, False]
    assert [body.clipped for body in reading.bodies] == [False, False, False, True]
    assert [sensor.valid for sensor in reading.angles] == [False, True] * 3


def test_the_rate_is_that_of_the_last_second_on_the_loggers_clock() -> None:
    meter = StreamMeter()
    assert meter.rate_hz is None
    meter.add(live(i, 10_000 * i) for i in range(300))
    assert meter.rate_hz == pytest.approx(100)
    meter.add(live(300 + i, 3_000_000 + 5_000 * i) for i in range(300))
    assert meter.rate_hz == pytest.approx(200)
    assert (meter.missed, meter.gaps) == (0, 0)


def test_gaps_are_counted_and_a_restart_of_the_logger_is_none() -> None:
    meter = StreamMeter()
    meter.add(live(i, 1000 * i) for i in (0, 1, 5, 6, 8))
    assert (meter.missed, meter.gaps) == (4, 2)
    assert meter.rate_hz == pytest.approx(1000), "what was taken, not what arrived"
    meter.add(live(i, 1000 * i) for i in (0, 1, 2))
    assert (meter.missed, meter.gaps) == (4, 2)


@pytest.fixture
def robot() -> Iterator[EmulatedRobot]:
    with EmulatedRobot() as emulated_robot:
        emulated_robot.advance(SETTLE_US)
        yield emulated_robot


@pytest.fixture
def request_types(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Types of all requests."""
    types: list[int] = []
    request: Callable[..., object] = Client.request

    def spy(self: Client, message: Payload, reply_type: object) -> object:
        types.append(message.TYPE)
        return request(self, message, reply_type)

    monkeypatch.setattr(Client, "request", spy)
    return types


def watch_sequencer(robot: EmulatedRobot) -> tuple[SequencerWatch, Client]:
    client = Client(EmulatedTransport(robot, BoardIndex.SEQUENCER))
    return SequencerWatch(client, client.hello()), client


def pass_time(watch: SequencerWatch | LoggerWatch, client: Client, duration_s: float) -> None:
    start_s = client.transport.now_s()
    for tick in range(round(duration_s / 0.1)):
        watch.update(start_s + 0.1 * (tick + 1))


@pytest.mark.parametrize(("armed", "most_a_second"), [(False, 5), (True, 2)])
def test_the_sequencer_is_only_asked_and_rarely_while_armed_or_running(
    robot: EmulatedRobot, request_types: list[int], armed: bool, most_a_second: int
) -> None:
    watch, client = watch_sequencer(robot)
    if armed:
        from tfsat_host.devices.sequencer import SequencerClient

        board = SequencerClient(client, watch.identity)
        board.upload(schedule_maneuver(four_stroke(59, 69)))
        board.arm()
        pass_time(watch, client, 1.0)
        assert watch.status.state == SequencerState.ARMED
        robot.drop()
    request_types.clear()
    pass_time(watch, client, 2.2)
    assert set(request_types) == {msg.SequencerStatusRequest.TYPE}
    assert most_a_second < len(request_types) <= 2.2 * most_a_second + 1
    if armed:
        assert watch.status.state == SequencerState.RUNNING
        assert watch.status.strokes_started >= 3


def test_the_logger_is_asked_and_its_live_samples_taken_until_the_end(
    robot: EmulatedRobot, request_types: list[int]
) -> None:
    client = Client(EmulatedTransport(robot, BoardIndex.LOGGER))
    watch = LoggerWatch(client, client.hello(), SENSORS)
    pass_time(watch, client, 2.0)
    assert watch.meter.rate_hz == pytest.approx(280, rel=0.01)
    assert watch.meter.missed == 0
    watch.close()
    client.live_samples(0.0)
    assert client.live_samples(0.5) == []
    assert set(request_types) == {msg.HelloRequest.TYPE, msg.LoggerStatusRequest.TYPE, msg.LiveRequest.TYPE}
    assert msg.ArmRequest.TYPE not in request_types
