"""One self-contained HTML page of models and logs: everything inline, the same bytes from the same input."""

from chebid.report.page.collect import Report, Sheet, collect
from chebid.report.page.render import render

__all__ = ["Report", "Sheet", "collect", "render"]
