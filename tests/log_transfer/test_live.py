"""Live sampling at full rate."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from tests.log_transfer.bench import Bench
from tfsat_host.devices.monitoring import StreamMeter
from tfsat_host.protocol.messages import LiveSampleStream


def test_a_thousand_samples_a_second_arrive_without_a_gap(bench: Bench) -> None:
    settings = bench.logger.settings().settings
    bench.logger.write_settings(replace(settings, rate_hz=1000))
    samples: list[LiveSampleStream] = []
    meter = StreamMeter()
    with bench.logger.live() as scales:
        assert scales.rate_hz == 1000
        while len(samples) < 5000:
            arrived = bench.logger.live_samples()
            meter.add(arrived)
            samples += arrived
    first = samples[0].index
    assert [sample.index - first for sample in samples] == list(range(len(samples)))
    assert {after.time_us - before.time_us for before, after in pairwise(samples)} == {1000}
    assert (meter.rate_hz, meter.missed) == (1000.0, 0)
    assert bench.logger.status().late_ticks == 0


def test_it_goes_on_beside_a_recording(bench: Bench) -> None:
    settings = bench.logger.settings().settings
    bench.logger.write_settings(replace(settings, rate_hz=1000))
    bench.logger.start_recording()
    meter = StreamMeter()
    with bench.logger.live():
        for _ in range(200):
            meter.add(bench.logger.live_samples())
    stopped = bench.logger.stop_recording()
    assert meter.missed == 0
    assert stopped.samples_dropped == 0
