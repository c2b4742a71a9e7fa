"""Where the numbers come from."""

from __future__ import annotations

import numpy as np

from tfsat_host import __version__
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.tables import release_time, utc
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN, Column, Table
from tfsat_host.report.contents.reported import Reported


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
    columns = (Column("what", "what"), Column("is", "is"))
    return Table("Provenance", columns, [{"what": what, "is": text} for what, text in rows])


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
    return strokes or UNKNOWN
