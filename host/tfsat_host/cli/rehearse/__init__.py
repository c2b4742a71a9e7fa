"""`tfsat-host rehearse`: a drop lived through on a desk."""

from tfsat_host.cli.rehearse.command import configure, run

__all__ = ["configure", "run"]
