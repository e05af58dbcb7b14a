"""What `python -m stages.analytic.model.generate` writes is current, and the short forms have the same value."""

from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from stages.analytic.derivatives.equations import detailed, plain
from stages.analytic.integration import dop853_step
from stages.analytic.model import derivation as d
from stages.analytic.model import detailed_equations, equations, formulas, generated_source
from stages.analytic.model.formulas import document
from stages.analytic.model.generate import module_source, step_source
from stages.analytic.model.generate_derivatives import derivatives_source
from stages.analytic.model.generated_source import compact, is_current, signed

tidy = cache(formulas.tidy)


def test_sums_of_the_integrator_are_current():
    assert Path(dop853_step.__file__).read_text(encoding="utf-8") == step_source()


MADE = [(partial(derivatives_source, d.TABLE_1), plain), (partial(derivatives_source, d.DETAILED), detailed),
        (partial(module_source, d.TABLE_1), equations), (partial(module_source, d.DETAILED), detailed_equations)]
FILES = pytest.mark.parametrize(("source", "module"), MADE, ids=[module.__name__ for _, module in MADE])


@FILES
def test_equations_are_current(source, module):
    """Nobody has edited them by hand, and they belong to this derivation."""
    assert is_current(Path(module.__file__))


@pytest.mark.slow
@FILES
def test_equations_are_generated_anew_as_they_are(source, module):
    """By this sympy, too."""
    assert Path(module.__file__).read_text(encoding="utf-8") == signed(source())


def test_an_edit_of_generated_equations_or_of_what_makes_them_is_seen(tmp_path, monkeypatch):
    path = tmp_path / "made.py"
    path.write_text(signed("a = 1\n"))
    assert is_current(path)
    path.write_text(path.read_text().replace("1", "2", 1))
    assert not is_current(path)
    path.write_text(signed("a = 1\n"))
    monkeypatch.setattr(generated_source, "MAKERS", generated_source.MAKERS[1:])
    assert not is_current(path)


def test_page_of_formulas_is_current(monkeypatch):
    monkeypatch.setattr(formulas, "tidy", tidy)  # of the terms below, each once
    page = Path(__file__).parents[2] / "docs" / "equations.md"
    assert page.read_text(encoding="utf-8") == document()


@pytest.mark.parametrize(("legs", "form"), [
    ("compliant", tidy), ("rigid", compact), pytest.param("rigid", tidy, marks=pytest.mark.slow),
    pytest.param("compliant", compact, marks=pytest.mark.slow),  # as of a detailed design below
], ids=["compliant-tidy", "rigid-compact", "rigid-tidy", "compliant-compact"])
def test_short_forms_keep_their_value(legs, form):
    keep_their_value(d.derive(legs), form)


@pytest.mark.parametrize("legs", ["compliant", pytest.param("rigid", marks=pytest.mark.slow)])
def test_short_forms_of_a_detailed_design_keep_their_value(legs):
    keep_their_value(d.derive(legs, d.DETAILED), partial(compact, design=d.DETAILED))


def keep_their_value(equations, form):
    terms = [*equations.mass, *equations.coriolis, *equations.applied_force, *equations.constraint]
    if len(equations.coordinates) == 2:
        terms += list(d.handover_matrix(equations))
    symbols = [*equations.coordinates, *equations.rates, *equations.design.parameters.values()]
    terms = [*dict.fromkeys(terms)]  # a matrix has its terms beside its diagonal twice
    before, after = (sp.lambdify(symbols, values, "numpy", docstring_limit=0)
                     for values in (terms, [form(term) for term in terms]))
    rng = np.random.default_rng(4)
    for values in rng.uniform(0.2, 1.5, (20, len(symbols))):
        assert np.allclose(before(*values), after(*values), rtol=1e-12, atol=1e-13)
