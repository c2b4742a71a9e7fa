"""`tfsat-host reproduce`: a bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import argparse

from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.errors import DataLossError
from tfsat_host.present.output import Output


def configure(parser: argparse.ArgumentParser) -> None:
    """The bundle, and where to unpack."""
    parser.description = (
        "Unpack a bundle into a new folder, check every file's hash, compute calibration, evaluation and report anew "
        "from the raw data, and say what differs, number by number. Ends with 0 if nothing does; with 3 if something "
        "does, was lost, was changed, or could not be computed; with 1 if the archive is damaged or not safe: then "
        "nothing is unpacked."
    )
    parser.add_argument(
        "bundle", metavar="BUNDLE", type=file_name, help="a file that `tfsat-host bundle` made"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=file_name,
        help="a new folder to unpack into (default: NAME-reproduced here, for NAME.tfsat.zip)",
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Unpacks, computes, compares."""
    from tfsat_host.cli.reproduce_words import show
    from tfsat_host.run.bundle.reproducing import reproduce

    done = reproduce(args.bundle, args.out, out)
    result = {"bundle": str(args.bundle), **done.as_dict()}
    out.result(result, lambda: show(result, done.compared, out))
    return 0 if done.same and not done.incomplete else DataLossError.exit_code
