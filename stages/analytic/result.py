"""What the analytic stage hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.uncertainty import Elasticities, Uncertainty
from stages.analytic.gait.outsole_effect import OutsoleEffect
from stages.analytic.gait.sensitivity import Variation
from stages.analytic.walk.energy import EnergyAudit
from stages.analytic.walk.error_estimate import NumericalError
from stages.analytic.walk.validity import Validity
from stages.analytic.walk.without_impact import WithoutImpact
from stages.biped.accuracy.estimate import ErrorEstimate
from stages.biped.gait import Gait, StanceState
from stages.biped.quantity import quantity
from stages.biped.walk import Walk


@dataclass(frozen=True)
class Result:
    """The constraint model's gait and a walk on it that starts at mid-stance."""

    gait: Gait = quantity("-", "the most stable gait of the design")
    mid_stance: StanceState = quantity("-", "state of that gait with the stance leg upright, single stance")
    residual: float = quantity("1", "how far the fixed point moves in one step, in leg lengths and pendulum times")
    monodromy_matrix: np.ndarray = quantity("1", "derivative of the step map at the fixed point, dimensionless, (j, j)")
    energy: EnergyAudit = quantity("-", "energy audit of one step")
    constraint_drift: np.ndarray = quantity(
        "1", "clearance, normal and slip velocity of the trailing foot at toe-off, dimensionless, shape (3,)")
    variations: tuple[Variation, ...] = quantity("-", "largest multiplier with one design parameter changed")
    elasticities: tuple[Elasticities, ...] = quantity("-", "how the gait answers to each parameter; none on a fold")
    uncertainties: tuple[Uncertainty, ...] = quantity(
        "-", "how far the gait's numbers may be off for the last digits of the parameters; none if all are exact")
    without_impact: WithoutImpact = quantity("-", "the landing foot in double stance if no impact stopped it")
    outsole: OutsoleEffect = quantity("-", "the gait with rubber under the feet")
    validity: Validity = quantity("-", "what the gait asks of the ground")
    walk: Walk = quantity("-", "walk from mid-stance, leg 0 standing")
    numerical_error: NumericalError = quantity("-", "estimated errors of gait and walk")
    errors: tuple[ErrorEstimate, ...] = quantity("-", "errors of gait and walk, where an accuracy was asked for")

    def summary(self) -> str:
        """What was found, in one line."""
        largest = float(np.hypot(*self.gait.floquet_multipliers[0]))
        kind = "stable" if self.gait.stable else "unstable"
        return f"{kind} gait: {self.gait.step_frequency_hz:.3f} Hz, |multiplier| {largest:.3f}"
