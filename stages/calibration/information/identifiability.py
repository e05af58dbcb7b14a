"""What runs can show of a design before they are made: standard deviations, combinations without information, what
limits the rest, and what would help.

A run that is planned shows the design's own gait. The information of a Gaussian fit is J^T W J; its inverse is the
smallest covariance an unbiased estimate can have (Cramer and Rao).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice

import numpy as np

from stages.analytic.derivatives.numbers import changes_of, sensitive_names
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import powers
from stages.biped.design import Biped
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known, information_of
from stages.calibration.estimation.run_fit import GUESS, Equations, Model, run_equations
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling, layout_of, usable
from stages.calibration.parameters import Parameters
from stages.imu.parameters import filter_delay

SLOPE = "ground.slope_deg"
#: Looked for in each run by itself: the ramp is set again, and legs that are put on again differ by another tenth of a
#: millimetre, which a walk shows.
EACH_RUNS = (SLOPE, "biped.other_leg_length")
#: Taken as the file has it, unless a lab says how well it knows it.
KNOWN_EVERYWHERE = ("ground.gravity",)
#: Tolerance of the gait that a run is planned on.
FINE = 1e-9


def free_names(design: DesignPoint) -> tuple[str, ...]:
    """The parameters of a design that a calibration looks for."""
    return tuple(name for name in sensitive_names(design) if name not in KNOWN_EVERYWHERE)


def planned_equations(
    parameters: Parameters, place: float = 0.0, names: Sequence[str] = ()
) -> tuple[DesignPoint, Equations, Model]:
    """What one run that the parameters describe would say of the parameters `names` (all, if there are none) and its
    ramp, its foot sensor `place` [m] above the foot's mass centre; and of which design. Raises NoGait where that does
    not walk."""
    design, settings, sensor = DesignPoint(parameters.biped, parameters.slope), parameters.settings, parameters.sensor
    walker, point = find_gait(design.biped, design.slope, FINE, None)
    layout = layout_of(walker, point.z, FINE, parameters.priors)
    first = float(layout.middle[layout.place("mid_stance")]) + settings.settling_s
    lasting = [step.period * walker.time for step in islice(cycle(point.steps), settings.planned_steps)]
    strikes = np.cumsum([0.0, *lasting])
    times = np.arange(0.0, float(strikes[-1]), 1.0 / sensor.rate_hz)
    times = times[times >= first]
    mask = usable(times, strikes, first, settings.before_strike_s, settings.after_strike_s)
    shared = tuple(name for name in names or free_names(design) if name != SLOPE)
    model = Model(shared, (SLOPE,), layout, parameters.noise, sensor.bandwidth_hz, settings.tolerance)
    run = MeasuredRun(
        name="planned",
        sampling=Sampling(times, times, dict.fromkeys(SIDES, filter_delay(sensor.bandwidth_hz)),
                          dict.fromkeys(SIDES, sensor.bandwidth_hz), 0, place),
        samples=dict.fromkeys(SIDES, np.zeros((len(times), 3))), used=dict.fromkeys(SIDES, mask), strikes=strikes,
        own={})  # fmt: skip
    return design, run_equations(design, np.array([design.value(SLOPE)]), layout.middle, run, model), model


def first_model(design: DesignPoint, names: Sequence[str], parameters: Parameters) -> Model:
    """The model in which the parameters `names` of a design are looked for, some of them for each run by itself.

    Raises NoGait where the design has no gait.
    """
    try:
        walker, point = find_gait(design.biped, design.slope, FINE, None)
    except NoGait as why:
        raise NoGait(f"the first guess has no gait, which a fit begins with, on a slope of {design.slope.slope_deg:g} "
                     f"deg (ground.slope_deg); {GUESS}. {why}") from None
    layout = layout_of(walker, point.z, FINE, parameters.priors)
    own = (SLOPE, *(name for name in names if name in EACH_RUNS and name != SLOPE))
    return Model(tuple(name for name in names if name not in own), own, layout, parameters.noise,
                 parameters.sensor.bandwidth_hz, parameters.settings.tolerance, parameters.settings.robust_sigmas)


#: A combination is without information if it may change by this share of its parameters, in standard deviations.
UNSEEN = 1.0
#: A parameter belongs to such a combination if it has this much of it; entries that differ by less than `EQUAL` are the
#: same.
BELONGS, EQUAL = 1e-3, 0.01


@dataclass(frozen=True)
class Identifiability:
    """What `runs` runs show of the parameters `names` (n,): `values`, `scales`, standard deviations `sd` (n,), infinite
    for those in a combination that is not seen, the `unseen` combinations (u, n) in shares of `scales`. The unknown
    that each parameter's error goes along with most is its partner: its name, the correlation (n,), and the parameter's
    standard deviation if it were known (n,).
    """

    names: tuple[str, ...]
    values: Vector
    scales: Vector
    runs: int
    sd: Vector
    unseen: np.ndarray
    partners: tuple[str, ...]
    correlations: Vector
    sd_without: Vector


def identifiability(
    design: DesignPoint, equations: Equations, model: Model, known: Sequence[Known], runs: int = 1
) -> Identifiability:
    """What `runs` runs like the one of `equations` tell, each with sensors and ramp of its own, and `known` values."""
    d, names = len(model.shared), model.of_design
    n = len(names)
    scales = changes_of(design, names).scales
    matrix = equations.matrix.copy()
    if runs > 1:  # the other runs' unknowns are gone already
        matrix[:d, :d] += (runs - 1) * equations.eliminated(d)[0]
    matrix[:n, :n] += information_of(known, names)
    unit = np.concatenate([scales, model.layout.sizes])
    scaled = matrix * unit * unit[:, None]
    cross, own = scaled[:n, n:], scaled[n:, n:]
    design_only = scaled[:n, :n] - cross @ np.linalg.lstsq(own, cross.T, rcond=1e-14)[0]
    values, vectors = np.linalg.eigh(0.5 * (design_only + design_only.T))
    is_unseen = values < 1.0 / UNSEEN**2
    unseen, seen = vectors[:, is_unseen].T, vectors[:, ~is_unseen]
    shown = np.sqrt(np.diag((seen / values[~is_unseen]) @ seen.T)) * np.abs(scales)
    sd = np.where((np.abs(unseen) > BELONGS).any(axis=0), np.inf, shown)
    return Identifiability(names, np.array([design.value(name) for name in names]), scales, runs, sd, unseen,
                           *_partners(scaled, unseen, (*names, *model.layout.names), scales))


def _partners(
    scaled: np.ndarray, unseen: np.ndarray, names: tuple[str, ...], scales: Vector
) -> tuple[tuple[str, ...], Vector, Vector]:
    """What each parameter's error goes along with, unseen combinations held."""
    n, held = len(scales), scaled.copy()
    stiff = float(np.abs(np.diag(scaled)[:n]).max())
    held[:n, :n] += stiff * unseen.T @ unseen
    equal = 1.0 / np.sqrt(np.diag(held))
    covariance = np.linalg.inv(held * equal * equal[:, None]) * equal * equal[:, None]
    sd = np.sqrt(np.diag(covariance))
    correlation = (covariance / sd / sd[:, None])[:n]
    # nobody can measure where a walk starts, so it is no partner
    others = np.where([name.startswith("start_") for name in names], 0.0, np.abs(correlation))
    others[range(n), range(n)] = 0.0
    chosen = others.argmax(axis=1)
    r = correlation[range(n), chosen]
    return (tuple(names[other] for other in chosen), r,
            sd[:n] * np.abs(scales) * np.sqrt(np.maximum(0.0, 1.0 - r * r)))  # fmt: skip


def short(name: str) -> str:
    """A parameter's name without its file."""
    return name.partition(".")[2] or name


def listed(words: Sequence[str]) -> str:
    """a, b and c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def is_scale_of_mass(combination: Vector, units: Sequence[str], values: Vector) -> bool:
    """Whether a combination of shares is that of another unit of mass, in which what is zero stays zero."""
    masses = np.array([powers(unit)[0] for unit in units], dtype=float) * (np.asarray(values) != 0.0)
    norm = float(np.linalg.norm(masses) * np.linalg.norm(combination))
    return norm > 0 and abs(float(masses @ combination)) > (1 - EQUAL) * norm


def described(combination: Vector, names: Sequence[str], units: Sequence[str], values: Vector) -> str:
    """A sentence on a combination (n,) of shares of `values` that no measurement shows."""
    parts = combination / float(combination[np.argmax(np.abs(combination))])
    rows = [row for row in np.argsort(-np.abs(parts)) if abs(parts[row]) > max(BELONGS, EQUAL)]
    alike = all(abs(parts[row] - 1) < EQUAL for row in rows)
    words = [short(names[row]) for row in (sorted(rows) if alike else rows)]
    if len(rows) == 1:
        moves = f"{words[0]} may have any value"
    elif alike:
        moves = f"{listed(words)} may all change by one and the same share"
    else:
        shares = [f"{word} by {100 * parts[row]:+.0f} %" for word, row in zip(words, rows, strict=True)]
        moves = f"{listed(shares)} may change together"
    if is_scale_of_mass(combination, units, values):
        return (f"not determined: {moves}. That is the scale of mass, which leaves every acceleration and rate as it "
                "is: weigh the robot (known: total_mass)")
    return f"not determined: {moves}, and the sensors show the same: measure one of them by other means"


#: What the suggested measurements reach: scale and caliper relative, clock against its prior, ramp and hip mass.
WEIGHED, CALIPER_M, CLOCK, STEEPER_DEG, HEAVIER = 1e-3, 1e-4, 0.1, 1.0, 1.5


def weighed(biped: Biped, share: float = WEIGHED) -> Known:
    """The robot on a scale that is right to a share."""
    return Known(TOTAL_MASS, biped.total_mass, share * biped.total_mass, "planned")


def experiments(
    parameters: Parameters, known: tuple[Known, ...], runs: int, names: Sequence[str] = ()
) -> list[tuple[str, Vector, str]]:
    """Suggested measurements in words, with the standard deviations (n,) of `names`, as `planned_equations` has them,
    that `runs` runs and the `known` values have with each; without any where there is no gait to plan with, and why."""
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    length = Known("biped.leg_length", biped.leg_length, CALIPER_M, "planned")
    higher = 0.5 * (biped.leg_length - biped.foot_com)
    steeper, clock = slope.slope_deg + STEEPER_DEG, CLOCK * settings.clock_sd
    share = min((one.sd / one.value for one in known if one.name == TOTAL_MASS), default=10 * WEIGHED) / 10
    surer, longer = replace(settings, clock_sd=clock), replace(settings, planned_steps=2 * settings.planned_steps)
    suggested: list[tuple[str, Parameters, float, tuple[Known, ...], int]] = [
        (f"the robot weighed to {100 * share:.2g} %", parameters, 0.0, (*known, weighed(biped, share)), runs),
        (f"ten times the runs ({10 * runs})", parameters, 0.0, known, 10 * runs),
        (f"leg_length measured to {1e3 * CALIPER_M:g} mm", parameters, 0.0, (*known, length), runs),
        (f"clock known to {clock:g} instead of {settings.clock_sd:g}", replace(parameters, given=surer), 0.0, known,
         runs),
        (f"a ramp of {steeper:g} deg", replace(parameters, slope=replace(slope, slope_deg=steeper)), 0.0, known, runs),
        (f"{100 * (HEAVIER - 1):.0f} % more mass at the hip",
         replace(parameters, biped=replace(biped, hip_mass=HEAVIER * biped.hip_mass)), 0.0, known, runs),
        (f"foot sensor {1e3 * higher:.0f} mm higher on the leg", parameters, higher, known, runs),
        ("walks of twice the steps", replace(parameters, given=longer), 0.0, known, runs),
    ]  # fmt: skip
    found = []
    for what, there, place, given, count in suggested:
        try:
            found.append((what, identifiability(*planned_equations(there, place, names), given, count).sd, ""))
        except (NoGait, StepFailed) as reason:
            found.append((what, np.array([]), str(reason)))
    return found


def gains(sd: Vector, before: Identifiability) -> Vector:
    """By how much standard deviations (n,) shrink to `sd`: 2 is half; infinite for one that is seen now and was not."""
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.asarray(before.sd / sd)
    return np.where(np.isinf(before.sd) & np.isinf(sd), 1.0, ratio)
