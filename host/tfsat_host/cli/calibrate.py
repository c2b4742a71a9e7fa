"""`tfsat-host calibrate`: guided measurements before a drop."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from tfsat_host.cli.options import add_device_options
from tfsat_host.cli.output import Output
from tfsat_host.protocol.limits import JOINT_COUNT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tfsat_host.calibration.misalignment import AxisEstimate
    from tfsat_host.calibration.patterns import MotionPattern
    from tfsat_host.calibration.recording import Recording
    from tfsat_host.devices.logger import LoggerClient

STILL_S = 3.0
SWING_S = 10.0


class Operator(Protocol):
    """Who holds and moves the robot: a person at the prompt, or the emulated bench."""

    def rest(self) -> None:
        """Lets the robot lie still."""

    def swing(self, pattern: MotionPattern) -> None:
        """Starts to swing the pattern's bodies while the others are held."""


class PersonAtPrompt:
    """Tells a person what to do and waits for Enter; with `--yes` it does not wait."""

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
        if not self._out.yes:
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
        "--out", metavar="FILE", type=Path, help="write the axes here (default misalignment-joint-N.toml)"
    )
    misalignment.add_argument("--force", action="store_true", help="overwrite a file that is something else")
    add_device_options(misalignment, "logger")


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures and writes; nothing is written when a step is refused."""
    from datetime import UTC, datetime

    from tfsat_host.calibration.file import MARK, format_axes
    from tfsat_host.cli.outputs import check_may_write, write_atomically

    target = args.out or Path(f"misalignment-joint-{args.joint}.toml")
    check_may_write(target, marker=MARK.encode(), force=args.force)
    with _bench(args, out) as (logger, operator):
        axes = _measure(args.joint, logger, operator, out)
        text = format_axes(axes, logger.identity.serial, datetime.now(UTC))
    write_atomically(target, lambda path: path.write_text(text, encoding="utf-8"))
    result = {"joint": args.joint, "axes": [_as_json(axis) for axis in axes], "file": str(target)}
    out.result(result, lambda: _show(axes, target, out))
    return 0


@contextmanager
def _bench(args: argparse.Namespace, out: Output) -> Iterator[tuple[LoggerClient, Operator]]:
    """The logger and whoever moves the robot."""
    from tfsat_host.cli.connection import emulated_robot, open_logger
    from tfsat_host.devices.logger import LoggerClient

    if not args.emulated:
        with open_logger(args, out) as logger:
            yield logger, PersonAtPrompt(out)
        return
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.emulated.robot import BoardIndex
    from tfsat_host.emulated.transport import EmulatedTransport

    with emulated_robot(out) as robot:
        transport = EmulatedTransport(robot, BoardIndex.LOGGER)
        yield LoggerClient.connect(transport), EmulatedOperator(robot)


def _measure(joint: int, logger: LoggerClient, operator: Operator, out: Output) -> Sequence[AxisEstimate]:
    from tfsat_host.calibration.misalignment import estimate_axes, gyro_bias
    from tfsat_host.calibration.patterns import patterns_of_joint
    from tfsat_host.robot import load_robot

    model = load_robot()
    operator.rest()
    bias = gyro_bias(_record(logger, STILL_S, "reading the gyros at rest", out))
    axes: list[AxisEstimate] = []
    for pattern in patterns_of_joint(joint):
        operator.swing(pattern)
        moved = " and ".join(map(str, pattern.moved))
        motion = _record(logger, SWING_S, f"swinging body {moved} about joint {joint}", out)
        axes += estimate_axes(pattern, motion, bias, model)
    return axes


def _record(logger: LoggerClient, duration_s: float, what: str, out: Output) -> Recording:
    """Live samples of `duration_s` on the logger's own clock."""
    from tfsat_host.calibration.recording import Recording

    samples: list[Any] = []
    with logger.live() as scales, out.progress(what, total=duration_s) as advance:
        end_us = None
        while end_us is None or samples[-1].time_us < end_us:
            fresh = logger.live_samples()
            before_us = samples[-1].time_us if samples else fresh[0].time_us
            samples += fresh
            end_us = samples[0].time_us + round(duration_s * 1e6)
            advance((samples[-1].time_us - before_us) * 1e-6)
    return Recording.from_live(samples, scales)


def _as_json(axis: AxisEstimate) -> dict[str, object]:
    return {
        "body": axis.body,
        "axis_sensor": axis.axis,
        "nominal_sensor": axis.nominal,
        "angle_deg": axis.angle_deg,
        "std_deg": axis.std_deg,
        "cross_axis": axis.cross_axis(),
        "bias_deg_s": axis.bias_deg_s,
        "rms_rate_deg_s": axis.rms_rate_deg_s,
    }


def _show(axes: Sequence[AxisEstimate], target: Path, out: Output) -> None:
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
    out.line(f"Written to {target}.")
