"""All commands by name, and the overview that `tfsat-host --help` prints: argparse would take as long as Python."""

from __future__ import annotations

HELPS = {
    "upload-sequence": "put a maneuver on the sequencer, checked whole",
    "upload-servos": "how its servos turn pulses into angles, to the sequencer",
    "design": "the maneuver that turns the robot farthest in its time",
    "simulate": "where a maneuver leaves the robot, and what happens then",
    "sensitivity": "how sure a maneuver's rotation is, and what it depends on",
    "plan": "chain loops of the joints to a target attitude",
    "envelope": "check a maneuver against the drop tower",
    "rehearse": "fly a maneuver with the real firmware, robot emulated",
    "calibrate": "measure biases, zero points, misalignments, scales, servos",
    "decode": "turn a card's recording into engineering units",
    "evaluate": "what the robot did, whether the model knew, and ± of both",
    "report": "an evaluated drop as one offline page with plots, replay",
    "bundle": "all of one drop in one archive, to keep and recompute",
    "reproduce": "recompute a bundle from raw, and say what differs",
    "campaign": "a folder of numbered drops: notes, comparison, one report",
    "record": "start or stop the recording of a drop on the logger's card",
    "log": "list, fetch or erase the logger's recordings by cable",
    "logger-settings": "show or change the logger's rate, ranges and times",
    "status": "what both boards are doing, and what stands against a drop",
    "preflight": "GO or NO-GO before a drop, with evidence for every check",
    "arm": "let the next release start the maneuver",
    "disarm": "back to safe: nothing moves, faults are cleared",
    "jog": "move one joint slowly, for calibration, then let it go",
    "monitor": "live states, switches, rates and angles in the terminal",
    "flash": "put firmware on the sequencer, and check that it runs",
    "robot": "check a robot file and show what it says",
    "ports": "list serial ports and which board each looks like",
    "emulate": "serve both boards of the emulated robot for other commands",
    "completion": "print what lets a shell complete commands",
}
"""What each command does."""
_OVERVIEW = """\
usage: tfsat-host [-h] [--version] COMMAND ...

Ground tools of a transformable CubeSat robot: from a typed maneuver to a
decoded card.

options:
  -h, --help            show this help message and exit
  --version             show program's version number and exit

commands:
  COMMAND
{commands}

Exit codes: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful,
4 refused by an interlock, 130 interrupted.
"""


def overview() -> str:
    """Return the list of all commands, one line each."""
    commands = "\n".join(f"    {name:<18}{text}" for name, text in HELPS.items())
    return _OVERVIEW.format(commands=commands)
