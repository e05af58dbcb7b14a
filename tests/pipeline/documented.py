"""The commands and other code that the documents show, taken from their text."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"`((?:bipedstudy|make|python|pip|dask) [^`\n]+)`")


@dataclass(frozen=True)
class Command:
    """One command of a document: its words without the comment, and what is set before it (LAB=...)."""

    words: tuple[str, ...]
    environment: tuple[tuple[str, str], ...] = ()

    @property
    def text(self) -> str:
        """The command as it is typed."""
        return shlex.join(self.words)


def blocks(path: Path, language: str) -> list[str]:
    """Contents of the blocks of this language; of shell commands where it is "sh" (also blocks without a language)."""
    wanted = ("", "sh") if language == "sh" else (language,)
    return [body for named, body in _BLOCK.findall(path.read_text(encoding="utf-8")) if named in wanted]


def commands(path: Path) -> list[Command]:
    """Every line of the blocks of shell commands."""
    found = []
    for block in blocks(path, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            known = [word.partition("=")[::2] for word in words if re.match(r"[A-Z_]+=", word)]
            if words[len(known) :]:
                found.append(Command(tuple(words[len(known) :]), tuple(known)))
    return found


def mentioned(path: Path) -> list[Command]:
    """Commands within sentences, such as `bipedstudy show comparison`; they may be shortened."""
    text = _BLOCK.sub("", path.read_text(encoding="utf-8"))
    return [Command(tuple(shlex.split(found))) for found in _INLINE.findall(text)]
