"""A YAML file that an option names, as a plain mapping that knows where its entries stand."""

from __future__ import annotations

from typing import Any

from pipeline.parameters.yaml_text import Node


class Described(dict[str, Any]):
    """The plain content of a YAML file whose outermost lines are `key: value`."""

    def __init__(self, node: Node, where: str) -> None:
        super().__init__(node.plain())
        self._node, self._where = node, where

    def place(self, *keys: Any) -> str:
        """Where the entry under these keys, one inside the other, stands: file, line and key, for messages.

        The line is that of the innermost one that is there.
        """
        node = self._node
        for key in keys:
            inside = node.value
            if (isinstance(inside, dict) and key in inside) or (isinstance(inside, list) and key in range(len(inside))):
                node = inside[key]
        named = ".".join(str(key) for key in keys)
        return f"{self._where}:{node.line}" + (f": {named}" if named else "")
