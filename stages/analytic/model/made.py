"""Modules of which only the text's maker is in the tree: equations that sympy derives at their first use.

Their text is kept where machine code is kept. Two processes that need it at once both make it, as on two processors
neither would be sooner by waiting; each leaves it whole, and the same.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import partial
from types import ModuleType
from typing import Any

from stages.analytic.compiled import FOLDER, ByKind
from stages.analytic.errors import NotDerived
from stages.analytic.model.kinds import Detailed, Plain
from stages.biped.machine_code import Kept, sympy_version

DERIVING = "deriving the equations of motion, some 5 s, once after an install or an edit"
#: The folder's name has the version, as text that came with the program serves where there is no sympy.
EQUATIONS = Kept(f"equations-{sympy_version()}", FOLDER / "model", by=f"sympy {sympy_version()}")


class Made(ModuleType):
    """A module whose `text` is made, and run with what is `given`, when something of it is first asked for."""

    def __init__(self, name: str, text: Callable[[], str], **given: Any) -> None:
        super().__init__(name)
        vars(self).update(given)
        self._text: Callable[[], str] | None = text
        sys.modules[name] = self  # machine code that is loaded names the modules it is of

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or self._text is None:
            raise AttributeError(f"{self.__name__} has no {name}")
        exec(compile(self._text(), self.__name__, "exec", dont_inherit=True), vars(self))
        self._text = None
        return getattr(self, name)


class OfSets(ByKind):
    """The function `name` of each set of equations; `sets` has their modules by the kinds that they are for.

    Only the sets of the kinds that are asked for are made. The type of the last argument decides.
    """

    def __init__(self, name: str, sets: Mapping[Any, Any]) -> None:
        self.name, self.choices, self.chosen, self.place = name, sets, {}, -1

    def of(self, kind: type) -> Any:
        """The function for a kind of walker."""
        return getattr(super().of(kind), self.name)


def derived(kept: Kept, name: str, maker: Callable[[str], Callable[[], str]]) -> str:
    """The text of a module of equations. Raises NotDerived where it is to be made and sympy is missing."""

    def made() -> str:
        try:
            make = maker(name)
        except ImportError as missing:
            raise NotDerived(f"the equations of motion cannot be derived without sympy ({missing}): install it, or a "
                             "wheel that brings them") from None  # fmt: skip
        print(f"note: {DERIVING}: {name.replace('_', ' ')}", file=sys.stderr, flush=True)
        return make()

    return kept.text(f"{name}.txt", made)


def by_sympy(name: str) -> Callable[[], str]:
    """What makes the text of one of this package's modules of equations."""
    from stages.analytic.model.generate import SOURCES

    return SOURCES[name]


def sets(where: str, what: str) -> dict[Any, Any]:
    """The equations of each set as modules beneath `where`; `what` of them: terms, or derivatives of these."""
    return {kinds: Made(f"{where}.{name}", partial(derived, EQUATIONS, f"{name}_{what}", by_sympy))
            for kinds, name in ((Plain, "plain"), (Detailed, "detailed"))}  # fmt: skip
