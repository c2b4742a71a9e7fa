"""Bias, mounting and scale factors of a gyro, from what it reads of known motions."""
