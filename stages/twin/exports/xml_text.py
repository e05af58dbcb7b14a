"""Documents of the formats that are XML, as trees of tags."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias
from xml.etree import ElementTree

import numpy as np

Element: TypeAlias = ElementTree.Element
#: Text, or numbers that become text which gives the same bits when read.
Value: TypeAlias = "str | float | Iterable[Any]"


def text(value: Value) -> str:
    """A value as it stands in a document."""
    if isinstance(value, str):
        return value
    return " ".join(repr(float(number)) for number in np.atleast_1d(np.asarray(value, dtype=float)))


def tag(name: str, /, *content: Element | Value, **attributes: Value) -> Element:
    """An element with its children, or its text."""
    made = ElementTree.Element(name, {key: text(value) for key, value in attributes.items()})
    for each in content:
        if isinstance(each, ElementTree.Element):
            made.append(each)
        else:
            made.text = text(each)
    return made


def tensor(inertia: np.ndarray) -> dict[str, float]:
    """Entries of a tensor of inertia by name."""
    return {f"i{'xyz'[i]}{'xyz'[j]}": inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))}


def document(root: Element, remark: str) -> bytes:
    """The document with a remark at its head."""
    ElementTree.indent(root)
    head = f'<?xml version="1.0"?>\n<!-- {remark.replace("--", "-")} -->\n'
    return (head + ElementTree.tostring(root, encoding="unicode") + "\n").encode()
