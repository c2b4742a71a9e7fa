"""The commands whose results must not change, in the order in which a scenario types them.

Every command runs with `--json`. A scenario has a folder of its own, in which `run/` and `drop.tfsat.zip` are a
rehearsed drop of firmware 0.2.0 (`today/drop.tfsat.zip.xz`): its recording, certificate, robot file and maneuver.
"""

from __future__ import annotations

SHORT_SEARCH = ("--particles", "8", "--iterations", "4")

SCENARIOS: dict[str, tuple[str, ...]] = {
    "boards": (
        "ports",
        "status --emulated",
        "upload-sequence 59 70 --emulated",
        "upload-sequence 40 30 --speed 150 --out own.toml --dry-run",
        "upload-sequence --file own.toml --emulated",
        "upload-sequence 59 --emulated",
        "upload-sequence 200 70 --emulated",
        "upload-servos --show --out servos.toml --emulated",
        "upload-servos servos.toml --dry-run --emulated",
        "upload-servos --factory --emulated --yes",
        "logger-settings show --emulated",
        "logger-settings set --rate 200 --emulated --yes",
        "logger-settings set --no-such 1 --emulated",
        "record start --emulated --yes",
        "log list --emulated",
        "arm --emulated --yes",
        "disarm --emulated",
        "jog --joint 1 --from 0 --to 5 --emulated --yes",
        "monitor --for 0.2 --emulated",
        "flash sequencer --hex missing.hex",
        "status --port /dev/does-not-exist",
        "completion bash",
        "no-such-command",
    ),
    "served": (
        "upload-sequence --file run/maneuver.toml --port robot/sequencer",
        "upload-sequence --file run/maneuver.toml --port robot/logger",
        "logger-settings set --clock --port robot/logger --yes",
        "preflight next --port robot/sequencer --logger-port robot/logger --yes",
        "preflight run --port robot/sequencer --logger-port robot/logger --yes",
        "record start --port robot/logger --yes",
        "status --port robot/logger",
        "arm --port robot/sequencer --yes",
        "arm --port robot/sequencer --yes --unrecorded",
        "status --port robot/sequencer",
        "upload-sequence 59 70 --port robot/sequencer",
        "disarm --port robot/sequencer",
        "record stop --port robot/logger --yes",
        "log list --port robot/logger",
        "log fetch 1 --out fetched.bin --port robot/logger",
        "log fetch 9 --out fetched.bin --port robot/logger",
        "log erase --port robot/logger --yes",
    ),
    "calibrate": (
        "calibrate show --out run/calibration-emulated.toml --robot run/robot.toml",
        "calibrate bias --emulated --yes --out own.toml",
        "calibrate zero --all --emulated --yes --out own.toml",
        "calibrate misalignment --joint 1 --emulated --yes --out own.toml",
        "calibrate show --out own.toml",
    ),
    "model": (
        "robot",
        "robot run/robot.toml",
        "robot cubesat_3u",
        "simulate 59 70 --out motion.csv",
        "simulate 59 70 --out motion.npz",
        "simulate --file run/maneuver.toml --robot run/robot.toml --initial-rate 1 -2 3",
        "simulate 90 90 --robot cubesat_3u --speed 1 --initial-rate 3 -3 3",
        "simulate 59",
        "envelope 59 70",
        "envelope 80 90",
        "envelope 80 80 --speed 100",
        "design --out designed.toml --time-limit 1.2 " + " ".join(SHORT_SEARCH),
        "design --joints 1,2 --grid 30",
        "sensitivity 59 70 --samples 60 --workers 1 --out samples.csv",
        "plan --target z:20 --robot cubesat_3u --grid 30 --tolerance 5 --out plan.json --history plan.csv",
        "robot run/maneuver.toml",
    ),
    "decode": (
        "decode run/SD.bin --format csv,npz,mat,parquet,mcap --out decoded --calibration run/calibration-emulated.toml",
        "decode run/SD.bin --out decoded --session 00000000",
        "decode run/maneuver.toml --out decoded",
        "decode missing.bin",
    ),
    "evaluate": (
        "evaluate run --out evaluation.json",
        "evaluate nowhere",
    ),
    "report": (
        "report run --out page.html --mcap drop.mcap --figures figures",
        "bundle run --out again.tfsat.zip",
        "reproduce drop.tfsat.zip",
        "campaign init season",
        "campaign add season run --note first",
        "campaign add season reproduce-missing",
        "campaign note season 1 calm",
        "campaign list season",
        "campaign next season",
        "campaign report season",
    ),
    "rehearse": (
        "rehearse 59 70 --out rehearsed --seed 3",
        "rehearse 59 70 --out jolted --fault crane-jolt",
        "rehearse 59 70 --out no-go --fault gyro-dead@powered",
        "rehearse --list-faults",
    ),
}

SERVED = frozenset({"served"})
"""Scenarios whose boards are those of `tfsat-host emulate` in `robot/`; they live in real time."""
MOMENTARY = frozenset({"served"})
"""Scenarios of which no number is compared."""
