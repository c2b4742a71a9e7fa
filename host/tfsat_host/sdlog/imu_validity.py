"""Readings of an IMU that are no measurements: it had stopped before the logger noticed, or was another part."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, IntArray
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import FROZEN_US

from .events import DropEvent, Exchange

# Faults whose event value tells since when the readings before it are in doubt.
_REACHING_BACK = (
    ErrorCode.SENSOR_MISSING,
    ErrorCode.BUS_STUCK,
    ErrorCode.SENSOR_FROZEN,
    ErrorCode.SENSOR_RESET,
)
FROZEN_READINGS = 5
"""Fewer equal readings prove nothing, however slow the sampling (`FreezeWatch::kFrozenReadings`)."""
_ROWS_AT_A_TIME = 1 << 15
_PROBE_EVERY = 2
"""Of any FROZEN_READINGS rows that follow each other, two that are so far apart are looked at."""
# Four of the seven counts as one 64-bit word, to be compared at once; the rest only where it repeats.
_READING = np.dtype([("probe", "<u8"), ("rest", "<i2", (3,))])
# Accelerometer and gyro, without the temperature at index 3.
_AXES = np.array([0, 1, 2, 4, 5, 6])
_ENDS_OF_RANGE = (-(1 << 15), (1 << 15) - 1)


def invalidate_by_events(events: Iterable[DropEvent], t_us: IntArray, imu_valid: BoolArray) -> None:
    """Clear the validity, in place, of the samples during which an output stood still, or may have had other scales.

    The logger marks an IMU invalid only from the sample on at which it is certain; the event gives for how many µs
    before it the output had not changed by one bit, or since when a part that wakes up measuring had not shown its
    settings. An IMU that sleeps after a reset, and one that failed before it ran, has a value of 0.

    Events and times (n,) are of the recording, by time; `imu_valid` (n, 4) is changed.
    """
    spans = [
        (event.index, event.t_us - event.value, event.t_us)
        for event in events
        if event.name == "sensor_fault" and event.arg in _REACHING_BACK and event.value > 0
    ]
    if not spans:
        return
    # Times of a damaged log may go back: search them in sorted order and map the spans back to rows.
    order = np.argsort(t_us, kind="stable")
    for imu in range(imu_valid.shape[1]):
        own = sorted((start_us, end_us) for index, start_us, end_us in spans if index == imu)
        if not own:
            continue
        bounds = np.searchsorted(t_us, np.array(own), sorter=order)
        # Sorted spans may overlap: go on where the one before ended, so that no row is visited twice.
        marked_end = 0
        for first, last in bounds.tolist():
            imu_valid[order[max(first, marked_end) : last], imu] = False
            marked_end = max(marked_end, last)


def invalidate_exchanged(exchanges: Iterable[Exchange], t_us: IntArray, imu_valid: BoolArray) -> None:
    """Clear the validity (n, 4), in place, of what another part than the header's measured, at sample times (n,)."""
    for exchange in exchanges:
        # From the fault, not the recovery, on: the exchange happened at some time between the two.
        other = t_us >= exchange.from_us
        if exchange.until_us is not None:
            other &= t_us < exchange.until_us
        imu_valid[other, exchange.index] = False


def invalidate_repeated(
    imu: NDArray[np.int16], index: IntArray, t_us: IntArray, imu_valid: BoolArray
) -> None:
    """Clear the validity, in place, of readings that an IMU repeated, whether or not there is an event.

    The event may be in a lost block, or the power may have gone before the logger was certain. So it is
    the logger's rule (`FreezeWatch`): FROZEN_READINGS equal readings or more over FROZEN_US, unless all
    six axes stand at the ends of their ranges. A standstill that ends where the IMU is invalid, samples
    are lost or the recording ends may have gone on: there FROZEN_READINGS are enough. As with the event,
    the first of the equal readings is invalid too.

    `imu` (n, 4, 7) has raw counts; `imu_valid` (n, 4) is changed.
    """
    # Runs that reach the end of their chunk stay open and are joined with the next chunk's.
    open_runs = [np.empty((0, 2), np.int64)] * imu.shape[1]
    for begin in range(0, len(imu), _ROWS_AT_A_TIME):
        end = begin + _ROWS_AT_A_TIME
        rows, which = _still(imu, imu_valid, begin, end)
        for body, before in enumerate(open_runs):
            own = rows[which == body]
            if not len(own) and not len(before):
                continue
            # A hit spans rows i to i + 2; hits that touch belong to one standstill.
            runs = _join_runs(np.concatenate((before, np.stack((own, own + _PROBE_EVERY), axis=1))))
            goes_on = runs[:, 1] == end
            open_runs[body] = runs[goes_on]
            _judge(runs[~goes_on], imu[:, body], index, t_us, imu_valid[:, body])
    # What was still open at the recording's end is judged last.
    for body, runs in enumerate(open_runs):
        _judge(runs, imu[:, body], index, t_us, imu_valid[:, body])


def _still(imu: NDArray[np.int16], imu_valid: BoolArray, begin: int, end: int) -> tuple[IntArray, IntArray]:
    """Find every second row whose reading the next two repeat, and the IMU of each: (k,), (k,)."""
    # Compare every second row by one word first: nearly all rows are settled by that.
    probes = imu[begin : end + 1 : _PROBE_EVERY].view(_READING)["probe"][:, :, 0]
    # Flat indices over (probes, IMUs): unravel them to a row and its IMU.
    repeat_indices = np.flatnonzero(probes[1:] == probes[:-1])
    rows, which = np.divmod(repeat_indices, imu.shape[1])
    rows = rows * _PROBE_EVERY + begin
    # Confirm each hit in full: all three rows valid, and equal in all seven counts.
    for step in range(_PROBE_EVERY + 1):
        same = imu_valid[rows + step, which]
        if step:
            same &= (imu[rows + step, which] == imu[rows, which]).all(axis=1)
        rows, which = rows[same], which[same]
    return rows, which


def _join_runs(runs: IntArray) -> IntArray:
    """(k, 2) first and last rows, those joined of which one begins with the last row of the one before."""
    starts = np.flatnonzero(np.concatenate(([True], runs[1:, 0] != runs[:-1, 1])))
    ends = np.append(starts[1:], len(runs)) - 1
    return np.stack((runs[starts, 0], runs[ends, 1]), axis=1)


def _judge(runs: IntArray, imu: NDArray[np.int16], index: IntArray, t_us: IntArray, valid: BoolArray) -> None:
    """Clear one IMU's validity in the runs of equal readings that are no measurements."""
    if not len(runs):
        return
    first, last = runs.T
    final = len(imu) - 1
    # Probing by twos can miss a row at either end: extend the run where the neighbour is equal too.
    row, following = np.maximum(first - 1, 0), np.minimum(last + 1, final)
    first = np.where(valid[row] & (imu[row] == imu[first]).all(axis=1), row, first)
    last = np.where(valid[following] & (imu[following] == imu[last]).all(axis=1), following, last)
    following = np.minimum(last + 1, final)
    # A run that ends at an invalid reading, a gap or the end may have lasted longer than is seen.
    may_go_on = (last == final) | ~valid[following] | (index[following] != index[last] + 1)
    stands = may_go_on | (t_us[last] - t_us[first] >= FROZEN_US)
    # With all six axes at the ends of their ranges there is no noise to be seen: that is no standstill.
    saturated = np.isin(imu[first][:, _AXES], _ENDS_OF_RANGE).all(axis=1)
    frozen = stands & ~saturated & (last - first + 1 >= FROZEN_READINGS)
    for begin, end in zip(first[frozen].tolist(), last[frozen].tolist(), strict=True):
        valid[begin : end + 1] = False
