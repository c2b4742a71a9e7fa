"""Builds fuzz targets with libFuzzer and the sanitizers, runs them, and reads what they report."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.fixtures.cpp.compiling import compile_objects, run
from tests.paths import REPOSITORY
from tests.validation.fuzz.seeds import SCRIPTS, streams, write_dictionary, write_seeds

CORPUS = REPOSITORY / "tests" / "validation" / "fuzz" / "corpus"
SANITIZERS = ("-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=all")
# Words to compare with come from the dictionary; watching every comparison would halve the speed.
FLAGS = ("-std=c++17", "-O1", "-g1", *SANITIZERS, "-fno-sanitize-coverage=trace-cmp")
# No leaks: the boards allocate nothing, and the leak detector does not work inside a debugger or a container.
SANITIZER_OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0:malloc_context_size=4:quarantine_size_mb=16",
    "UBSAN_OPTIONS": "print_stacktrace=1",
}
# A hang is a finding: an input takes a few milliseconds.
HANG_S = 60
PULSE = re.compile(r"^#\d+\s+\w+\s+cov: (\d+) ft: (\d+) corp: (\d+)/", re.MULTILINE)
DEFECT = re.compile(r"broken: .*|runtime error: .*|ERROR: AddressSanitizer: \S+|ERROR: libFuzzer: timeout")


@dataclass(frozen=True)
class Target:
    """A fuzz target: its sources as patterns from the repository's root, and what its inputs look like."""

    name: str
    sources: tuple[str, ...]
    seeds: dict[str, bytes]
    max_input_bytes: int

    @property
    def corpus(self) -> Path:
        return CORPUS / self.name


FRAME = Target("frame", ("tests/validation/fuzz/fuzz_frame.cpp",), streams(), max_input_bytes=400)
BOARD = Target(
    "board",
    (
        "tests/validation/fuzz/fuzz_board.cpp",
        "firmware/arduino_sequencer/src/core/*.cpp",
        "tools/emulator/src/boards/native_ports.cpp",
    ),
    SCRIPTS,
    max_input_bytes=400,
)
TARGETS = (FRAME, BOARD)


@dataclass(frozen=True)
class Outcome:
    """What a run of a target came to. `findings` are inputs that broke something, `defect` says what."""

    executions: int
    executions_per_s: int
    coverage: int
    features: int
    corpus_size: int
    findings: list[Path]
    defect: str
    log: str


def build(target: Target, folder: Path, tree: Path = REPOSITORY) -> Path:
    """Compiles a target's sources and links `folder`/fuzz. A warning is an error."""
    clang = shutil.which("clang++")
    assert clang is not None, "no clang++: run tools/install-toolchain.sh"
    sources = sorted(path for pattern in target.sources for path in tree.glob(pattern))
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "fuzz"
    run([clang, *FLAGS, *compile_objects(sources, (), FLAGS, clang, tree), "-o", program])
    return program


def fuzz(
    program: Path,
    target: Target,
    runs: int,
    *,
    seed: int = 1,
    progress: Callable[[str], None] = lambda _: None,
) -> Outcome:
    """Executes `runs` inputs, the committed corpus and the seeds first; stops at the first finding.

    New inputs go to corpus/ next to the program, findings to findings/. The same program, corpus and seed do the same.
    """
    folder = program.parent
    corpus, seeds, findings = folder / "corpus", folder / "seeds", folder / "findings"
    # libFuzzer wants both folders to exist.
    for path in (corpus, findings):
        path.mkdir(exist_ok=True)
    write_seeds(seeds, target.seeds)
    write_dictionary(folder / "dictionary")
    options = [
        *(f"-runs={runs}", f"-seed={seed}", f"-max_len={target.max_input_bytes}", f"-timeout={HANG_S}"),
        *("-detect_leaks=0", "-print_final_stats=1"),
        *(f"-dict={folder / 'dictionary'}", f"-artifact_prefix={findings}/"),
    ]
    # Findings of earlier runs stay in the folder and are not counted again.
    before = set(findings.iterdir())
    lines: list[str] = []
    command = list(map(str, [program, *options, corpus, target.corpus, seeds]))
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, encoding="utf-8", errors="replace", env=_environment()
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            lines.append(line)
            # Pulses are libFuzzer's progress; all other lines only go to the log.
            if "\tpulse " in line:
                progress(line.strip())
    log = "".join(lines)
    (folder / "log.txt").write_text(log)
    return _outcome(log, sorted(set(findings.iterdir()) - before))


def minimise(program: Path, target: Target, into: Path) -> None:
    """Copy a minimal set of inputs to `into` that reaches, with the seeds, every edge of the code.

    The set is chosen from all inputs at hand.
    """
    folder = program.parent
    reached = folder / "minimised"
    shutil.rmtree(reached, ignore_errors=True)
    write_seeds(reached, target.seeds)
    sources = [path for path in (target.corpus, folder / "corpus") if path.is_dir()]
    # Counters off: an input is kept for an edge that it reaches, not for how often.
    options = ["-merge=1", "-use_counters=0", f"-max_len={target.max_input_bytes}", "-detect_leaks=0"]
    run([program, *options, reached, *sources])
    into.mkdir(parents=True, exist_ok=True)
    for path in sorted(reached.iterdir()):
        # Seeds are written by the build and need no copy in the corpus.
        if path.name not in target.seeds:
            shutil.copyfile(path, into / path.name)


def _outcome(log: str, findings: list[Path]) -> Outcome:
    statistics = dict(re.findall(r"^stat::(\w+):\s+(\d+)$", log, re.MULTILINE))
    pulses = PULSE.findall(log)
    # An input among the first may break something before there is anything to report.
    assert statistics and (pulses or findings), log
    coverage, features, corpus_size = pulses[-1] if pulses else (0, 0, 0)
    defect = DEFECT.search(log)
    return Outcome(
        executions=int(statistics["number_of_executed_units"]),
        executions_per_s=int(statistics["average_exec_per_sec"]),
        coverage=int(coverage),
        features=int(features),
        corpus_size=int(corpus_size),
        findings=findings,
        defect=defect[0] if defect else "",
        log=log,
    )


def _environment() -> dict[str, str]:
    return {**os.environ, **SANITIZER_OPTIONS}
