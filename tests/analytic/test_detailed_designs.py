"""Designs drawn over frames, legs that differ and the hip: each has a right answer, or a sentence why none."""

from __future__ import annotations

import time

import numpy as np
import pytest

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point
from stages.biped.quantity import faults
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, changed

LONGEST_S = 60.0  # of computing, whatever else the machine does


def drawn(number):
    """A design with some of the details, each from far too small to matter to too large to walk, and its friction."""
    rng = np.random.default_rng(number)

    def size(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def either(value):
        return float(value * rng.choice([-1, 1]))

    values = {"legs": str(rng.choice(["compliant", "rigid"])), "leg_inertia": size(1e-6, 1e-3)}
    if rng.random() < 0.6:
        values |= {"frame_mass": size(1e-4, 0.2), "frame_com": either(size(1e-3, 0.1)),
                   "frame_offset": either(size(1e-5, 0.01)), "frame_inertia": size(1e-7, 1e-3)}  # fmt: skip
    if rng.random() < 0.5:
        values["foot_offset"] = either(size(1e-5, 0.01))
    if rng.random() < 0.5:
        values |= {"hip_stiffness": size(1e-3, 1.0), "hip_damping": size(1e-5, 1e-2)}
        values["hip_rest_angle"] = either(size(1e-4, 0.1)) if rng.random() < 0.5 else 0.0
    if rng.random() < 0.3:
        values["hip_gravity_mass"] = 0.316 - size(1e-3, 0.3)
    for key in ("leg_length", "foot_radius", "foot_com", "foot_mass", "stiffness", "damping"):
        if rng.random() < 0.3:
            values[f"other_{key}"] = getattr(TABLE_1, key) * (1 + either(size(1e-5, 0.03)))
    ground = FRICTION if rng.random() < 0.3 else None
    if values["legs"] == "rigid" and rng.random() < 0.5:
        values["hip_friction"] = size(1e-5, 0.1)
    return changed(TABLE_1, **values), ground


def answer_of(number):
    """How the design is answered: "gait", or the kind of sentence; raises where the answer is wrong."""
    biped, friction = drawn(number)
    assert not list(faults(biped))
    started = time.process_time()
    try:
        walker, point = find_gait(biped, SLOPE, 1e-8, friction)
    except NoGait as reason:
        assert len(str(reason)) > 20 and time.process_time() - started < LONGEST_S
        return "none"
    assert time.process_time() - started < LONGEST_S
    exact = fixed_point(walker, point.z, 1e-12)
    assert exact is not None and abs(exact.period - point.period) < 1e-5 and exact.residual < 1e-8
    assert len(point.steps) == (2 if walker.alternates else 1)
    mirrored, there = biped.exchanged, None
    other, there = (walker, exact) if mirrored == biped else find_gait(mirrored, SLOPE, 1e-12, friction)
    same = abs(there.period * other.time - exact.period * walker.time) < 1e-7
    several = not same and fixed_point(other, there.z, 1e-12) is not None  # another of several gaits
    assert same or several
    try:
        report = report_gait(walker, exact, 1e-12, 1.1)
    except StepFailed:
        return "gait at an edge"
    assert abs(report.energy.residual) < 1e-6
    return "gait" if same else "several gaits"


def answers(numbers):
    found = [answer_of(number) for number in numbers]
    return {kind: found.count(kind) for kind in sorted(set(found))}


def test_some_drawn_designs_are_answered():
    found = answers(range(8))
    assert found.get("gait", 0) >= 1 and sum(found.values()) == 8


@pytest.mark.slow
def test_two_hundred_drawn_designs_are_answered():
    found = answers(range(200))
    print(found)
    assert found["gait"] >= 60 and found["none"] >= 5
