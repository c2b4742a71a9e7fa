"""`sign` and `verify` under the name that they had before `tfsat_host.run.record`."""

from tfsat_host.run.record import sign, verify

__all__ = ["sign", "verify"]
