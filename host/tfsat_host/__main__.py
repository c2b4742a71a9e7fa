"""`python -m tfsat_host` is `tfsat-host`."""

import sys

from tfsat_host.cli.start import start

if __name__ == "__main__":
    sys.exit(start())
