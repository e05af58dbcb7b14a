"""Made-up distances from the rigid limit: of round sizes, falling with cost. Nothing in them comes from a model."""

import dataclasses

import numpy as np

from stages.contact_study.result import SEARCHED, Candidates, Distance, HardLimit, RigidLimit
from stages.ground.contact_law import ContactLaw, family_member
from stages.studies.result import COMPLETED


def make_distance(law: ContactLaw, hip: float = 1e-3, cost: int = 100) -> Distance:
    """A set as far as `hip` [m] in x over a step, from parts of which one goes the other way, and between cycles."""
    pair, parts = np.array([hip, 0.1 * hip]), hip * np.array([-2.0, 1.0, 0.1])
    return Distance(
        law=law,
        outcome=COMPLETED,
        evaluations=cost,
        hip_position=pair,
        hip_velocity=5 * pair,
        end_position=-pair,
        position_parts=np.abs(parts),
        velocity_parts=np.abs(5 * parts),
        step_score=hip / 1e-4,
        cycle_outcome=COMPLETED,
        period=-hip,
        step_length=0.5 * hip,
        period_parts=-parts,
        length_parts=0.5 * parts,
        cycle_score=hip / 1e-4,
    )


def make_limit(default: ContactLaw, hip: float, chosen: float) -> RigidLimit:
    """The starting set `hip` [m] from the limit, the chosen one `chosen` [m], and its family in proportion."""
    law = dataclasses.replace(default, contact_stiffness=3e5, stiction_velocity=0.03)
    first, best = make_distance(default, hip, 600), make_distance(law, chosen, 800)
    shares = np.array([2.0, 1.0, 0.5, 0.25])
    family = tuple(make_distance(family_member(law, one), chosen * one, int(800 / one)) for one in shares)
    pair = np.array([2.5e-4, 5e-6])
    hard = HardLimit(pair, 10 * pair, pair, -8e-4, 2e-4, 0.48, 0.16)
    return RigidLimit(hard, first, best, best, 900.0, (best, first), shares, family)


def make_candidates(default: ContactLaw, hip: float) -> Candidates:
    """Three sets: nearer and dearer, then one too dear."""
    sizes, unknown = hip * np.array([1.0, 0.5]), np.full(2, np.nan)
    return Candidates(
        **{key: getattr(default, key) * np.array([1.0, 2.0, 4.0]) for key in SEARCHED},
        outcome=(COMPLETED, COMPLETED, "too dear"),
        hip_position=np.array([[one, 0.1 * one] for one in sizes] + [unknown]),
        hip_velocity=np.array([[5 * one, one] for one in sizes] + [unknown]),
        position_parts=np.array([[2 * one, one, 0.1 * one] for one in sizes] + [np.full(3, np.nan)]),
        velocity_parts=np.array([[10 * one, 5 * one, one] for one in sizes] + [np.full(3, np.nan)]),
        evaluations=np.array([600, 700, 1400]),
        score=np.array([*sizes / 1e-4, np.inf]),
    )
