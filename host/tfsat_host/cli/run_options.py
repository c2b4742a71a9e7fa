"""Options of a drop that is to be evaluated, for every command that evaluates one."""

from __future__ import annotations

import argparse
from dataclasses import fields

from tfsat_host.run.files import EvaluationOptions

RUNS = """\
RUN...        a recording off the card, or a folder with SD.bin (or with one other recording) as `rehearse` leaves it;
              several: one each drop of the same robot, compared
--session ID  which recording of the file, 8 hex digits (default: as decode chooses)
--swarm       find the centers of mass by the paper's particle swarm as well, for comparison
what else is known of the drop:
--maneuver FILE     what was flown (default: maneuver.toml next to the recording)
--calibration FILE  certificate of the sensors (default: calibration.toml next to the recording or here, of an emulated
                    robot calibration-emulated.toml); that of the drop is found among its recordings
--robot FILE        a robot file, or the name of a robot that tfsat brings along (default: robot.toml next to the
                    recording, else drop_tower)
--video FILE        events of the drop in a video (CSV: event,t_s)
--laser FILE        places of the two laser spots over time (CSV: t_s,spot,along_mm,up_mm)
--facility FILE     a facility file, for the release velocity (default: COSMOTORRE's)
--video-rate X      seconds of the video's times in a real one: 1 in real time, 4 in slow motion of a quarter (default:
                    as two of its events or more tell)"""
"""RUN, and the files that belong to it; see `usage`."""


def options_of(args: argparse.Namespace) -> EvaluationOptions:
    """Return the evaluation options, without RUN, from the arguments of a parser with `RUNS`."""
    return EvaluationOptions(**{field.name: getattr(args, field.name) for field in fields(EvaluationOptions)})
