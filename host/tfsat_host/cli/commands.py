"""All commands by name, and the overview that `tfsat-host --help` prints: argparse would take as long as Python."""

from __future__ import annotations

_COMMANDS = {
    "the maneuver": {
        "robot drop_tower": "check a robot file and show what it says",
        "design --out maneuver.toml": "find the maneuver that turns the robot farthest in its time",
        "simulate 59 70": "where a maneuver leaves the robot, and what happens then",
        "envelope 59 70": "check a maneuver against the drop tower",
        "sensitivity 59 70": "uncertainty of a maneuver's rotation, by parameter",
        "plan --target z:90": "chain loops of the joints to a target attitude on orbit",
    },
    "the boards": {
        "ports": "list serial ports and which board each looks like",
        "status": "state of both boards, and what blocks a drop",
        "monitor --emulated --for 5": "live states, switches, rates and angles in the terminal",
        "upload-sequence 59 70": "put a maneuver on the sequencer, checked whole",
        "upload-servos --show": "servo settings (pulses per angle, limits) to the sequencer",
        "logger-settings set --rate 280": "show or change the logger's rate, ranges and times",
        "flash sequencer --dry-run": "put firmware on a board, and check that it runs",
        "jog --joint 1 --from 0 --to 20": "move one joint slowly, for calibration, then let it go",
    },
    "the sensors": {
        "acceptance --emulated": "find what is wired wrongly, by name and pin, on the first day",
        "calibrate misalignment --joint 1": "measure biases, zero points, misalignments, scales, servos",
    },
    "the drop": {
        "preflight run1": "GO or NO-GO before a drop, with evidence for every check",
        "record start": "start or stop the recording of a drop on the logger's card",
        "arm --joints 0 0 0": "let the next release start the maneuver",
        "disarm": "back to safe: nothing moves, faults are cleared",
        "log fetch all": "list, fetch or erase the logger's recordings by cable",
    },
    "the result": {
        "decode SD.bin --out run1": "turn a card's recording into engineering units",
        "evaluate run1": "predicted and measured motion of a drop, each with its ±",
        "report run1": "an evaluated drop as one offline page with plots, replay",
        "campaign add season run1": "a folder of numbered drops: notes, comparison, one report",
        "bundle run1 --out drop1.tfsat.zip": "all of one drop in one archive, to keep and recompute",
        "reproduce drop1.tfsat.zip": "recompute a bundle from raw data, list differences",
    },
    "the desk": {
        "rehearse 59 70 --fault gyro-dead": "fly a maneuver with the real firmware, robot emulated",
        "emulate --dir robot": "serve both boards of the emulated robot for other commands",
        "completion bash": "print a shell completion script",
    },
}
"""One line to type for each command and what the command does, in the groups of the README."""
GROUPS = {group: {line.split()[0]: text for line, text in rows.items()} for group, rows in _COMMANDS.items()}
HELPS = {name: text for commands in GROUPS.values() for name, text in commands.items()}
EXAMPLES = {line.split()[0]: line for rows in _COMMANDS.values() for line in rows}
"""A command's `--help` ends with it."""
_OVERVIEW = """\
usage: tfsat-host [-h] [--version] COMMAND ...

Ground tools of a transformable CubeSat robot, from maneuver to evaluation.

options:
  -h, --help            show this help message and exit
  --version             show program's version number and exit
  --debug               with any command: debug log to stderr (or TFSAT_DEBUG=1)

{commands}
Help of a command: tfsat-host COMMAND --help

Exit codes:
  0 done
  1 failed
  2 usage
  3 done but data lost or doubtful
  4 refused by an interlock
  130 interrupted
"""


def overview() -> str:
    """Return the list of all commands, one line each, in their groups."""
    lines = []
    for group, commands in GROUPS.items():
        lines += [f"{group}:", *(f"  {name:<18}{text}" for name, text in commands.items()), ""]
    return _OVERVIEW.format(commands="\n".join(lines))
