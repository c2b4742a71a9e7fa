"""`python -m tfsat_host` is `tfsat-host`."""

import sys

from tfsat_host.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
