"""One drop or several as one offline HTML page: numbers, linked plots and a replay in three dimensions.

    Path("report.html").write_text(render(document), encoding="utf-8")

`tfsat_host.report.contents.document_builder` makes a document of evaluated drops.
"""

from tfsat_host.report.page import render

__all__ = ["render"]
