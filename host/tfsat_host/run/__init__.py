"""A run: the folder of one drop, from its files to its evaluation, report, bundle and campaign.

from tfsat_host.run import EvaluationOptions, Run

run = Run.open("run")
evaluated = run.evaluate()
print(evaluated.verdict.sentence)
run.report()
run.bundle("drop.tfsat.zip")
"""

from tfsat_host.run.options import EvaluationOptions
from tfsat_host.run.run import Run

__all__ = ["EvaluationOptions", "Run"]
