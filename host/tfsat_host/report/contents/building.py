"""`document_of` under its documented name: see `document_builder`."""

from tfsat_host.report.contents.document_builder import document_of as document_of
