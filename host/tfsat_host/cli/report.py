"""`tfsat-host report`: an evaluated drop, or several, as one page; on demand as figures and as an MCAP file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.run_options import RUNS, options_of
from tfsat_host.cli.usage import OUTPUT, add_options, output_file_name
from tfsat_host.exit_code import ExitCode
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from tfsat_host.run.drop_report import Report


_USAGE = f"""
Evaluate a drop as `evaluate` does and write one HTML page that needs no network: verdict, numbers with standard
deviations, linked plots, a replay of the robot next to the model's prediction, tables. Several drops lie over each
other in one page. Ends with 3 if anything is doubtful.

{RUNS}
files:
--out FILE     the page (default: report.html in the folder of the recording; of several drops, here)
--figures DIR  also write the figures of a paper, as PDF and PNG, into this folder (needs the extra `figures`)
--mcap [FILE]  also write the evaluated drop for Foxglove, PlotJuggler and Rerun (needs the extra `mcap`; without FILE:
               a file next to each recording, such as SD.evaluated.mcap). Give RUN first, or --mcap=FILE
--force        overwrite files that this command did not make
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options that `evaluate` takes, and the files to write."""
    add_options(parser, _USAGE, out=output_file_name, mcap={"const": Path()})


def run(args: argparse.Namespace, out: Output) -> int:
    """Evaluates each drop, draws, writes."""
    from tfsat_host.run.drop_report import REPORT, ReportOptions, report

    report_options = ReportOptions(args.out, args.figures, args.mcap, args.force)
    drop_report = report(args.runs, options_of(args), report_options, out)
    out.result(record(REPORT, drop_report), lambda: _show(drop_report, out))
    doubts = () if drop_report.compared is None else drop_report.compared.doubts
    out.warn_each(doubts)
    if drop_report.refused:
        return ExitCode.FAILED
    doubtful = doubts or any(evaluated_run.verdict.level != "good" for evaluated_run in drop_report.runs)
    return ExitCode.DATA_LOSS if doubtful else 0


def _show(drop_report: Report, out: Output) -> None:
    from tfsat_host.present.evaluation_text import show_verdict

    several = len(drop_report.drops) + len(drop_report.refused) > 1
    for drop in drop_report.drops:
        show_verdict(drop.verdict, f"{drop.verdict.line()}{f' ({drop.name})' if several else ''}", out)
    others = ", ".join(str(path) for path in drop_report.files[1:])
    sentences([f"Report: {drop_report.page}", *([f"Also written: {others}"] if others else [])], out)
