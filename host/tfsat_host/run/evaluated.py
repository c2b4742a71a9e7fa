"""`EvaluatedRun` under its documented name: see `drop_evaluation`."""

from tfsat_host.run.drop_evaluation import EvaluatedRun as EvaluatedRun
