"""The two filters that the evaluation has for itself, against SciPy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import lsim, savgol_filter

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.motion.gyro_signal import FINE_S, Lag
from tfsat_host.evaluation.motion.joints import SMOOTHED, smoothed

FINITE = st.floats(-1e100, 1e100)


def assert_close(ours: FloatArray, theirs: FloatArray, given_to_both: FloatArray) -> None:
    """To rounding of the largest number that went in."""
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9 * float(np.abs(given_to_both).max()))


@given(
    arrays(np.float64, st.tuples(st.integers(2, 60), st.integers(1, 3)), elements=FINITE),
    st.floats(1e-4, 0.05),
)
def test_a_lag_of_one_pole_is_that_pole(shown: FloatArray, constant_s: float) -> None:
    """Of a signal that is linear between samples and was settled before the first of them."""
    t_s = FINE_S * np.arange(len(shown), dtype=np.float64)
    lag = Lag(constant_s, 0.0, 0.0, constant_s, measured=True)
    pole = ([[-1.0 / constant_s]], [[1.0 / constant_s]], [[1.0]], [[0.0]])
    late = np.column_stack([lsim(pole, column, t_s, X0=column[:1])[1] for column in shown.T])
    assert_close(lag.applied(t_s, shown), late, shown)


@given(arrays(np.float64, st.integers(SMOOTHED + 1, 60), elements=FINITE))
def test_smoothed_is_the_filter_of_savitzky_and_golay(values: FloatArray) -> None:
    assert_close(smoothed(values), savgol_filter(values, SMOOTHED, 3), values)
