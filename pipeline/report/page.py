"""Writes the report, and tells whether the one that lies there still fits the results.

The page is no stage's output: it holds how long stages took, which no two runs share. Without the times the same
results give the same bytes.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pipeline.cache import disk
from pipeline.cache.store import Entry
from pipeline.graph import REPORT
from pipeline.parameters import levels
from pipeline.study import Study

if TYPE_CHECKING:
    from jinja2 import Template

    from pipeline.report.content import Content

_TEMPLATE = Path(__file__).with_name("page.html")
_SEAL = '<meta name="made-from" content="{}">'
_WHOLE = '<meta name="whole" content="{}">'
_WHOLE_LENGTH = len(_WHOLE.format(disk.digest(b"")))


def seal(study: Study, made: Mapping[str, Entry], with_times: bool, stale: Mapping[str, str]) -> str:
    """Hash of all that the page follows from: keys of the results, parameter files, template and its code."""
    parts: list[Any] = [
        [(entry.key, entry.seconds if with_times else 0, entry.summary if entry.refused else "")
         for entry in made.values()], dict(stale)]  # fmt: skip
    files = [*sorted(study.params.glob("*.yaml")), *sorted(_TEMPLATE.parent.glob("*.*"))]
    parts += [disk.digest(disk.read(path) or b"") for path in files]
    return disk.digest(json.dumps(parts).encode())[:32]


def is_current(path: Path, wanted: str) -> bool:
    """Whether the page at `path` carries the seal `wanted` and is as it was written."""
    with contextlib.suppress(OSError):
        head, mark, rest = (disk.read(path) or b"").partition(_SEAL.format(wanted).encode())
        return bool(mark) and rest.startswith(_whole(head, rest[_WHOLE_LENGTH:]))
    return False


def _whole(head: bytes, rest: bytes) -> bytes:
    """What stands behind the seal: a hash of all else on the page, so that damage is told."""
    return _WHOLE.format(disk.digest(head + rest)).encode()


def render(study: Study, made: Mapping[str, Entry], with_times: bool, stale: Mapping[str, str]) -> bytes:
    """The page. `stale` maps stages that are not current to the reason. Raises `StudyError` for damaged results."""
    from pipeline.report.content import gather

    seconds = f"{sum(entry.seconds for entry in made.values()):.0f}" if with_times else ""
    return html(gather(study, made, with_times), seal(study, made, with_times, stale), seconds, stale)


@cache
def template(path: Path) -> Template:
    """The template of a page at `path`."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(path.read_text(encoding="utf-8"))


def html(content: Content, sealed: str, seconds: str, stale: Mapping[str, str]) -> bytes:
    """The page of a given content; `seconds` is the time of all stages, empty to leave times out."""
    page = template(_TEMPLATE).render(
        content=content,
        seal=_SEAL.format(sealed),
        with_times=bool(seconds),
        seconds=seconds,
        stale=stale,
        usual_level=levels.DEFAULT,
    )
    head, mark, rest = page.encode().partition(_SEAL.format(sealed).encode())
    return head + mark + _whole(head, rest) + rest


def refresh(study: Study, failed: Mapping[str, str] = MappingProxyType({})) -> Path | None:
    """Write results/report.html if it does not fit the results; its path if it was written. For the end of a run, in
    which stages may have failed: (stage -> why).
    """
    from pipeline.report.content import entries

    made = entries(study, failed)
    path = study.results / REPORT
    if is_current(path, seal(study, made, True, {})):
        return None
    disk.write(path, render(study, made, True, {}))
    return path
