"""`tfsat-host calibrate servo`: which angle each pulse leads to, and settings that make the board's angles true."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import degrees
from typing import Any

from tfsat_host.calibration.errors import NotKeptError
from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, settings_from_map
from tfsat_host.calibration.servos.stroke_error import gain_of, left_by, offset_of, places_of
from tfsat_host.calibration.servos.visits import at_stops, require_zero, servo_points
from tfsat_host.calibration.session import RESUME_WITHIN, recent
from tfsat_host.calibration.steps.step import servo as servo_step
from tfsat_host.cli.calibrate.bench import Bench, open_bench
from tfsat_host.cli.calibrate.flow import open_campaign
from tfsat_host.cli.calibrate.jog import measure_servo
from tfsat_host.cli.calibrate.options import as_typed_here, resuming
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.present.stored_settings import comparison, servo_words, settings_as_dict
from tfsat_host.present.terminal import show_rows
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Column, Columns, fields, plus_minus, record
from tfsat_host.robot import load_robot
from tfsat_host.servo_settings import ServoSettings, find_misfit

_MAP = fields("backlash_deg backlash_std_deg repeatability_deg nonlinearity_deg places")
_PLACES: Columns = (
    Column("commanded_deg", "commanded", form=".1f"),
    Column("pulse_us", "pulse", form="g"),
    Column("opening_deg", "reached opening", form=".2f"),
    Column("closing_deg", "reached closing", form=".2f"),
)


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures, keeps the evidence, shows the map, and puts the settings that follow from it on the board."""
    model = load_robot(args.robot)
    with _typed_as_here(args, out), open_bench(args, model, out, jog=True) as bench:
        campaign = open_campaign(args, bench.origin, model, out)
        before = bench.jog.settings().settings
        evidence = recent(campaign, servo_step(args.joint), RESUME_WITHIN) if args.resume else None
        if evidence is None:
            sensors = campaign.solution().joints[args.joint - 1]
            require_zero(sensors)
            evidence = measure_servo(args.joint, before, sensors, bench, model, out)
            campaign.accept(evidence)
        calibration = campaign.calibration
        if calibration is None:
            raise ValueError("nothing was accepted")
        servo_map = next(one for one in calibration.servo_maps if one.joint == args.joint)
        points = servo_points(evidence, calibration.joints, model)
        stopped = at_stops(points, args.joint, model)
        _show_map(servo_map, points, stopped, out)
        out.line(f"Written to {campaign.certificate}.")
        after = settings_from_map(servo_map, before)
        result = {
            "joint": args.joint,
            "points": _points_as_dicts(points, stopped, servo_map.setting),
            "map": _map_as_dict(servo_map),
            **_upload(servo_map, before, after, bench, args, out),
            "file": campaign.certificate,
        }
    out.result(result)
    return 0


def _upload(
    servo_map: ServoMap,
    before: ServoSettings,
    after: ServoSettings,
    bench: Bench,
    args: argparse.Namespace,
    out: Output,
) -> dict[str, Any]:
    """Puts the new settings on the board unless `--no-upload`; says what error is left."""
    joint = servo_map.joint
    out.table(*comparison(after, before), title="Servo settings")
    left = left_by(servo_map, after.of(joint))
    words = (
        f"joint {joint} misses commanded angles by at most {left['mean_deg']:.2f} deg on average of both directions, "
        f"stops {left['side_deg']:.2f} deg short by its backlash, and scatters by {left['scatter_deg']:.2f} deg."
    )
    result = {
        "settings": {"before": settings_as_dict(before), "after": settings_as_dict(after)},
        "left": left,
        "uploaded": False,
        "verified": False,
    }
    if args.no_upload:
        out.line(f"The sequencer keeps its settings. With the new ones {words}")
        return result
    if after != before:
        try:
            out.confirm(
                "Store the new settings on the sequencer?",
                meaning="The measurement is kept; the sequencer keeps its servo settings. "
                f"By the calibration, joint {joint} needs {servo_words(after.of(joint))}.",
            )
        except NotConfirmed as error:
            error.next_step = f"To go on from the measurement: {resuming(args)}"
            raise
    done = bench.jog.write_settings(after)
    misfit = find_misfit(bench.jog.read_back().moves, after)
    if misfit is not None:
        at = "" if args.sequencer_port is None else f" --port {args.sequencer_port}"
        out.warn(
            f"The maneuver on the board does not fit these settings: {misfit}. ARM will refuse it. "
            f"Upload one that fits: tfsat-host upload-sequence A B{' --emulated' if args.emulated else at}"
        )
    already = "" if done.written else " (they were there already)"
    out.line(f"Settings stored on the sequencer, read back and identical{already}: now {words}")
    return {**result, "uploaded": done.written, "verified": True, "maneuver_fits": misfit is None}


@contextmanager
def _typed_as_here(args: argparse.Namespace, out: Output) -> Iterator[None]:
    """Gives the commands that an error names this command's certificate and devices."""
    try:
        yield
    except KeyboardInterrupt:
        if not out.json_mode:
            out.note("")  # behind the prompt, and the terminal's ^C
        raise
    except NotConfirmed:  # what it names is complete
        raise
    except NotKeptError as error:
        error.next_step = f"Make room, or see that it may be written; then: {resuming(args)}"
        raise
    except TfsatError as error:
        error.next_step = as_typed_here(error.next_step, args)
        raise


def _points_as_dicts(
    points: Sequence[ServoPoint], stopped: Sequence[bool], setting: ServoSetting
) -> list[dict[str, Any]]:
    """Each visit, in order of time; `stopped` are those that the map leaves out."""
    commanded = {row["pulse_us"]: row["commanded_deg"] for row in places_of(points, setting)}
    return [
        {
            "commanded_deg": round(commanded[point.pulse_us], 3),
            "pulse_us": point.pulse_us,
            "direction": "opening" if point.direction > 0 else "closing",
            "reached_deg": degrees(point.reached_rad),
            "std_deg": degrees(point.std_rad),
            "at_stop": met,
        }
        for point, met in zip(points, stopped, strict=True)
    ]


def _map_as_dict(servo_map: ServoMap) -> dict[str, Any]:
    """The map in figures that people compare."""
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    return {
        **record(_MAP, servo_map),
        "gain": gain.value,
        "gain_std": gain.std,
        "offset_deg": offset.value,
        "offset_std_deg": offset.std,
    }


def _show_map(
    servo_map: ServoMap, points: Sequence[ServoPoint], stopped: Sequence[bool], out: Output
) -> None:
    """The places, and the figures below them."""
    show_rows(_PLACES, places_of(points, servo_map.setting), out, title=f"Servo of joint {servo_map.joint}")
    if any(stopped):
        out.line(
            "Within half a degree of the ends of its range the joint may lie against its stop: those visits do not"
        )
        out.line("count for what follows.")
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    out.line(f"gain            {gain.text()}")
    out.line(f"offset          {offset.text()} deg at 0 deg")
    backlash_deg, std_deg = degrees(servo_map.backlash_rad), degrees(servo_map.backlash_std_rad)
    out.line(f"backlash        {plus_minus(backlash_deg, std_deg)} deg")
    for name, of, what in (
        ("repeatability", servo_map.repeatability_rad, "an arrival"),
        ("nonlinearity", servo_map.nonlinearity_rad, "the places"),
    ):
        out.line(f"{name:<16}{degrees(of):.2f} deg, standard deviation of {what}")
