"""The files that a decoded recording becomes, next to each other under one name; and the calibration for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.next_step import NextStep
from tfsat_host.output_files import OutputFile, was_made_with, write_all

if TYPE_CHECKING:
    from tfsat_host.present.output import Output
    from tfsat_host.run.certificate_check import CertificateState
    from tfsat_host.sdlog import DropLog

FORMATS = ("csv", "npz", "mat", "parquet", "mcap")


@dataclass(frozen=True)
class Written:
    """What was done.

    Attributes:
        files: Path of each file written, by its name in the JSON result.
        of_other_recordings: Files of the same name in other formats that hold another recording.
    """

    files: dict[str, Path]
    of_other_recordings: tuple[Path, ...]


def write_decoded(log: DropLog, stem: Path, formats: Sequence[str], *, force: bool) -> Written:
    """Writes `stem`.csv and so on, and finds what was decoded under this name from another recording.

    Two recordings under one name in two formats would be taken for one. Nothing is deleted: the other one may be all
    that is left of its drop.

    Raises:
        TfsatError: a file exists that is not ours, or a format's library is missing; nothing was written.
    """
    from tfsat_host.sdlog.log_errors import check_extra

    # All libraries first, so that a missing one leaves no half of the files.
    for name in formats:
        check_extra(name)
    outputs = _outputs(log, stem, formats)
    write_all(list(outputs.values()), force=force)
    # Only of what exists: an export's libraries take longer to load than a recording to decode.
    others = _outputs(log, stem, [name for name in FORMATS if name not in formats and _stands(stem, name)])
    foreign = tuple(file.path for file in others.values() if _holds_other_recording(file, log))
    return Written({name: file.path for name, file in outputs.items()}, foreign)


def _stands(stem: Path, name: str) -> bool:
    return _name_export(stem, f".{name}").exists() or _name_export(stem, f".events.{name}").exists()


def _holds_other_recording(file: OutputFile, log: DropLog) -> bool:
    from tfsat_host.sdlog.exported_session import is_of_recording

    # A file without our marker is a person's and says nothing of a recording.
    if not file.path.is_file() or not was_made_with(file.path, file.marker):
        return False
    # None means that the file does not tell: only a definite other session is reported.
    return is_of_recording(file.path, log) is False


def _name_export(stem: Path, ending: str) -> Path:
    return stem.with_name(stem.name + ending)


def _outputs(log: DropLog, stem: Path, formats: Sequence[str]) -> dict[str, OutputFile]:
    """Return the files that can be written, by their names in the JSON result.

    A format's libraries are imported only if that format is requested.
    """
    files = {}

    def add(key: str, ending: str, marker: bytes, write: Callable[[DropLog, Path], object]) -> None:
        files[key] = OutputFile(_name_export(stem, ending), marker, partial(write, log))

    if "csv" in formats:
        from tfsat_host.sdlog import export_tables as tables

        add("csv", ".csv", tables.header_line(log), tables.write_csv)
        add("events_csv", ".events.csv", tables.EVENTS_HEADER_LINE, tables.write_events_csv)
    if "npz" in formats:
        from tfsat_host.sdlog.export_arrays import NPZ_MARKER, write_npz

        add("npz", ".npz", NPZ_MARKER, write_npz)
    if "mat" in formats:
        from tfsat_host.sdlog.export_arrays import MAT_MARKER, write_mat

        add("mat", ".mat", MAT_MARKER, write_mat)
    if "parquet" in formats:
        from tfsat_host.sdlog.export_tables import PARQUET_MARKER, write_events_parquet, write_parquet

        add("parquet", ".parquet", PARQUET_MARKER, write_parquet)
        add("events_parquet", ".events.parquet", PARQUET_MARKER, write_events_parquet)
    if "mcap" in formats:
        from tfsat_host.sdlog.export_mcap import MCAP_MARKER

        add("mcap", ".mcap", MCAP_MARKER, _write_mcap)
    return files


def _write_mcap(log: DropLog, path: Path) -> None:
    """Write an MCAP file that includes the bodies' transforms, by the robot file of the run."""
    from tfsat_host.evaluation.body_frames import body_frames
    from tfsat_host.robot.absent_parts import load_robot_of_boards
    from tfsat_host.run.files import robot_beside
    from tfsat_host.sdlog.export_mcap import write_mcap

    write_mcap(log, path, body_frames(log, load_robot_of_boards(robot_beside(log.path))))


def held_calibration(
    log: DropLog, named: Path | None, out: Output
) -> tuple[CertificateState | None, float | None]:
    """Report the calibration that would apply, the objections to it, and the gyros' rest time, as notes.

    The landing of the recording is written into a certificate of the same sensors. Neither the exit code nor
    the recording's own warnings depend on the calibration.

    Returns:
        The calibration's state, and for how long the gyros rested before the release, in s; None where there is none.
    """
    from tfsat_host.run.certificate_check import hold_against, origin_of_log, report_certificate
    from tfsat_host.run.files import find_certificate

    file = find_certificate(named, log.path.parent, Path(), emulated=origin_of_log(log.header).emulated)
    state = None
    if file is not None:
        state = report_certificate(lambda: hold_against(log, file, out).state, file, out, "recording")
    return state, _quiet_s(log, file, out)


def _quiet_s(log: DropLog, file: Path | None, out: Output) -> float | None:
    """Compute how long the gyros rested before the release, in s, and note their bias."""
    import numpy as np

    from tfsat_host.calibration.bias import quiet_before_release
    from tfsat_host.calibration.steps.sensor_samples import SensorSamples
    from tfsat_host.run.certificate_check import origin_of_log
    from tfsat_host.run.files import command_options
    from tfsat_host.run.recorded_landing import time_of_day

    quiet = quiet_before_release(log)
    if quiet is None:
        return None
    quiet_s = float(quiet.t_us[-1] - quiet.t_us[0]) * 1e-6
    # At rest the mean reading is the zero-rate output, (4, 3) in sensor axes.
    biases = np.rad2deg(SensorSamples.from_counts(quiet).rate_rad_s.mean(axis=0))
    words = [
        f"body {body} {' '.join(f'{component:+.3f}' for component in bias)}"
        for body, bias in enumerate(biases, 1)
    ]
    until = "" if log.release_us is None else " before the release"
    rested = f"The gyros rested for {quiet_s:.0f} s{until}: bias {', '.join(words)} deg/s. "
    # A step without a date cannot be ordered among landings and other steps.
    if time_of_day(log, log.origin_us) is None:
        out.note(f"{rested}Without a time of day no calibration takes it.")
        return quiet_s
    emulated = origin_of_log(log.header).emulated
    options = () if file is None else command_options(file, emulated=emulated)
    command = NextStep("calibrate bias", ("--log", str(log.path), *options))
    out.note(f"{rested}To calibrate with it: {command}")
    return quiet_s
