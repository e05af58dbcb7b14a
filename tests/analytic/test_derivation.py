"""The derived equations: what mechanics demands of them, and that the generated and compiled ones have their values."""

import hashlib
import os
import subprocess
import sys
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from stages.analytic.model import derivation as d, formulas, made, terms
from stages.analytic.model.formulas import document
from stages.analytic.model.generate import SOURCES, compact
from stages.analytic.model.kinds import DetailedCompliant, DetailedRigid, PlainCompliant, PlainRigid, present
from stages.analytic.phases.motion import (
    DOUBLE_STANCE,
    RIGID,
    SINGLE_STANCE,
    accelerations,
)
from tests.analytic.designs import HEAVY_LEGS, TABLE_1_RIGID, changed, double_stance_states, random_states, walker_of

LEGS = ("compliant", "rigid")
WALKERS = {"compliant": walker_of(HEAVY_LEGS), "rigid": walker_of(changed(TABLE_1_RIGID, leg_inertia=2e-3))}
each_kind = pytest.mark.parametrize("legs", LEGS)
equations_of = cache(d.derive)


def numeric(legs, expression):
    """A function (state, p) of an expression or matrix."""
    equations = equations_of(legs)
    symbols = list(equations.coordinates) + list(equations.rates)
    names = present(WALKERS[legs].p)
    numbers = [getattr(WALKERS[legs].p, name) for name in names]
    function = sp.lambdify([symbols, [d.TABLE_1.parameters[name] for name in names]], expression, "numpy")
    return lambda y: np.asarray(function(y, numbers), dtype=float)


@each_kind
def test_mass_matrix_is_symmetric_and_positive_definite(legs):
    mass = numeric(legs, equations_of(legs).mass)
    for y in random_states(WALKERS[legs], 200):
        value = mass(y)
        assert np.abs(value - value.T).max() <= 1e-15
        np.linalg.cholesky(value)


@each_kind
def test_coriolis_matrix_makes_mass_rate_minus_twice_it_skew(legs):
    """dM/dt - 2 C is skew, so that C qd does no work: the C of eq. (6) is the right one, not merely the right C qd."""
    equations = equations_of(legs)
    rate = d.time_derivative(equations.mass, equations.coordinates, equations.rates)
    skew = numeric(legs, rate - 2 * equations.coriolis)
    for y in random_states(WALKERS[legs], 50):
        value = skew(y)
        assert np.abs(value + value.T).max() <= 1e-14


@each_kind
def test_equations_of_motion_are_those_of_lagrange(legs):
    """M qdd + C qd - Q equals d/dt dT/dqd - dT/dq + dV/dq + damping for the energies, derived the other way."""
    equations = equations_of(legs)
    kinetic, potential = d.energies(equations)
    q, qd, qdd = equations.coordinates, equations.rates, equations.accelerations
    momentum = sp.Matrix([kinetic]).jacobian(qd).T
    lagrange = momentum.jacobian(q) * qd + momentum.jacobian(qd) * qdd - sp.Matrix([kinetic - potential]).jacobian(q).T
    for length, rate in ((d.L1, d.dL1), (d.L2, d.dL2)):
        if length in list(q):
            lagrange[list(q).index(length)] += d.b * rate
    newton = equations.mass * qdd + equations.coriolis * qd - equations.applied_force
    acceleration = dict(zip(qdd, np.random.default_rng(1).normal(size=len(qdd)), strict=True))
    difference = numeric(legs, (lagrange - newton).subs(acceleration))
    for y in random_states(WALKERS[legs], 30):
        assert np.abs(difference(y)).max() <= 1e-11


# --- The generated and compiled equations are the derivation's, unedited.


@pytest.mark.parametrize(("legs", "phase", "exact"), [
    ("rigid", RIGID, 1e-12), ("compliant", SINGLE_STANCE, 1e-12), ("compliant", DOUBLE_STANCE, 1e-10)])
def test_compiled_accelerations_and_loads_solve_the_derivations_system_as_numpy_does(legs, phase, exact):
    """Bordered by the constraints where the second foot rolls."""
    walker, equations, both = WALKERS[legs], equations_of(legs), phase == DOUBLE_STANCE
    jacobian, qd = equations.constraint_jacobian, equations.rates
    parts = [numeric(legs, each) for each in (
        equations.mass, equations.applied_force - equations.coriolis * qd, jacobian,
        d.time_derivative(jacobian, equations.coordinates, qd).T * qd)]  # fmt: skip
    for y in double_stance_states(walker, 50) if both else random_states(walker, 100):
        mass, right, pi, bias = (part(y) for part in parts)
        if not both:
            pi, bias = pi[:, :0], bias[:0]
        bordered = np.block([[mass, -pi], [pi.T, np.zeros((len(bias),) * 2)]])
        expected = np.linalg.solve(bordered, np.concatenate([right.ravel(), -bias.ravel()]))
        qdd, loads = accelerations(phase, y, walker.p)
        assert np.allclose([*qdd[:: 2 if walker.rigid else 1], *loads[: len(bias)]], expected, rtol=exact, atol=exact)


# --- The derived equations have the derivation's values, and their text is the same wherever it is made.


tidy = cache(formulas.tidy)
#: Prints a digest of the text of some modules of equations.
DIGEST = """
import hashlib, sys
from stages.analytic.model.generate import SOURCES
print(hashlib.sha256("".join(SOURCES[name]() for name in sys.argv[1:]).encode()).hexdigest())
"""


def digest_with(seed, names, repository):
    """What a new process with this seed of its hashes makes."""
    done = subprocess.run([sys.executable, "-c", DIGEST, *names], cwd=repository, text=True, capture_output=True,
                          env={**os.environ, "PYTHONHASHSEED": seed})  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize(("names", "seeds"), [
    (["plain_derivatives"], ("1",)), pytest.param([*SOURCES], ("0", "1", "2"), marks=pytest.mark.slow)])  # fmt: skip
def test_the_text_is_the_same_in_each_process(repository, names, seeds):
    """Whatever the order of its sets and dictionaries, and so is the one that is kept."""
    kept = "".join(made.derived(made.EQUATIONS, name, made.by_sympy).rpartition("# ")[0] for name in names)
    assert {digest_with(seed, names, repository) for seed in seeds} == {hashlib.sha256(kept.encode()).hexdigest()}


def exact(legs, design):
    """What each derived function gives, as the derivation has it: arguments before `p`, and values."""
    equations = d.derive(legs, design)
    q, qd, qdd = equations.coordinates, equations.rates, equations.accelerations
    n, multipliers = len(q), sp.Matrix([d.lambda1, d.lambda2])
    force = equations.applied_force - equations.coriolis * qd
    inertia, handover, jacobian = equations.mass * qdd, d.handover_matrix(equations), equations.constraint_jacobian
    bias = d.time_derivative(jacobian, q, qd).T * qd
    given, state = [*q, *qd, *qdd], sp.Matrix([*q, *qd])
    yield f"{legs}_terms", [*q, *qd], [*(equations.mass[i, j] for i in range(n) for j in range(i, n)), *force]
    yield f"{legs}_residual_jacobian", given, (inertia - force).jacobian(state)
    yield f"{legs}_reaction", given, d.ground_reaction(equations)
    yield f"{legs}_energy", [*q, *qd], d.energies(equations)
    yield f"{legs}_inertia_jacobian", [*q, *qdd], inertia.jacobian(state)
    yield f"{legs}_handover", [*q], handover
    yield f"{legs}_handover_jacobian", [*q, *qd], (handover * qd).jacobian(q)
    held = jacobian * multipliers if legs == "compliant" else sp.zeros(n, 1)
    extra = [*multipliers] if legs == "compliant" else []
    yield f"{legs}_residual_change", [*given, *extra], inertia - force - held
    yield f"{legs}_impulse_change", [*q, *qdd, *extra], inertia - held
    yield f"{legs}_handover_change", [*q, *qd], handover * qd
    yield f"{legs}_clearance_change", [*q], equations.constraint[:1, :]
    if legs == "compliant":
        constrained = jacobian.T * qdd + bias
        yield "contact_terms", [*q, *qd], [*jacobian.T, *bias]
        yield "contact_force_jacobian", [*q, *multipliers], held.jacobian(q)
        yield "contact_acceleration_jacobian", given, constrained.jacobian(state)
        yield "contact_acceleration_change", given, constrained


def difference(name, arguments, values, kind, design, rng):
    """By how much a derived function, as plain Python, differs at a drawn point from 30 digits, of the largest."""
    point, p, change = rng.uniform(0.2, 1.5, len(arguments)), kind(*rng.uniform(0.2, 1.5, len(kind._fields))), None
    fields = [field for field in kind._fields if field in design.parameters]  # no term holds friction
    symbols, expressions = [*arguments, *(design.parameters[field] for field in fields)], [*values]
    if name.endswith("_change"):
        change = kind(*rng.uniform(-1.0, 1.0, len(kind._fields)))
        expressions = [sum(sp.diff(each, design.parameters[field]) * sp.Float(getattr(change, field), 30)
                           for field in fields) for each in expressions]  # fmt: skip
        by = getattr(terms, name.replace("_change", "_by")).of(kind).py_func(*point, p)
        found = getattr(terms, name).of(kind).py_func(by, change)
    else:
        found = getattr(terms, name).of(kind).py_func(*point, p)
    values = [*point, *(getattr(p, field) for field in fields)]
    here = {symbol: sp.Float(value, 30) for symbol, value in zip(symbols, values, strict=True)}
    expected = np.array([float(sp.sympify(each).evalf(30, subs=here)) for each in expressions])
    return np.abs(np.array(found) - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize(("legs", "design", "kind"), [
    ("rigid", d.TABLE_1, PlainRigid), ("compliant", d.TABLE_1, PlainCompliant), ("rigid", d.DETAILED, DetailedRigid),
    pytest.param("compliant", d.DETAILED, DetailedCompliant, marks=pytest.mark.slow),
], ids=["rigid-plain", "compliant-plain", "rigid-detailed", "compliant-detailed"])
def test_derived_functions_have_the_derivations_values(legs, design, kind):
    """By any version of sympy that the project allows, so those of two agree to round-off."""
    rng = np.random.default_rng(6)
    for name, arguments, values in exact(legs, design):
        assert difference(name, arguments, values, kind, design, rng) < 1e-13, name


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
