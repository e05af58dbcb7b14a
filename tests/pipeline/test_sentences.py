"""Sentences of the pages, the help, the claims and the captions are short enough to be read once.

A sentence is counted up to a full stop or a semicolon, of which it has at most one. Quotations of the paper, tables,
code and lists that are generated are not counted; what stands in backquotes counts as a word.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from pipeline.cli import cli
from stages.figures.drawn import NAMES, figure
from tests.figures.made_up_results import given

HOME = Path(__file__).resolve().parents[2]
PAGES = [HOME / "README.md", *sorted((HOME / "docs").glob("*.md"))]
MOST = 35
PRIVATE = re.compile(
    r"\b(foret\w+|yardsticks?|unsaid|rungs?|g[ai]ves? way|by turns|once weighed|felt|feels?|leaves? open)\b"
)
_NOT_PROSE = re.compile(
    r"^```.*?^```|^\$\$.*?\$\$|<!--.*?-->|^\|.*?$|^## Parameters\n\nBy file.*|^#.*?$|^!\[.*?$"
    r"|^- \*(?:says|rests on|shown in)\*.*?$",
    re.MULTILINE | re.DOTALL,
)


def too_long(text: str) -> list[str]:
    """The sentences of a text in Markdown that have too many words or semicolons."""
    return [sentence for sentence in sentences(text) if sentence.count(";") > 1 or longest(sentence) > MOST]


def sentences(text: str) -> Iterator[str]:
    """The sentences of the paragraphs and of the items of lists."""
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", _NOT_PROSE.sub("\n\n", text)):
        words = re.sub(r"`[^`]*`|\$[^$]*\$", "code", " ".join(block.split()))
        words = re.sub(r"\]\([^)]*\)", "]", words)
        yield from filter(None, re.split(r"(?<=[.!?])[\"')*_\]]*\s+", words))


def longest(sentence: str) -> int:
    """The words of a sentence's longer part, where a semicolon divides it."""
    return max(sum(any(map(str.isalnum, word)) for word in part.split()) for part in sentence.split(";"))


def test_the_count_finds_what_is_too_long():
    assert too_long("one " * 35 + "end.") and not too_long("one " * 34 + "end.")
    assert too_long("a; b; c.") and not too_long("a; " + "b " * 35)
    assert not too_long("| " + "one " * 40 + "|\n\n```\n" + "one " * 40 + "\n```\n")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_sentences_of_a_page_are_short(page):
    assert too_long(page.read_text(encoding="utf-8")) == []


def test_sentences_of_the_help_are_short():
    context = click.Context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        options = [item.help or "" for item in command.params if isinstance(item, click.Option)]
        assert too_long("\n\n".join([command.help or "", command.short_help or "", *options])) == [], name


@pytest.mark.parametrize("name", NAMES)
def test_sentences_of_a_caption_are_short(name):
    assert too_long(figure(name).caption(given(name))) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_has_no_words_with_a_private_meaning(page):
    words = re.sub(r"`[^`]*`", "", _NOT_PROSE.sub("", page.read_text(encoding="utf-8")))
    assert PRIVATE.findall(words) == []


def test_the_pages_are_no_longer_than_a_newcomer_reads():
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in PAGES if page.parent.name == "docs") <= 40_000
