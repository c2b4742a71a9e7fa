"""What can be wrong with a bundle."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class BundleError(TfsatError):
    """An archive is no bundle, is damaged or is not safe to unpack (exit code 1)."""
