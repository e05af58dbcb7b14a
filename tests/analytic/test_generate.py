"""What `python -m stages.analytic.model.generate` writes is current, and the short forms have the same value."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from stages.analytic.derivatives.equations import detailed, plain
from stages.analytic.integration import dop853_step
from stages.analytic.model import derivation as d
from stages.analytic.model import detailed_equations, equations
from stages.analytic.model.formulas import document, tidy
from stages.analytic.model.generate import module_source, step_source
from stages.analytic.model.generate_derivatives import derivatives_source
from stages.analytic.model.generated_source import compact


def test_sums_of_the_integrator_are_current():
    assert Path(dop853_step.__file__).read_text(encoding="utf-8") == step_source()


@pytest.mark.parametrize(("module", "design"), [(plain, d.TABLE_1), (detailed, d.DETAILED)])
def test_derivatives_by_the_walkers_numbers_are_current(module, design):
    assert Path(module.__file__).read_text(encoding="utf-8") == derivatives_source(design)


@pytest.mark.parametrize(("module", "design"), [(equations, d.TABLE_1), (detailed_equations, d.DETAILED)])
def test_equations_of_motion_are_current(module, design):
    assert Path(module.__file__).read_text(encoding="utf-8") == module_source(design)


def test_page_of_formulas_is_current():
    page = Path(__file__).parents[2] / "docs" / "equations.md"
    assert page.read_text(encoding="utf-8") == document()


@pytest.mark.parametrize("form", [tidy, compact])
@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_short_forms_keep_their_value(legs, form):
    keep_their_value(d.derive(legs), form)


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_short_forms_of_a_detailed_design_keep_their_value(legs):
    keep_their_value(d.derive(legs, d.DETAILED), partial(compact, design=d.DETAILED))


def keep_their_value(equations, form):
    terms = [*equations.mass, *equations.coriolis, *equations.applied_force, *equations.constraint]
    if len(equations.coordinates) == 2:
        terms += list(d.handover_matrix(equations))
    symbols = [*equations.coordinates, *equations.rates, *equations.design.parameters.values()]
    before, after = (sp.lambdify(symbols, list(values), "numpy") for values in (terms, [form(t) for t in terms]))
    rng = np.random.default_rng(4)
    for values in rng.uniform(0.2, 1.5, (20, len(symbols))):
        assert np.allclose(before(*values), after(*values), rtol=1e-12, atol=1e-13)
