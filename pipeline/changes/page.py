"""The page of what changed, with pictures side by side; self-contained like the report."""

from __future__ import annotations

import base64
from pathlib import Path

from pipeline import layout
from pipeline.cache import durable
from pipeline.changes.folders import Changes
from pipeline.report.page import template
from pipeline.study import shown

_TEMPLATE = Path(__file__).with_name("page.html")
#: Rows of numbers on the page.
_MOST = 300


def share(relative: float | None) -> str:
    """A relative change in per cent; nothing for what is no number."""
    if relative is None:
        return ""
    if abs(relative) == float("inf"):
        return "from zero"
    return f"{100 * relative:+.3g} %"


def html(found: Changes) -> bytes:
    """The page."""
    pictures = [(each.name, each.what, _data(each.before), _data(each.after)) for each in found.figures]
    return template(_TEMPLATE).render(
        found=found, before=shown(found.before), after=shown(found.after), most=_MOST, share=share, short=layout.short,
        pictures=pictures,
    ).encode()  # fmt: skip


def _data(path: Path) -> str:
    """A picture as an address of data; nothing for a page's fragment or what is not there."""
    content = durable.read(path) if path.suffix == ".png" else None
    return "" if content is None else "data:image/png;base64," + base64.b64encode(content).decode()
