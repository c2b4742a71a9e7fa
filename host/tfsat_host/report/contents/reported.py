"""`ReportedDrop` under its documented name: see `document_builder`."""

from tfsat_host.report.contents.document_builder import ReportedDrop as ReportedDrop
