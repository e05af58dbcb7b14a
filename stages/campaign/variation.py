"""How the runs of the synthetic campaign differ: the push, the ramp, the outsole, the built machine."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from stages.biped.gait import StanceState
from stages.campaign.parameters import RunSettings
from stages.ground.slope import Slope
from stages.twin.machine.machine import Build


@dataclass(frozen=True)
class Variation:
    """What is different in one run.

    Factors on the rates of stance and swing leg at the start, the true and the read inclination [deg], the angle of
    the still stand from the slope normal [rad], and the machine's departure from its drawing.
    """

    stance_push: float
    swing_push: float
    slope_deg: float
    slope_read_deg: float
    stand_angle: float
    build: Build

    def start(self, state: StanceState) -> StanceState:
        """The state in which the hand lets go."""
        return dataclasses.replace(
            state, stance_rate=state.stance_rate * self.stance_push, swing_rate=state.swing_rate * self.swing_push
        )


def generator(seed: int, run: int, stream: int) -> np.random.Generator:
    """Random numbers of one stream of one run, independent of the order in which runs are computed."""
    return np.random.default_rng([seed, run, stream])


def draw_variation(settings: RunSettings, slope: Slope, rng: np.random.Generator) -> Variation:
    """One draw of everything that differs."""
    tolerance = settings.tolerance_sd
    true_slope = slope.slope_deg + settings.slope_sd_deg * rng.normal()
    return Variation(
        stance_push=1 + settings.push_sd * rng.normal(),
        swing_push=1 + settings.push_sd * rng.normal(),
        slope_deg=true_slope,
        slope_read_deg=round(true_slope + settings.slope_reading_sd_deg * rng.normal(), 2),
        stand_angle=np.deg2rad(settings.stance_sd_deg) * rng.normal(),
        build=Build(
            body_mass=tuple(1 + tolerance * rng.normal(size=6)),
            stiffness=tuple(1 + tolerance * rng.normal(size=4)),
            damping=tuple(1 + tolerance * rng.normal(size=4)),
            leg_length=tuple(settings.length_sd * rng.normal(size=4)),
            outsole=max(0.0, settings.outsole + settings.outsole_sd * rng.normal()),
        ),
    )
