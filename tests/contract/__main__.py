"""`python -m tests.contract [SCENARIO …]`: records what commands print and write now as what they must from now on."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from tests.cli.process import clean_environment
from tests.contract.recorded import EXPECTED, path_of, write_json, write_result
from tests.contract.running import options_of_all_commands, run_scenario
from tests.contract.scenarios import SCENARIOS

for scenario in sys.argv[1:] or SCENARIOS:
    sys.stdout.write(f"{scenario} …\n")
    with tempfile.TemporaryDirectory() as home:
        os.environ.update(clean_environment(Path(home)))
        results = run_scenario(scenario)
    # Whatever the scenario no longer types must not stay recorded.
    shutil.rmtree(EXPECTED / scenario, ignore_errors=True)
    for result in results:
        write_result(path_of(scenario, result["typed"]), result)
shutil.rmtree(EXPECTED / "options", ignore_errors=True)
for command, options in options_of_all_commands().items():
    write_json(EXPECTED / f"options/{command.replace(' ', '-')}.json", options)
