"""The one way the ingest says no."""

from __future__ import annotations


class SourceRefused(ValueError):
    """A source cannot be read or a recording cannot be used; the message is one sentence a user can act on."""


def printable(name: object, limit: int = 60) -> str:
    """A name from a source, safe to show: control characters escaped, shortened to `limit` characters."""
    text = str(name).encode("unicode_escape").decode("ascii")
    return f"'{text[:limit]}…'" if len(text) > limit else f"'{text}'"
