"""Where the numbers come from, and how the clocks ran."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from tfsat_host import __version__
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.report.contents.reported import Reported
from tfsat_host.report.contents.tables.cells import NOTHING, number, utc, with_std
from tfsat_host.report.document import Table
from tfsat_host.sdlog import DropLog


def release_time(log: DropLog) -> datetime | None:
    """None if the logger did not know the time of day, or recorded no release."""
    if log.release_us is None or log.unix_offset_us is None:
        return None
    return datetime.fromtimestamp((log.release_us + log.unix_offset_us) * 1e-6, UTC)


def provenance_table(drop: Reported) -> Table:
    """Files, versions, sensors, time of day."""
    found = drop.evaluation
    log, header = found.log, found.log.header
    rate = f"{log.rate_hz:.2f} Hz" if np.isfinite(log.rate_hz) else "unknown"
    rows = [
        ["recording", str(log.path)],
        ["session", f"{log.session:08x}"],
        ["SHA-256 of the recording", drop.recording_sha256],
        ["released", utc(release_time(log))],
        ["samples", f"{len(log)}, {log.samples_lost} lost; {rate} ({header.rate_hz:g} Hz commanded)"],
        ["logger", _logger(found)],
        [
            "gyros",
            f"± {header.gyro_range_deg_s} deg/s, low-pass setting {header.dlpf_cfg}, WHO_AM_I {header.who_am_i.hex()}",
        ],
        ["robot", f"{found.model.name} ({found.model.path})"],
        ["calibration", "none" if drop.certificate is None else f"{drop.certificate}, {_taken(found)}"],
        ["maneuver", _maneuver(found)],
        *([source.what, f"{source.path}, SHA-256 {source.sha256}"] for source in drop.sources),
        ["options", " ".join(drop.options) or "none"],
        ["tfsat-host", f"{__version__}, protocol {PROTOCOL_HASH.hex()}"],
    ]
    return Table(title="Provenance", columns=["what", "is"], rows=rows, caption="")


def clock_table(found: Evaluation) -> Table | None:
    """None without clocks besides the logger's."""
    fits = [] if found.clocks is None else [found.clocks.sequencer, found.clocks.video]
    rows = [
        [
            fit.name,
            with_std(1e3 * fit.offset_s, 1e3 * fit.offset_std_s, signed=True),
            with_std(fit.rate_ppm, fit.rate_ppm_std, signed=True),
            f"{sum(one.used for one in fit.residuals)} of {len(fit.residuals)}",
            number(
                max((1e3 * abs(one.residual_s) for one in fit.residuals if one.used), default=float("nan")), 3
            ),
        ]
        for fit in fits
        if fit is not None
    ]
    if not rows:
        return None
    return Table(
        title="Clocks",
        columns=["clock", "offset (ms)", "fast by (ppm)", "events used", "greatest residual (ms)"],
        rows=rows,
        caption="Against the logger's clock, by which all times are given.",
    )


def _logger(found: Evaluation) -> str:
    header = found.log.header
    firmware = ".".join(map(str, header.firmware_version))
    kind = "emulated" if header.image_crc == 0 else f"image {header.image_crc:08x}"
    serial = header.board_serial.hex() if any(header.board_serial) else "unknown"
    return f"serial {serial}, firmware {firmware} ({kind}), protocol {header.protocol_hash.hex()}"


def _taken(found: Evaluation) -> str:
    """When its quantities were measured: when the file was written says only who touched it last."""
    taken = sorted(one.taken for one in quantities(found.calibration) if one.taken is not None)
    if not taken:
        return "nothing in it was ever measured"
    first, last = utc(taken[0]), utc(taken[-1])
    return f"measured {first}" if first == last else f"measured from {first} to {last}"


def _maneuver(found: Evaluation) -> str:
    if found.schedule is None:
        return "not known"
    strokes = ", ".join(
        f"joint {one.joint} {one.angle_deg:+g} deg at {one.t_s:g} s" for one in found.schedule.strokes
    )
    return strokes or NOTHING
