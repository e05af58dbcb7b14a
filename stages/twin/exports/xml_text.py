"""Numbers and documents of the formats that are XML."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree

Element = ElementTree.Element
#: Names of a tensor of inertia's entries.
TENSOR = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def numbers(values: Iterable[Any]) -> str:
    """Numbers as text that gives the same bits when read."""
    return " ".join(repr(float(value)) for value in values)


def add(parent: Element, tag: str, text: str = "", **attributes: str) -> Element:
    """A new child of an element; `_` at the end of an attribute's name is left out."""
    child = ElementTree.SubElement(parent, tag, {name.rstrip("_"): value for name, value in attributes.items()})
    if text:
        child.text = text
    return child


def document(root: Element, remark: str) -> bytes:
    """The document with a remark at its head."""
    ElementTree.indent(root)
    head = f'<?xml version="1.0"?>\n<!-- {remark.replace("--", "-")} -->\n'
    return (head + ElementTree.tostring(root, encoding="unicode") + "\n").encode()
