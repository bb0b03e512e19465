"""From content to HTML. Whatever comes from a file is text: escaped, and what is not of chebid cannot run."""

import base64
import hashlib
import json
import math
from importlib import resources
from typing import Any

import jinja2
from markupsafe import Markup

from chebid.report.page.collect import Report
from chebid.report.page.content import page_content
from chebid.report.style import COLOURS
from chebid.report.tables import number


def render(report: Report) -> str:
    """The page, as HTML 5."""
    return render_content(page_content(report))


def render_content(content: dict[str, Any]) -> str:
    """The template filled in; `content` as `page_content` makes it."""
    loader = jinja2.FunctionLoader(_file)
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"number": _number, "percent": _percent, "packed": _packed}
    script, style = _file("page.js"), _colours() + _file("page.css")
    return environment.get_template("page.html").render(
        content, script=script, style=style, script_hash=_hash(script), style_hash=_hash(style)
    )


def _file(name: str) -> str:
    return resources.files("chebid.report.page").joinpath(name).read_text(encoding="utf-8")


def _colours() -> str:
    """The palette of all figures."""
    return ":root{" + "".join(f"--c{i}:{colour};" for i, colour in enumerate(COLOURS)) + "}\n"


def _hash(text: str) -> str:
    """For the page's own rule of what may run and what may dress it."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _number(value: float | None, digits: int = 3) -> str:
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{value:.0f}" if 10**digits <= abs(value) < 1e6 else number(value, digits)
    return text.replace("-", "−")


def _percent(value: float | None, digits: int = 3) -> str:
    """A fraction as percent."""
    return "–" if value is None or not math.isfinite(value) else f"{100 * value:.{digits}g} %".replace("-", "−")


def _packed(value: Any) -> Markup:
    """JSON that may stand in a script element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)
