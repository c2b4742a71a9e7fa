"""`tfsat-host calibrate`: guided measurements before a drop."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tfsat_host.cli.options import add_device_options, file_name
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.limits import JOINT_COUNT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tfsat_host.calibration.file import Subject
    from tfsat_host.calibration.misalignment import AxisEstimate
    from tfsat_host.calibration.patterns import MotionPattern
    from tfsat_host.calibration.recording import Recording
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.protocol.messages import LiveSampleStream

STILL_S = 3.0
SWING_S = 10.0
LEAD_S = 3.0
"""With `--yes` nobody says that the robot is held and moves: so long after the task the measurement starts."""


class Operator(Protocol):
    """Who holds and moves the robot: a person at the prompt, or the emulated bench."""

    def rest(self) -> None:
        """Lets the robot lie still."""

    def swing(self, pattern: MotionPattern) -> None:
        """Starts to swing the pattern's bodies while the others are held."""


class PersonAtPrompt:
    """Tells a person what to do and waits for Enter; with `--yes` the measurement starts after `LEAD_S`."""

    def __init__(self, out: Output) -> None:
        self._out = out

    def rest(self) -> None:
        """Asks for stillness."""
        self._ask("Lay the robot on the bench and let it rest.", f"It is read for {STILL_S:g} s")

    def swing(self, pattern: MotionPattern) -> None:
        """Asks for swings."""
        held = " and ".join(f"body {body}" for body in pattern.held)
        moved = " with ".join(f"body {body}" for body in pattern.moved)
        self._ask(
            f"Hold {held} on the bench; swing {moved} about joint {pattern.joint}, about 60 deg and back, "
            "two seconds a swing.",
            f"Keep swinging for {SWING_S:g} s",
        )

    def _ask(self, task: str, then: str) -> None:
        self._out.note(task)
        if self._out.yes:
            self._out.note(f"{then}, starting {LEAD_S:g} s from now.")
        else:
            self._out.ask(f"{then} after Enter: ", meaning="Nothing was measured.", accept=("",))


def configure(parser: argparse.ArgumentParser) -> None:
    """One subcommand a quantity."""
    quantities = parser.add_subparsers(title="quantities", metavar="QUANTITY", dest="quantity", required=True)
    misalignment = quantities.add_parser(
        "misalignment",
        help="which way each gyro's axes point, from swings about a joint",
        description="Find the axis of a joint in the frame of each gyro that turns about it: "
        "the robot rests, then is swung by hand as the screen says.",
        formatter_class=type(parser._get_formatter()),
        allow_abbrev=False,
    )
    misalignment.add_argument(
        "--joint", type=int, required=True, choices=range(1, JOINT_COUNT + 1), help="joint to swing about"
    )
    misalignment.add_argument(
        "--out",
        metavar="FILE",
        type=file_name,
        help="write the axes here (default misalignment-joint-N.toml, or misalignment-joint-N-emulated.toml)",
    )
    misalignment.add_argument(
        "--force",
        action="store_true",
        help="overwrite a file of something else, another joint or another logger",
    )
    add_device_options(misalignment, "logger")


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures and writes; nothing is written when a step is refused."""
    from datetime import UTC, datetime

    from tfsat_host.calibration.file import Subject, format_axes
    from tfsat_host.cli.outputs import write_atomically

    with _bench(args, out) as bench:
        identity = bench.logger.identity
        subject = Subject(args.joint, identity.serial, emulated=args.emulated or identity.runs_natively)
        target = args.out or Path(subject.default_name())
        _check_target(target, subject, force=args.force)
        axes = _measure(args.joint, bench, out)
    text = format_axes(axes, subject, datetime.now(UTC))
    write_atomically(target, lambda path: path.write_text(text, encoding="utf-8"))
    result = {
        "joint": args.joint,
        "emulated": subject.emulated,
        "axes": [_as_json(axis) for axis in axes],
        "file": str(target),
    }
    out.result(result, lambda: _show(axes, subject, target, out))
    return 0


def _check_target(target: Path, subject: Subject, *, force: bool) -> None:
    """Refuses to put one calibration in place of another.

    Raises:
        TfsatError: the file is none of this command's, or of another joint, logger or world.
    """
    from tfsat_host.calibration.file import MARK, read_subject
    from tfsat_host.cli.outputs import check_may_write

    check_may_write(target, marker=MARK.encode(), force=force)
    if force or not target.exists():
        return
    there = read_subject(target)
    if there != subject:
        held = "does not say what it is of" if there is None else f"is of {there.describe()}"
        raise TfsatError(
            what=f"{target} holds another calibration: it {held}; this would be of {subject.describe()}.",
            meaning="Nothing was measured, nothing was overwritten.",
            next_step="Name another file with --out, or add --force to overwrite it.",
        )


@dataclass(frozen=True)
class Bench:
    """Where a calibration happens.

    Attributes:
        logger: Reads the sensors.
        operator: Moves the robot.
        lead_s: From the operator's task to the measurement.
    """

    logger: LoggerClient
    operator: Operator
    lead_s: float


@contextmanager
def _bench(args: argparse.Namespace, out: Output) -> Iterator[Bench]:
    """The logger and whoever moves the robot."""
    from tfsat_host.cli.advice import offering_emulated
    from tfsat_host.cli.connection import emulated_robot, open_logger
    from tfsat_host.devices.logger import LoggerClient

    if not args.emulated:
        with offering_emulated(), open_logger(args, out) as logger:
            yield Bench(logger, PersonAtPrompt(out), LEAD_S if out.yes else 0.0)
        return
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.emulated.robot import BoardIndex
    from tfsat_host.emulated.transport import EmulatedTransport

    with emulated_robot(out) as robot:
        transport = EmulatedTransport(robot, BoardIndex.LOGGER)
        yield Bench(LoggerClient.connect(transport), EmulatedOperator(robot), 0.0)


def _measure(joint: int, bench: Bench, out: Output) -> Sequence[AxisEstimate]:
    from tfsat_host.calibration.bias import estimate_biases
    from tfsat_host.calibration.misalignment import estimate_axes
    from tfsat_host.calibration.patterns import patterns_of_joint
    from tfsat_host.robot import load_robot

    model = load_robot()
    bench.operator.rest()
    biases = estimate_biases(record(bench, STILL_S, "reading the gyros at rest", out))
    axes: list[AxisEstimate] = []
    for pattern in patterns_of_joint(joint):
        bench.operator.swing(pattern)
        moved = " and ".join(map(str, pattern.moved))
        motion = record(bench, SWING_S, f"swinging body {moved} about joint {joint}", out)
        axes += estimate_axes(pattern, motion, biases, model)
    return axes


def record(bench: Bench, duration_s: float, what: str, out: Output) -> Recording:
    """Live samples of `duration_s` on the logger's own clock, after the bench's lead."""
    from tfsat_host.calibration.recording import Recording

    with bench.logger.live() as scales:
        if bench.lead_s > 0:
            _take(bench.logger, bench.lead_s, f"starting in {bench.lead_s:g} s", out)
        samples = _take(bench.logger, duration_s, what, out)
    recording = Recording.from_live(samples, scales)
    if recording.samples_lost:
        out.warn(
            f"{recording.samples_lost} of {len(samples) + recording.samples_lost} samples never arrived "
            f"({what})."
        )
    return recording


def _take(logger: LoggerClient, duration_s: float, what: str, out: Output) -> Sequence[LiveSampleStream]:
    samples: list[LiveSampleStream] = []
    with out.progress(what, total=duration_s) as advance:
        end_us = None
        while end_us is None or samples[-1].time_us < end_us:
            fresh = logger.live_samples()
            before_us = samples[-1].time_us if samples else fresh[0].time_us
            samples += fresh
            end_us = samples[0].time_us + round(duration_s * 1e6)
            advance((samples[-1].time_us - before_us) * 1e-6)
    return samples


def _as_json(axis: AxisEstimate) -> dict[str, object]:
    return {
        "body": axis.body,
        "axis_sensor": axis.axis,
        "nominal_sensor": axis.nominal,
        "angle_deg": axis.angle_deg,
        "std_deg": axis.std_deg,
        "cross_axis": axis.cross_axis(),
        "bias_deg_s": axis.bias_deg_s,
        "bias_std_deg_s": axis.bias_std_deg_s,
        "rms_rate_deg_s": axis.rms_rate_deg_s,
    }


def _show(axes: Sequence[AxisEstimate], subject: Subject, target: Path, out: Output) -> None:
    rows = [
        (
            f"body {axis.body}",
            " ".join(f"{value:+.4f}" for value in axis.axis),
            f"{axis.angle_deg:.3f} ± {axis.std_deg:.3f}",
            " ".join(f"{100 * value:+.2f}" for value in axis.cross_axis()),
            f"{axis.rms_rate_deg_s:.0f}",
        )
        for axis in axes
    ]
    out.table(
        ("gyro", "joint axis in sensor frame", "misaligned / deg", "cross-axis / %", "rms deg/s"),
        rows,
        title=f"Joint {axes[0].joint}",
    )
    if subject.emulated:
        out.line("These are the errors of an emulated robot: of no use for a real one.")
    out.line(f"Written to {target}.")
