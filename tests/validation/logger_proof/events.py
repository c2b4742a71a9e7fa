"""Every event that a recording must hold, told by what happened and not by the logger; and that it holds no other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tests.validation.campaign import Broken
from tests.validation.logger_proof.truth import Kind, Truth
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import FROZEN_US, LANDING_LATEST_US, RELEASE_DEBOUNCE_US
from tfsat_host.sdlog import DropEvent, DropLog
from tfsat_host.sdlog.release_rule import releases_by_rule


@dataclass(frozen=True, slots=True)
class Due:
    """One event, as what really happened tells it.

    Attributes:
        earliest_us, latest_us: Between them lies its time.
        known_us: The logger knows of it by then.
        arg: None: any.
        value: Least and greatest; None: any.
        may_lack: It is none when it stands there, and may be absent.
    """

    name: str
    earliest_us: int
    latest_us: int
    known_us: int
    index: int
    arg: int | None
    value: tuple[int, int] | None = (0, 0)
    may_lack: bool = False

    def matches(self, event: DropEvent) -> bool:
        """It is this one."""
        return (
            (event.name, event.index) == (self.name, self.index)
            and self.earliest_us <= event.t_us <= self.latest_us
            and self.arg in (None, event.arg)
            and (self.value is None or self.value[0] <= event.value <= self.value[1])
        )


BLOCK_US = 30_000
"""An event may stand in a block whose samples are up to so much older."""
BACKLOG_US = 50_000
"""Two events find room at an instant, the rest waits."""
END_US = 10_000
"""At the end of a recording that is closed, nothing waits."""
NOTICED_US = 10_000
"""A pass of the main loop, with a sync."""
LOSS_NOTICED_US = 2_200_000
"""A card that looks busy is gone after 1 s; it may have stalled before, and a host cannot tell."""
STALL_US = 550_000
"""What the card says is stamped when the main loop asked, and it may wait in a stall."""
TICKS_US = 20_000
"""Some sampling instants, should a few be missed."""
ROUNDING_US = 1
"""The release rule counts half microseconds."""
SHOCK_MG = (15_999, 16_000)
"""The end of the range, either way."""
TAKEN = frozenset({"switch_edge", "stroke", "release", "landing", "sampling_late", "card_lost", "card_back"})


def check_events(log: DropLog, truth: Truth) -> None:
    """Raises Broken: an event is missing whose block must be there, or one is there that never was."""
    remaining_events = list(log.events)
    # A pulled card has no stall event: the loss is the event.
    names = TAKEN if truth.head["pulled"] else TAKEN | {"card_stall"}
    # In order of time, and each log event matches once: two equal ones need two causes.
    for due in sorted(_due(truth), key=lambda due: due.earliest_us):
        matching_event = next((event for event in remaining_events if due.matches(event)), None)
        if matching_event is not None:
            remaining_events.remove(matching_event)
        elif not due.may_lack and _must_hold(log, truth, due.earliest_us, due.known_us):
            raise Broken(f"no {due.name} is in the log for {due.earliest_us / 1e6:.6f} s: {_like(log, due)}")
    # Whatever is left in the log has no cause in what happened.
    for event in remaining_events:
        if event.name in names:
            raise Broken(f"a {event.name} that was none: {event}")
    _check_sensors(log, truth)


def _like(log: DropLog, due: Due) -> list[DropEvent]:
    return [event for event in log.events if event.name == due.name]


def _must_hold(log: DropLog, truth: Truth, earliest_us: int, known_us: int) -> bool:
    """Return whether what the logger knew at `known_us` must have reached a block that was read."""
    # What the logger learnt after the last sample need not be in the file.
    if not _in_recording(truth, known_us):
        return False
    end_us = int(log.t_us[-1])
    for gap in log.gaps:
        gap_us = (gap.start_us or 0, gap.end_us if gap.end_us is not None else truth.end_us)
        # A gap without lost blocks: the logger was busy, and the event was written when it went on.
        if gap.blocks == 0 and gap_us[0] - BLOCK_US < known_us < gap_us[1]:
            known_us = gap_us[1]  # it waited for room
        # A gap with lost blocks may have taken the event with it.
        if gap.blocks and gap_us[0] < known_us + BACKLOG_US + BLOCK_US and earliest_us - BLOCK_US < gap_us[1]:
            return False
    # A closed recording drains what waits; one cut short may lose the last blocks.
    is_whole = log.footer is not None and not any(gap.end_us is None for gap in log.gaps)
    return known_us + (END_US if is_whole else BACKLOG_US + BLOCK_US) <= end_us


def _in_recording(truth: Truth, known_us: int) -> bool:
    """Return whether `known_us` lies within the recording.

    A recording that continues in the next file before a release loses nothing between the files.
    """
    continued = truth.kind is Kind.NEXT_FILE and truth.number > 1
    begin_us = truth.begin_us + 1 if continued else int(truth.samples["t_us"][0])
    return begin_us <= known_us <= truth.last_sample_us


def _due(truth: Truth) -> Iterator[Due]:
    yield from _edges(truth)
    yield from _drop_events(truth)
    yield from _late_ticks(truth)
    for trouble in truth.troubles:
        yield from _losses(trouble) if trouble["pulled"] else _stalls(trouble, truth)


def _edges(truth: Truth) -> Iterator[Due]:
    strokes = 0
    for t_us, source, index, is_open, lost, _ in truth.edges.tolist():
        known_us = _tick(truth, t_us)
        # Strokes count in their own recording alone; switch edges of the whole run may stand in any.
        if truth.begin_us < known_us <= truth.last_sample_us or not source:
            name = "stroke" if source else "switch_edge"
            number, arg = (strokes, 0) if source else (index, is_open)
            yield Due(name, t_us, t_us, known_us, number, arg, (lost, lost))
            strokes += source


def _tick(truth: Truth, t_us: int) -> int:
    """Time of the first tick not before; the end of the run if there is none."""
    row = int(np.searchsorted(truth.ticks["t_us"], t_us))
    return int(truth.ticks["t_us"][row]) if row < len(truth.ticks) else truth.end_us


def _late_ticks(truth: Truth) -> Iterator[Due]:
    times = truth.ticks["t_us"].astype(np.int64)
    steps = np.diff(times)
    # One and a half intervals, in microseconds times Hz.
    for row in np.flatnonzero(steps * truth.rate_hz > 1_500_000).tolist():
        t_us = int(times[row + 1])
        yield Due("sampling_late", t_us, t_us, t_us, 0, 0, (int(steps[row]), int(steps[row])))


def _stalls(trouble: np.void, truth: Truth) -> Iterator[Due]:
    from_us, to_us = int(trouble["from_us"]), int(trouble["to_us"])
    took_ms = (to_us - from_us) // 1000
    pulls = truth.troubles[truth.troubles["pulled"] != 0]
    # A card out of its contacts looks busy: near a loss a stall may be taken for part of it.
    beside = (pulls["from_us"] < to_us + LOSS_NOTICED_US) & (pulls["to_us"] + LOSS_NOTICED_US > from_us)
    of_file_before = to_us < int(truth.samples["t_us"][0])  # its footer tells
    value = (took_ms - 1, took_ms + 2 * NOTICED_US // 1000)
    known_us = to_us + NOTICED_US
    yield Due(
        "card_stall",
        from_us - NOTICED_US,
        from_us,
        known_us,
        0,
        0,
        value,
        bool(beside.any()) or of_file_before,
    )


def _losses(trouble: np.void) -> Iterator[Due]:
    from_us, to_us = int(trouble["from_us"]), int(trouble["to_us"])
    # A card that answers nothing looks busy for a second first.
    noticed_us = from_us + LOSS_NOTICED_US
    yield Due("card_lost", from_us - STALL_US, noticed_us, noticed_us, 0, None, None)
    # Back only after the loss itself was noticed.
    back_us = max(to_us, noticed_us) + LOSS_NOTICED_US
    yield Due("card_back", to_us - STALL_US, back_us, back_us, 0, 0, None)


def _check_sensors(log: DropLog, truth: Truth) -> None:
    """Check that no sound IMU is called faulty and no frozen reading is called valid.

    Readings are frozen when they have stood still for 0.1 s.
    """
    for event in log.events:
        sensor = event.name in ("sensor_fault", "sensor_recovered")
        if sensor and not int(truth.head["faulty"]) >> event.index & 1:
            raise Broken(f"a sound IMU is called faulty: {event}")
    # Row of the log for each true sample, -1 where it is not in the log.
    rows = np.full(len(truth.samples), -1)
    rows[log.sample_index] = np.arange(len(log))
    for imu in range(log.imu_valid.shape[1]):
        for still in standstills(truth, imu):
            known_us = int(truth.samples["t_us"][still.stop - 1])
            if not _must_hold(log, truth, known_us, known_us):
                continue
            still_rows = rows[still][rows[still] >= 0]
            # The first reading may be genuine; those that repeat it are not.
            if log.imu_valid[still_rows[1:], imu].any():
                raise Broken(f"what a frozen IMU repeated is called valid, sample {still.start}")
            # Only an IMU that was valid just before can be called frozen since then.
            before = rows[still.start - 1] if still.start else -1
            if before >= 0 and log.imu_valid[before, imu]:
                _check_frozen(log, imu, int(truth.samples["t_us"][still.start]), known_us)


def _check_frozen(log: DropLog, imu: int, from_us: int, known_us: int) -> None:
    """Check that the fault event tells since when an IMU that had run has been repeating itself."""
    fault_events = [event for event in log.events if (event.name, event.index) == ("sensor_fault", imu)]
    frozen = [
        event.value
        for event in fault_events
        if event.t_us == known_us and event.arg == ErrorCode.SENSOR_FROZEN
    ]
    if frozen != [known_us - from_us]:
        raise Broken(f"a frozen IMU has stood still for {known_us - from_us} us, the log has {frozen}")


def standstills(truth: Truth, imu: int) -> Iterator[slice]:
    """Samples in which the IMU was read at each tick and gave one reading for FROZEN_US and more."""
    samples = truth.samples
    # All seven words repeat: noise changes at least one of them in a chip that runs.
    same = (samples["imu"][1:, imu] == samples["imu"][:-1, imu]).all(axis=1)
    served = (samples["served"] >> imu) & 1 != 0
    same &= served[1:] & served[:-1]
    # Starts and ends of the runs of equal samples.
    bounds = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(np.int8), [0]))))
    for begin, end in bounds.reshape(-1, 2).tolist():
        if int(samples["t_us"][end]) - int(samples["t_us"][begin]) >= FROZEN_US:
            yield slice(begin, end + 1)


def _drop_events(truth: Truth) -> Iterator[Due]:
    """Releases, those that were none, and the landing, of the whole run."""
    switches = truth.edges[truth.edges["source"] == 0]
    edges = [(edge["t_us"].item(), edge["index"].item(), bool(edge["open"])) for edge in switches]
    # By the release rule itself, from the switches' true edges.
    for release in releases_by_rule(edges, 0, truth.end_us):
        times = (release.at_us - ROUNDING_US, release.at_us + ROUNDING_US)
        yield Due("release", *times, release.at_us + RELEASE_DEBOUNCE_US + TICKS_US, 0, 1)
        if release.at_us == truth.release_us:
            yield _landing_due(truth)
        elif release.false_us is not None:
            yield Due("release", *times, release.false_us + TICKS_US, 0, 0)


def _landing_due(truth: Truth) -> Due:
    """Return the landing event that is due: by the shock, or without a shock by the time.

    Where every IMU fails at some time, either is accepted.
    """
    shock_us, time_us = int(truth.head["landing_us"]), truth.release_us + LANDING_LATEST_US
    # 0xF: every IMU fails at some time, so that none need feel the shock.
    if int(truth.head["faulty"]) == 0xF:
        return Due("landing", shock_us, time_us + TICKS_US, time_us + TICKS_US, 0, None, None)
    # No shock: the logger ends the fall by its time limit, arg 0.
    if not truth.head["landing_felt"]:
        return Due("landing", time_us, time_us + TICKS_US, time_us + TICKS_US, 0, 0)
    # The shock is felt at the first sampling instant after it.
    row = min(int(np.searchsorted(truth.ticks["t_us"], shock_us)), len(truth.ticks) - 1)
    tick_us = int(truth.ticks["t_us"][row])
    return Due("landing", tick_us, tick_us, tick_us, 0, 1, SHOCK_MG)
