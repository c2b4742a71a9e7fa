"""Errors that refuse a calibration."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class CalibrationError(TfsatError):
    """The recording does not support a calibration; nothing was kept."""


class NotKeptError(TfsatError):
    """A step was accepted, and cannot be written; nothing was changed."""
