"""Source of one generated function: common subexpressions taken out, all else written as sympy has it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import sympy as sp
from sympy.printing.pycode import pycode

from stages.analytic.model import derivation as d
from stages.analytic.model.simplification import for_code, shortened


def literal(expression: sp.Expr) -> str:
    """Python source of an expression; an integer on its own becomes a float, so that all outputs have one type."""
    source: str = pycode(expression, fully_qualified_modules=False)
    return f"{source}.0" if expression.is_Integer else source


def kind_of(name: str, design: d.Design) -> str:
    """The type of the walker's numbers that a generated function takes, whose name begins with the kind of legs."""
    return ("" if design is d.TABLE_1 else "Detailed") + ("Rigid" if name.startswith("rigid") else "Compliant")


def function_source(
    name: str, arguments: Sequence[sp.Symbol], outputs: Sequence[sp.Expr], doc: str, kind: str = "",
    design: d.Design = d.TABLE_1,
) -> str:  # fmt: skip
    """Source of one compiled function of the walker's numbers: common subexpressions, return a tuple.

    `kind` is the type of these numbers, by default the one that the name and the design say.
    """
    shared, reduced = sp.cse(list(outputs), symbols=sp.numbered_symbols("u"), order="none")
    used = set().union(*(expression.free_symbols for expression in outputs)) if outputs else set()
    kind = kind or kind_of(name, design)
    lines = ["@compiled", f"def {name}({', '.join(f'{name}: float' for name in arguments)}, p: {kind}) -> Numbers:",
             f'    """{doc}"""']
    symbols = [name for name, symbol in design.parameters.items() if symbol in used]
    if symbols:
        lines += [f"    {', '.join(symbols)} = {', '.join(f'p.{symbol}' for symbol in symbols)}"]
    lines += [f"    {symbol} = {literal(value)}" for symbol, value in shared]
    comma = "," if len(reduced) == 1 else ""
    lines += ["    return (" + ",\n            ".join(map(literal, reduced)) + f"{comma})"]
    return "\n".join(lines) + "\n"


@cache
def compact(expression: sp.Expr, design: d.Design = d.TABLE_1) -> sp.Expr:
    """The short form of a term."""
    return for_code(shortened(expression, design), design)
