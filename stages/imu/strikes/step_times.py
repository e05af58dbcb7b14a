"""Step, stance and swing of each leg in time, and how far the legs differ, each with a standard error."""

import math
from dataclasses import dataclass

import numpy as np

from stages.imu.parameters import Drawing
from stages.imu.result import StepTimes

INNER, OUTER = 0, 1


@dataclass(frozen=True)
class HeelStrikes:
    """Times (s,) [s] of heel strikes and the leg (s,) that lands: 0 the inner one, 1 the outer one."""

    time: np.ndarray
    leg: np.ndarray


def stride_bounds(strikes: HeelStrikes, skipped: int = 0) -> np.ndarray:
    """Start and end (k, 2) [s] of every whole stride after the first `skipped` strikes.

    A stride with a strike missing inside (longer than 1.5 times the median) is left out.
    """
    inner = strikes.time[skipped:][strikes.leg[skipped:] == INNER]
    bounds = np.column_stack((inner[:-1], inner[1:]))
    if not len(bounds):
        return bounds
    length = bounds[:, 1] - bounds[:, 0]
    return np.asarray(bounds[np.abs(length / np.median(length) - 1) < 0.5])


def stances_of(strikes: HeelStrikes) -> tuple[np.ndarray, np.ndarray]:
    """Landings of the inner leg and the outer leg's that follow, each (k,) [s], none with a strike missing inside."""
    pairs = (strikes.leg[:-1] == INNER) & (strikes.leg[1:] == OUTER) if len(strikes.time) > 1 else np.zeros(0, bool)
    start, end = strikes.time[:-1][pairs], strikes.time[1:][pairs]
    usual = np.median(end - start) if len(start) else 0.0
    whole = np.abs(end - start - usual) <= 0.5 * usual
    return start[whole], end[whole]


NAN = math.nan
FEWEST_USED = 4  # heel strikes, of which a step frequency is found
#: By how much more the onset is off where no foot is seen to be let go: stiff legs rebound, unlike the blow of the fit.
#: Steps of 144 runs (nine robots of 0.15 to 1.2 m, rigid or 3 to 10 times as stiff as Table 1's) are off by 1.3 ms rms.
STIFF = 1.5
#: What toe-off is off by of a double stance: the longer it is the more gently the foot is let go.
GENTLE = 0.07
UNKNOWN = StepTimes(*(NAN,) * 15)


def step_times(strikes: HeelStrikes, double_stance: float, drawing: Drawing) -> StepTimes:
    """Times by leg from strikes and from how long after the outer leg's the inner foot is let go [s], NaN if unknown.

    A leg's strikes share one error, that of their onset, and scatter each; toe-off has an error of its own.
    """
    onset = drawing.onset_error_s * (1.0 if double_stance > 0 else STIFF)
    (inner, fewest), (outer, others) = (_mean_step(strikes, leg) for leg in (INNER, OUTER))
    scatter = drawing.strike_scatter_s / math.sqrt(max(min(fewest, others), 1))
    step = math.sqrt(2) * math.hypot(onset, scatter)
    known = math.hypot(onset, drawing.toe_off_error_s, scatter, GENTLE * double_stance) if double_stance > 0 else NAN
    other = math.hypot(known, double_stance)
    stances = outer + double_stance, inner + double_stance
    # What is taken out of one step is in the other: their difference is off by twice the error of one.
    return StepTimes(
        inner_step=inner,
        outer_step=outer,
        step_error=step,
        double_stance=double_stance,
        double_stance_error=known,
        inner_stance=stances[0],
        inner_swing=inner - double_stance,
        inner_error=known,
        outer_stance=stances[1],
        outer_swing=outer - double_stance,
        outer_error=other,
        asymmetry=_over_mean(inner - outer, inner, outer),
        asymmetry_error=_over_mean(2 * step, inner, outer),
        stance_asymmetry=_over_mean(stances[0] - stances[1], *stances),
        stance_asymmetry_error=_over_mean(math.hypot(2 * step, other), *stances),
    )


def _over_mean(value: float, first: float, second: float) -> float:
    return value / (0.5 * (first + second)) if first + second > 0 else NAN


def _mean_step(strikes: HeelStrikes, leg: int) -> tuple[float, int]:
    """Mean duration of the steps that end with this leg's landing [s], and how many there are.

    A step with a strike missing inside is left out.
    """
    step = np.diff(strikes.time)
    whole = step < 1.5 * np.median(step) if len(step) else np.zeros(0, dtype=bool)
    mine = step[whole & (strikes.leg[1:] == leg)]
    return (float(mine.mean()) if len(mine) else NAN), len(mine)


def step_frequency(strikes: HeelStrikes, scatter_s: float = 0.0, clock_rate_error: float = 0.0) -> tuple[float, float]:
    """Steps per second and its standard error [Hz], from a straight line through the strike times.

    Each leg has an offset of its own. Strikes are numbered by whole steps, so a missed one is no long step. A strike is
    off by `scatter_s` at least, even where a line fits better: after the push its error changes along the walk. All are
    dated by a clock whose rate has this relative error.
    """
    step = np.diff(strikes.time)
    if len(strikes.time) < FEWEST_USED or not np.median(step) > 0:  # pulses of one and the same time are no walk
        return NAN, NAN
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(step / np.median(step)))))
    columns = np.column_stack((np.ones(len(number)), number, strikes.leg))
    if len(set(strikes.leg.tolist())) == 1:
        columns = columns[:, :2]
    solution, _, _, _ = np.linalg.lstsq(columns, strikes.time, rcond=None)
    residual = strikes.time - columns @ solution
    variance = max(residual @ residual / max(1, len(number) - columns.shape[1]), scatter_s**2)
    period_error = np.sqrt(variance * np.linalg.pinv(columns.T @ columns)[1, 1])
    return 1 / solution[1], math.hypot(period_error / solution[1], clock_rate_error) / solution[1]
