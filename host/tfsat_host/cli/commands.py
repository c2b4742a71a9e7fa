"""All commands by name, and the overview that `tfsat-host --help` prints: argparse would take as long as Python."""

from __future__ import annotations

GROUPS = {
    "the maneuver": {
        "robot": "check a robot file and show what it says",
        "design": "find the maneuver that turns the robot farthest in its time",
        "simulate": "where a maneuver leaves the robot, and what happens then",
        "envelope": "check a maneuver against the drop tower",
        "sensitivity": "uncertainty of a maneuver's rotation, by parameter",
        "plan": "chain loops of the joints to a target attitude on orbit",
    },
    "the boards": {
        "ports": "list serial ports and which board each looks like",
        "status": "state of both boards, and what blocks a drop",
        "monitor": "live states, switches, rates and angles in the terminal",
        "upload-sequence": "put a maneuver on the sequencer, checked whole",
        "upload-servos": "servo settings (pulses per angle, limits) to the sequencer",
        "logger-settings": "show or change the logger's rate, ranges and times",
        "flash": "put firmware on a board, and check that it runs",
        "jog": "move one joint slowly, for calibration, then let it go",
    },
    "the sensors": {
        "calibrate": "measure biases, zero points, misalignments, scales, servos",
    },
    "the drop": {
        "preflight": "GO or NO-GO before a drop, with evidence for every check",
        "record": "start or stop the recording of a drop on the logger's card",
        "arm": "let the next release start the maneuver",
        "disarm": "back to safe: nothing moves, faults are cleared",
        "log": "list, fetch or erase the logger's recordings by cable",
    },
    "the result": {
        "decode": "turn a card's recording into engineering units",
        "evaluate": "predicted and measured motion of a drop, each with its ±",
        "report": "an evaluated drop as one offline page with plots, replay",
        "campaign": "a folder of numbered drops: notes, comparison, one report",
        "bundle": "all of one drop in one archive, to keep and recompute",
        "reproduce": "recompute a bundle from raw data, list differences",
    },
    "the desk": {
        "rehearse": "fly a maneuver with the real firmware, robot emulated",
        "emulate": "serve both boards of the emulated robot for other commands",
        "completion": "print a shell completion script",
    },
}
"""What each command does, in the groups of the README."""
HELPS = {name: text for commands in GROUPS.values() for name, text in commands.items()}
EXAMPLES = {
    "robot": "robot drop_tower",
    "design": "design --out maneuver.toml",
    "simulate": "simulate 59 70",
    "envelope": "envelope 59 70",
    "sensitivity": "sensitivity 59 70",
    "plan": "plan --target z:90",
    "ports": "ports",
    "status": "status",
    "monitor": "monitor --emulated --for 5",
    "upload-sequence": "upload-sequence 59 70",
    "upload-servos": "upload-servos --show",
    "logger-settings": "logger-settings set --rate 280",
    "flash": "flash sequencer --dry-run",
    "jog": "jog --joint 1 --from 0 --to 20",
    "calibrate": "calibrate misalignment --joint 1",
    "preflight": "preflight run1",
    "record": "record start",
    "arm": "arm --joints 0 0 0",
    "disarm": "disarm",
    "log": "log fetch all",
    "decode": "decode SD.bin --out run1",
    "evaluate": "evaluate run1",
    "report": "report run1",
    "campaign": "campaign add season run1",
    "bundle": "bundle run1 --out drop1.tfsat.zip",
    "reproduce": "reproduce drop1.tfsat.zip",
    "rehearse": "rehearse 59 70 --fault gyro-dead",
    "emulate": "emulate --dir robot",
    "completion": "completion bash",
}
"""One line to type for each command; its `--help` ends with it."""
_OVERVIEW = """\
usage: tfsat-host [-h] [--version] COMMAND ...

Ground tools of a transformable CubeSat robot: from a typed maneuver to a
decoded card.

options:
  -h, --help            show this help message and exit
  --version             show program's version number and exit
  --debug               with any command: log frames, files and decisions to
                        stderr (or TFSAT_DEBUG=1)

{commands}
Help of a command: tfsat-host COMMAND --help

Exit codes: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful,
4 refused by an interlock, 130 interrupted.
"""


def overview() -> str:
    """Return the list of all commands, one line each, in their groups."""
    lines = []
    for group, commands in GROUPS.items():
        lines += [f"{group}:", *(f"  {name:<18}{text}" for name, text in commands.items()), ""]
    return _OVERVIEW.format(commands="\n".join(lines))
