"""Means of correlated samples: a low-passed gyro repeats itself for tens of milliseconds."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray

BATCHES = 20


def mean_and_covariance(samples: FloatArray, batches: int = BATCHES) -> tuple[FloatArray, FloatArray]:
    """Compute the mean of a stationary record and the covariance of that mean, by batch means.

    The record is cut into batches much longer than its correlation time, so that their means scatter
    independently (Law, "Simulation Modeling and Analysis", section 9.5.3). A drift widens the covariance as
    well.

    Args:
        samples: (n, d) in order of time.
        batches: Number of batches; n must be at least twice that.

    Returns:
        (d,) and (d, d).

    Raises:
        ValueError: there are too few samples.
    """
    length = len(samples) // batches
    if length < 2:
        raise ValueError(f"{len(samples)} samples are too few for {batches} batches")
    # (batches, length, d): the remainder, fewer samples than batches, is left out of the scatter only.
    means = samples[: length * batches].reshape(batches, length, -1).mean(axis=1)
    covariance = np.atleast_2d(np.cov(means, rowvar=False)) / batches
    return samples.mean(axis=0), student_t_factor(batches - 1) * covariance


def student_t_factor(degrees_of_freedom: int) -> float:
    """Compute the factor that widens a variance from few numbers for use in normal intervals.

    It is the variance of Student's t distribution; without it 95 % intervals from ten numbers hold the truth in
    92 %.

    Raises:
        ValueError: fewer than three degrees of freedom: the distribution has no variance.
    """
    if degrees_of_freedom < 3:
        raise ValueError(f"{degrees_of_freedom} degrees of freedom have no variance")
    return degrees_of_freedom / (degrees_of_freedom - 2)


def root_of(covariance: FloatArray) -> FloatArray:
    """(p, p) R with R Rᵀ = covariance, which may be singular: column k is what the k-th independent error does."""
    # Rounding can make eigenvalues of a singular covariance slightly negative: clip them.
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
