"""Several drops under their documented name: see `drop_comparison`."""

from tfsat_host.run.drop_comparison import Comparison as Comparison
from tfsat_host.run.drop_comparison import evaluate_several as evaluate_several
