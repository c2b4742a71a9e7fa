"""One drop or several as one offline HTML page: numbers, linked plots and a replay in three dimensions.

    Path("report.html").write_text(render(document), encoding="utf-8")

`tfsat_host.report.document` names the parts of a document.
"""

from tfsat_host.report.document import Document
from tfsat_host.report.page import render

__all__ = ["Document", "render"]
