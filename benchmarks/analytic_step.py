"""One step of the walker of Table 1: compiled code against SciPy, and against heyoka where it is installed.

    python benchmarks/analytic_step.py

All start from the same point of the gait. Errors are against the compiled path at tolerance 1e-14. Time is processor
time, the best of several runs, so that other work on the machine disturbs it least. SciPy's rows are its DOP853 on a
lambdified right-hand side: a whole step with events (`readable.py`), and the single stance alone.
"""

import importlib.util
import time
from collections.abc import Callable

import numpy as np

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.analytic.integration.phase import NO_NODES, integrate
from stages.analytic.integration.readable import take_step
from stages.analytic.model.walker import Walker
from stages.analytic.phases.motion import DOUBLE_STANCE, SINGLE_STANCE
from stages.analytic.phases.section import section_state
from stages.biped.design import Biped
from stages.ground.slope import Slope

TABLE_1 = Biped(
    legs="compliant", hip_mass=0.316, foot_mass=0.335, leg_length=0.333, foot_radius=0.083, foot_com=0.100,
    stiffness=2800.0, damping=58.35, leg_inertia=0.0)


def best_time(call: Callable[[], object], repeats: int, rounds: int) -> float:
    """Processor time of one call [s]: the best round of `repeats` calls."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        for _ in range(repeats):
            call()
        times.append((time.process_time() - start) / repeats)
    return min(times)


def heyoka_single_stance(walker: Walker, y: np.ndarray, duration: float, tolerance: float) -> Callable[[], np.ndarray]:
    """One single stance of given duration by heyoka's Taylor integrator, compact equations solved in closed form."""
    import heyoka as hy
    import sympy as sp

    from stages.analytic.model import derivation as d
    from stages.analytic.model.generate import compact

    equations = d.derive("compliant")
    numbers = {symbol: getattr(walker.p, name) for name, symbol in d.TABLE_1.parameters.items()}
    mass = equations.mass.applyfunc(compact)
    force = (equations.applied_force - equations.coriolis * equations.rates).applyfunc(compact)
    m = [[sp.Symbol(f"m{min(i, j)}{max(i, j)}") for j in range(4)] for i in range(4)]
    f = [sp.Symbol(f"f{i}") for i in range(4)]
    m[2][3] = m[3][2] = sp.Integer(0)
    solution = sp.Matrix(m).LUsolve(sp.Matrix(f))
    values = {m[i][j]: mass[i, j] for i in range(4) for j in range(i, 4) if m[i][j] != 0}
    values |= {f[i]: force[i] for i in range(4)}
    names = [*equations.coordinates, *equations.rates]
    symbols = {str(name): variable for name, variable in zip(names, hy.make_vars(*map(str, names)), strict=True)}
    rates = [*equations.rates, *(entry.subs(values).subs(numbers) for entry in solution)]
    system = [(symbols[str(name)], hy.from_sympy(sp.sympify(rate).subs(numbers)))
              for name, rate in zip(names, rates, strict=True)]
    integrator = hy.taylor_adaptive(system, list(y), tol=tolerance)

    def run() -> np.ndarray:
        integrator.time = 0.0
        integrator.state[:] = y
        integrator.propagate_until(duration)
        return integrator.state.copy()

    return run


def scipy_single_stance(walker: Walker, y: np.ndarray, duration: float, tolerance: float) -> Callable[[], np.ndarray]:
    """One single stance of given duration by SciPy's DOP853: lambdified terms with common subexpressions, one solve."""
    import sympy as sp
    from scipy.integrate import solve_ivp

    from stages.analytic.model import derivation as d

    equations = d.derive("compliant")
    numbers = {symbol: getattr(walker.p, name) for name, symbol in d.TABLE_1.parameters.items()}
    force = equations.applied_force - equations.coriolis * equations.rates
    terms = sp.lambdify(
        [*equations.coordinates, *equations.rates], [equations.mass.subs(numbers), force.subs(numbers)], cse=True)

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        mass, force = terms(*state)
        return np.concatenate([state[4:], np.linalg.solve(mass, force)[:, 0]])

    return lambda: solve_ivp(rates, (0.0, duration), y, method="DOP853", rtol=tolerance, atol=tolerance).y[:, -1]


def single_stance_rows(walker: Walker, z: np.ndarray, row: Callable[[str, float, float, float], None]) -> None:
    """Single stance alone: compiled with its heel strike located, heyoka over the same time without an event."""
    start = section_state(z, walker.p)
    integrate(DOUBLE_STANCE, start, walker.p, 1e-14, 30.0, 100_000, 0.02, NO_NODES)

    def compiled_stance(tolerance: float) -> tuple[np.ndarray, float]:
        y = start.copy()
        _, duration, *_ = integrate(SINGLE_STANCE, y, walker.p, tolerance, 30.0, 100_000, 0.02, NO_NODES)
        return y, duration

    exact, duration = compiled_stance(1e-14)
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        error = np.abs(compiled_stance(tolerance)[0] - exact).max()
        seconds = best_time(lambda t=tolerance: compiled_stance(t), 100, 40)
        row("compiled, single stance", tolerance, error, seconds)
    for tolerance in (1e-8, 1e-10):
        propagate = scipy_single_stance(walker, start, duration, tolerance)
        error = np.abs(propagate() - exact).max()
        row("SciPy, single stance, no event", tolerance, error, best_time(propagate, 1, 10))
    if importlib.util.find_spec("heyoka") is None:
        print("heyoka is not installed: its rows are left out")
        return
    for tolerance in (1e-8, 1e-12, 1e-15):
        propagate = heyoka_single_stance(walker, start, duration, tolerance)
        error = np.abs(propagate() - exact).max()
        row("heyoka, single stance, no event", tolerance, error, best_time(propagate, 100, 40))


def main() -> None:
    walker, point = find_gait(TABLE_1, Slope(slope_deg=2.0, gravity=9.81), 1e-13)
    z = point.z * (1 + 1e-3)
    exact = poincare_map(walker, z, 1e-14).z
    print(f"{'one step':34}{'tolerance':>10}{'error':>10}{'time us':>10}")

    def row(name: str, tolerance: float, error: float, seconds: float) -> None:
        print(f"{name:34}{tolerance:10.0e}{error:10.1e}{1e6 * seconds:10.0f}")

    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        error = np.abs(poincare_map(walker, z, tolerance).z - exact).max()
        row("compiled", tolerance, error, best_time(lambda t=tolerance: poincare_map(walker, z, t), 100, 40))
    for tolerance in (1e-8, 1e-10):
        seconds = best_time(lambda t=tolerance: poincare_derivative(walker, z, t), 50, 20)
        row("compiled, with exact derivative", tolerance, np.nan, seconds)
    error = np.abs(take_step(walker, z, 1e-8).z - exact).max()
    row("readable path (SciPy, with events)", 1e-8, error, best_time(lambda: take_step(walker, z, 1e-8), 1, 5))
    single_stance_rows(walker, z, row)


if __name__ == "__main__":
    main()
