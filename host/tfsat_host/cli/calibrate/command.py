"""`tfsat-host calibrate`: guided measurements before a drop, one quantity a command, all into one certificate."""

from __future__ import annotations

import argparse

from tfsat_host.cli.calibrate import flow
from tfsat_host.cli.calibrate.arguments import read_turn
from tfsat_host.cli.usage import JOINT, OUTPUT, add_actions, add_options, device
from tfsat_host.present.output import Output
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

_CAMPAIGN = f"""\
certificate:
--out FILE    the certificate that the steps go into (default {CERTIFICATE}; of an emulated robot
              {EMULATED_CERTIFICATE}); recordings are kept in a folder of its name
--robot FILE  robot file (default: the drop tower robot)
--force       begin the certificate again where it is of other sensors
--resume      leave out steps of this command that were accepted within the last hour and since the last landing
{device("logger")}"""
_SEQUENCER_PORT = """\
--sequencer-port PORT  serial port of the sequencer, which moves the joint; without it the environment's
                           TFSAT_SEQUENCER_PORT, else the one port that looks like this board"""
_QUANTITIES = f"""
bias          biases of the gyros, at rest
    Read all gyros while the robot lies still.

    --log FILE  take it from the quiet minutes of a recording before its release; needs no board
zero          zero points of the angle sensors, joints closed
    Read the angle sensors while the holding attachment keeps a joint, or all of them, closed.

    ! --joint  which joint
    ! --all    all joints at once, an attachment on each
    --anew     do not compare it with the last zero: after a sensor that had slipped was fastened
misalignment  misalignment of the gyros' axes, from swings about a joint
    Find how each gyro that a joint turns is mounted on its body: the robot is swung by hand as the screen says.

    --anew     sensors were moved or fastened: what was measured before counts as before a landing
    * --joint  which joint
scale         scale factors of the gyros, and nonlinearity of the angle sensors
    Compare the gyros with the angle sensors while a joint is moved from rest to rest, or with a turn of the whole robot
    through a known angle.

    ! --joint          which joint
    ! --turn AXIS DEG  turn the whole robot by hand about a body axis, x y or z, by a known angle, such as z 360: for
                       the axis about which no joint turns
    --jog              with --joint: the sequencer's servo moves the joint, not a hand
    {_SEQUENCER_PORT}
servo         servo map: the angle that a joint reaches, by commanded angle; speed, acceleration and delay
    Have the sequencer move a joint through its range, both ways, and measure where it stops. With --log: measure how
    fast and how late each servo moves, from the strokes of a recorded run.

    ! --joint        which joint
    ! --log FILE     take speed, acceleration and delay of all joints that moved from a recording, of a drop or of a run
                     on the bench; needs no board, moves nothing
    --maneuver FILE  with --log: what was flown (default: maneuver.toml next to the recording)
    --no-upload      measure only: the sequencer keeps its servo settings
    {_SEQUENCER_PORT}
replaced      boards, sensors or servos of the robot were replaced: what rests on them ends, all else holds
    End what a certificate says of parts that were replaced, or put on. All other values stay, with their dates; drops
    from before and after are of one robot.

    PART...       logger, sequencer, imu-1 to imu-4, angle-1 to angle-3 (a joint's angle sensors), servo-1 to servo-3
    certificate:
    --out FILE    the certificate that the steps went into (default as theirs)
    --robot FILE  robot file (default: the drop tower robot)
show          all calibrated quantities, their age, and what a drop still needs
    Show what a certificate holds, and what the next drop cannot rely on.

    --full        every value and recording, not one screen
    certificate:
    --out FILE    the certificate that the steps went into (default as theirs)
    --robot FILE  robot file (default: the drop tower robot)
    --emulated    that of the emulated robot
"""
"""What each quantity is, what its command does, and what it takes."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add one subcommand for each quantity."""
    parser.description = (
        "Measure what the robot's sensors and servos do, step by step as the screen says. Each accepted step is kept "
        "at once in a certificate, with its raw recording: steps can be repeated, and a calibration goes on where it "
        "ended. docs/calibration.md explains it."
    )
    added = add_actions(parser, _QUANTITIES, title="quantities", dest="quantity", joint=JOINT)
    for name, quantity in added.items():
        add_options(quantity, {"show": OUTPUT, "replaced": device("logger")}.get(name, _CAMPAIGN))


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures and writes; what was accepted before an end is kept."""
    if getattr(args, "log", None) is not None:
        return flow.take_from_log(args, out)
    if args.quantity == "servo":
        from tfsat_host.cli.calibrate import servo

        return servo.run(args, out)
    if args.quantity == "show":
        from tfsat_host.cli.calibrate import show

        return show.run(args, out)

    if args.quantity == "replaced":
        from tfsat_host.cli.calibrate import replaced

        return replaced.run(args, out)
    return flow.measure(args, read_turn(args), out)
