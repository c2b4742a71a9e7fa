"""What of a recording is cut out as the drop."""

from __future__ import annotations

import pytest

from tests.evaluation.corrupted import without_samples
from tests.evaluation.drops import certificate, flown
from tfsat_host.evaluation.motion.samples import EvaluationError, samples_of


@pytest.mark.parametrize(("from_s", "until_s"), [(-0.25, -0.02), (-0.4, 0.0)])
def test_a_hole_before_the_release_is_none_in_the_fall(from_s: float, until_s: float) -> None:
    one = flown(1)
    found = samples_of(without_samples(one.log, from_s, until_s), certificate(one, 1), one.model)
    whole = samples_of(one.log, certificate(one, 1), one.model)
    assert found.t_s[found.fall].tolist() == whole.t_s[whole.fall].tolist()


@pytest.mark.parametrize(("from_s", "until_s"), [(-0.05, 0.12), (2.2, 2.6)])
def test_the_fall_s_own_ends_may_not_be_lost(from_s: float, until_s: float) -> None:
    one = flown(1)
    with pytest.raises(EvaluationError, match="No gyro has a sample between"):
        samples_of(without_samples(one.log, from_s, until_s), certificate(one, 1), one.model)
