"""A made-up result of every stage that figures show: nothing in it changes when the models do."""

from functools import cache
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

from stages.analytic.result import Basin, RecordedFamily, Turn
from stages.biped.accuracy.tolerances import Level
from stages.biped.design import Biped
from stages.calibrated_twin.result import Check, Number, Pair, Robot
from stages.calibration.result import FittedRun, Followed, HeldOut, Trace
from stages.comparison.agreement import HipDifference
from stages.comparison.stride import last_stride
from stages.drawing import style
from stages.extremes.result import Result as Extremes
from stages.figures.drawn import figure, given_to
from stages.figures.parameters import Settings
from stages.ground.blocks import Blocks
from stages.model_error.measures import NAMES
from stages.model_error.result import Result as ModelError
from stages.rough_ground.result import MODELS, DesignNorm, OnHeight, Reached, Result as RoughGround
from stages.stability.result import Result as Stability
from stages.studies.result import COMPLETED
from stages.tradeoff.result import Errors, Reference, Result as Tradeoff, Row
from stages.twin.machine.parts import Part
from stages.twin.result import Settling
from stages.twin_ladder.result import Result as Ladder, RungGait, SameMachine
from stages.twin_pushes.result import PushedWalk, Result as Pushes
from tests.comparison.made_up import DEFAULTS, make_agreement, make_budget, make_study, make_walk, scaled


def analytic(frequency=2.0718):
    """A walk, and a gait that is not that of the walk."""
    gait = SimpleNamespace(period_s=0.5, step_frequency_hz=frequency, step_length_m=0.16, double_stance_s=4e-3,
                           floquet_multipliers=np.array([[0.6, 0.0], [-0.3, 0.4]]),
                           largest_multiplier=0.6, steps=1)  # fmt: skip
    answers = tuple(
        SimpleNamespace(parameter=name, value=1.0, period=-share, step_length=0.5 * share, speed=1.5 * share)
        for name, share in (("biped.hip_mass", 0.1), ("ground.slope_deg", -0.4))
    )
    limp = SimpleNamespace(feet_apart_m=np.full(2, 0.115))
    return SimpleNamespace(walk=make_walk(), gait=gait, elasticities=answers, limp=limp)


def multibody():
    """A walk a little slower, and a cycle that is not that of the walk."""
    cycle = SimpleNamespace(
        step_frequency_hz=2.0, step_length_m=0.161, peak_normal_force=768.0, largest_penetration=3.1e-5,
        double_stance_s=5e-3, speed_m_s=0.33, period_s=0.5, floquet_multipliers=np.array([[0.62, 0.0], [-0.2, 0.3]]),
    )  # fmt: skip
    return SimpleNamespace(walk=make_walk(period=0.51), cycle=cycle, unsettled="")


def twin():
    """The walk of the multibody model."""
    settling = Settling(np.zeros(0), np.zeros(0), 1, 1 / 2.04, 2.04, 0.159, period_transient_s=1e-4)
    walk = make_walk(period=0.51)
    return SimpleNamespace(walk=walk, settling=settling, outcome="completed", steps=8)


def ladder():
    """Three made-up rungs, the second without a gait, the first without motion out of the plane."""
    multipliers, none, unknown = np.array([[-0.7, 0.0], [0.5, 0.1]]), np.zeros((0, 2)), float("nan")
    nothing = np.zeros(2)
    return Ladder(
        0.48,
        0.16,
        (
            RungGait("first", COMPLETED, 0.49, 0.161, 0.0, "more", False, multipliers, none, 1e-6, 800.0, 20),
            RungGait("second", "fell", unknown, unknown, unknown, "more", False, none, none, unknown, unknown, 0),
            RungGait("third", COMPLETED, 0.47, 0.165, 0.0, "more", True, multipliers, multipliers, 1e-6, 800.0, 20),
        ),
        0.47,
        0.165,
        (
            SameMachine("first", COMPLETED, 0.492, 0.1605, 0.0, multipliers + 0.03, nothing, nothing),
            SameMachine("second", "fell", unknown, unknown, unknown, none, nothing, nothing),
            SameMachine("third", COMPLETED, 0.4725, 0.1643, 0.0, multipliers + 0.03, nothing, nothing),
        ),
    )


def pushes():
    """A push that is walked off, one that is not, and one of another kind."""
    time = np.linspace(0.0, 2.0, 50)

    def walk(kind, size, outcome):
        reason = "" if outcome == "completed" else "fell in step 2"
        return PushedWalk(kind, "m/s", size, outcome, reason, 4, time, np.sin(time), size * time, time, 0.1, 0.2)

    return Pushes((walk("side", 0.1, "completed"), walk("side", 0.2, "fell"), walk("spin", 1.0, "fell")))


def ways():
    """Two made-up ways of one model: errors fall with cost; one has no multiplier and one does not walk."""
    nan = float("nan")

    def row(way, mark, error, cost, outcome="completed"):
        errors = Errors(error, error, nan if way == "coarse" else error, 1e3 * error)
        return Row("model", way, f"cost {cost}", mark, outcome, errors, cost, nan, nan)

    small = Errors(1e-12, 1e-12, 1e-12, 1e-12)
    reference = Reference("model", "fine", 0.48, 0.64, 500.0, "second", small, "other", small)
    fine = [row("fine", "", error, cost) for error, cost in ((3e-4, 120.0), (1e-5, 160.0), (1e-6, 200.0),
                                                             (1e-7, 300.0), (1e-8, 350.0))]  # fmt: skip
    coarse = [row("coarse", "", error, cost) for error, cost in ((1e-3, 100.0), (1e-4, 300.0), (4e-5, 600.0))]
    rows = (row("fine", "default", 1e-9, 400.0), *fine, row("coarse", "paper", 1e-5, 900.0), *coarse,
            row("coarse", "", nan, nan, "fell"))  # fmt: skip
    return Tradeoff(4, (reference,), rows)


def misses():
    """Made-up errors of four models: the dearer, the smaller; the last one's is its solver's alone."""
    none = np.zeros((4, 12, len(NAMES)))
    of_each = np.array([[[1e-8, -0.01, 0.04], [1e-8, -0.01, 0.003], [2e-7, 0.0, 5e-6], [1e-7, 0.0, 0.0]]])
    left = of_each.repeat(len(NAMES), axis=0).swapaxes(0, 1)
    return ModelError(1, "made up", np.ones((12, 3)), none, none, left, ())


def extreme_points():
    """Every status once, on two made-up axes, one of them with a zero, and two draws."""
    status = ("right", "inaccurate", "refused", "failed", "unconfirmed", "wrong", "crashed", "hung", "right", "failed")
    count, none = len(status), ("",) * len(status)
    axis = ("ground.gravity",) * 4 + ("biped.damping",) * 4 + ("all together",) * 2
    value, number = np.array([1.0, 2.0, 3.0, 4.0, 0.0, 1.0, 10.0, 1e5, 0.0, 1.0]), np.full(count, 1e-6)
    return Extremes("full", ("tree",) * count, axis, value, none, status, number, number, none, none)


def rough_ground():
    """Walks that end sooner on higher blocks, none on the least; a norm that a larger foot lowers, and one unknown."""
    rows = tuple(
        OnHeight(mean, low, high, "counted", 30, 1000, 10, np.exp(-10 / mean), 0.5 * np.exp(-10 / mean), 1.0, model,
                 height)
        for model in MODELS for height, mean, low, high in (
            (2.5e-4, np.inf, 270.0, np.inf), (5e-4, 60.0, 40.0, 100.0), (1e-3, 8.0, 6.0, 11.0))
    )  # fmt: skip
    norms = tuple(DesignNorm(name, share, np.nan if share * slope > 1.3 else 72.0 / share**slope)
                  for name, slope in (("biped.foot_radius", 1.0), ("biped.hip_mass", 1.2))
                  for share in (0.8, 1.0, 1.25))  # fmt: skip
    front = tuple(Reached(mean, low, high, "counted", 30, 1000, 10, 0.9, 0.8, 1.0, 5e-4, share,
                          0.33 * (1 + share), norm, "speed, biped.hip_mass lower", True)
                  for share, mean, low, high, norm in (
                      (0.0, 50.0, 40.0, 65.0, 60.0), (0.25, np.inf, 300.0, np.inf, 30.0)))  # fmt: skip
    return RoughGround(rows, norms, 72.0, front)


def stability():
    """A gait that doubles its period once and turns back once, and a basin with every ending."""
    slope = np.linspace(1.0, 4.0, 13)
    angle = 0.2 + 0.03 * slope
    real = np.stack([-0.3 * slope, 0.2 * slope], axis=1)
    multipliers = np.stack([real, 0.0 * real], axis=-1)
    turns = (Turn("period doubling", 10.0 / 3.0, -1.0, np.array([0.5]), np.array([0.3])),
             Turn("turning point", 1.0, 1.0, np.array([0.46]), np.array([0.23])))  # fmt: skip
    one = RecordedFamily(1, "here; there", slope, (0.45 + 0.015 * slope)[:, None], angle[:, None],
                         angle[:, None] / 100, multipliers, turns)  # fmt: skip
    late = np.linspace(10.0 / 3.0, 4.0, 6)
    apart = 0.03 * np.sqrt(late - late[0])
    forks = np.stack([0.5 + apart, 0.5 - apart], axis=1)
    two = RecordedFamily(2, "there", late, forks, 0.6 * forks, np.maximum(0.51 - forks, 0.0),
                         0.3 * multipliers[:6], ())  # fmt: skip
    ending = np.arange(42).reshape(6, 7) % 7
    basin = Basin(np.linspace(0.1, 0.5, 6), np.linspace(1.0, 4.0, 7), ending + 1, np.where(ending == 0, 0, -1), ending,
                  0.26, 2.3, 30, 1e-3)  # fmt: skip
    basin.steps[0, 0] = 5
    return Stability(2.0, (one, two), basin)


def imu():
    """One run of seven strides, each a little larger than the last, of sensors that lie differently."""
    signals = last_stride(make_walk(), 101).signals
    turned, over = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]), np.diag([1.0, -1.0, -1.0])
    run = SimpleNamespace(strides=np.stack([signals * (1 + 0.01 * i) for i in range(-3, 4)]),
                          hip=SimpleNamespace(rotation=turned), foot=SimpleNamespace(rotation=over),
                          heel_strike_time=np.arange(8.0))  # fmt: skip
    report = SimpleNamespace(rate_hz=99.9, lost_packets=3, batch_size=3, rows=1000, clock_error_s=2e-3)
    return SimpleNamespace(runs=(run,), rejected=(), reports=(report, report), origin="synthetic", step_frequency=2.0)


def calibration():
    """A run of three steps that is fitted nearly, with a spike at each heel strike that does not count."""
    time = np.linspace(0.1, 1.45, 136)
    clean = np.column_stack([np.sin(9 * time), 9.8 + np.cos(9 * time), 2 * np.sin(6 * time)])
    at_impact = np.abs(time % 0.5) < 0.03
    measured = clean + 0.02 * np.sin(70 * time)[:, None] + 8.0 * at_impact[:, None]
    residual = np.where(at_impact[:, None], np.nan, measured - clean)
    nothing = np.zeros(2)
    fit = FittedRun("run 01", "with outsole", nothing, nothing, nothing, np.eye(2), nothing, 1.4, 2.0, 30, True, "",
                    Trace(time, measured, clean, residual), Trace(time, 1.1 * measured, 1.1 * clean, 1.1 * residual),
                    np.array([0.0, 0.5, 1.0, 1.5]))
    held = HeldOut("run 02", "with outsole", 0.15, 1.6, 0.02, 1.5e-3, 0.2, 0.03, 0.012, 8e-4, nothing, nothing,
                   fit.hip, fit.foot, fit.strikes)
    angle = 0.3 * np.sin(6.3 * time)
    strikes = fit.strikes[np.minimum(np.searchsorted(fit.strikes, time), 3)]
    followed = Followed("run 01", time, angle + 2e-3 * np.sin(20 * time), 2e-3 + 0.0 * time,
                        strikes + 1e-3 * np.cos(15 * time), 1e-3 + 0.0 * time,
                        np.column_stack([0.16 + 0.0 * time, 5e-4 + 0.0 * time]), fit.strikes, time, angle)
    return SimpleNamespace(fits=(fit,), held_out=(held,), not_seen=("not seen: the scale of mass",),
                           followed=(followed,))  # fmt: skip


def calibrated_twin():
    """Two robots of three numbers, a pair, a run that was held out, and a walk."""
    def robot(kind, more):
        numbers = tuple(
            Number(name, unit, value, 1.04 * value + more, 1.015 * value + more, 1.01 * value + more,
                   0.004 * value, value + more)
            for name, unit, value in (("biped.foot_mass", "kg", 0.335), ("biped.leg_length", "m", 0.333),
                                      ("biped.leg_inertia", "kg m^2", 8.6e-4)))
        correlations = np.array([[1.0, 0.5, -0.9], [0.5, 1.0, 0.2], [-0.9, 0.2, 1.0]])
        return Robot(kind, 2, 1, 6, numbers, correlations, np.zeros((1, 3)), 2.04, 1e-3, 2.041)

    pair = Pair("run 01", 2.1e-3, 2e-4, 2e-3, 9e-3, -8e-3, 1e-3, -8.5e-3)
    check = Check("run 02", "with outsole", "corrected by the twin", 2e-3, 0.1, 0.02)
    return SimpleNamespace(robots=(robot("with outsole", 2e-5), robot("without outsole", 0.0)), pairs=(pair,),
                           checks=(check,), walk=make_walk(period=0.49))


def comparison(origin="synthetic", verdict="holds"):
    """Agreement of runs of that origin, and differences of the hips within the paper's."""
    same_start = HipDifference(np.array([1.9e-4, 4e-5]), np.array([3.8e-3, 3.9e-3]))
    claims = (SimpleNamespace(id="hip_displacement", verdict=verdict),)
    return SimpleNamespace(models=SimpleNamespace(same_start=same_start), measurement=make_agreement(origin),
                           claims=claims)


class Drawn(SimpleNamespace):
    """Settings of the twin whose parts are those of the design."""

    def bill(self, biped):
        """The parts as they are."""
        return self.parts

    def bill_rule(self, biped):
        """Nothing was changed."""
        return ""

    def arc(self, radius):
        """Of every foot."""
        return self.outsole_arc

    def foot_sensor(self, foot_com):
        """Where the socket is."""
        return self.foot_socket


def machine(outsole=0.0):
    """Lanes of the twin, and a bill with every shape once, a point among them, on three of the groups."""
    parts = (
        Part("shaft", "inner_frame", "steel", "cylinder", "z", (0.005, 0.2), 0.1, (0.0, 0.0, 0.0), 1),
        Part("leg", "outer_frame", "ABS", "box", "z", (0.014, 0.2, 0.016), 0.1, (0.0, -0.1, 0.085), 2),
        Part("spring", "inner_foot", "steel", "tube", "y", (0.006, 0.0045, 0.04), 0.1, (0.0, -0.2, 0.04), 2),
        Part("foot", "inner_foot", "ABS", "arc", "z", (0.083, 0.012, 0.02, 0.11), 0.1, (0.0, -0.25, 0.04), 2),
        Part("lead", "inner_foot", "steel", "point", "z", (), 0.1, (0.0, -0.25, 0.04), 2),
        Part("bearing", "outer_frame", "steel", "tube", "z", (0.0085, 0.005, 0.02), 0.1, (0.0, 0.0, 0.085), 2),
        Part("outer foot", "outer_foot", "rubber", "arc", "z", (0.083, 0.012, 0.02, 0.11), 0.1, (0.0, -0.25, 0.085), 2),
    )
    return Drawn(
        parts=parts, inertia="parts", inner_lane=0.04, outer_lane=0.085, foot_width=0.02, outsole=outsole,
        outsole_arc=0.112,
        ramp_length=2.0, expected_step=0.0, scene="ramp",
        hip_socket=(0.0, 0.0, 0.0), foot_socket=(0.0, -0.233, 0.04),
    )  # fmt: skip


def parameters(level="paper"):
    """A design on a slope of 2 degrees, and pictures of few pixels."""
    return SimpleNamespace(
        biped=Biped(legs="compliant", hip_mass=0.3, foot_mass=0.3, leg_length=0.333, foot_radius=0.083, foot_com=0.1,
                    stiffness=2800.0, damping=58.35, leg_inertia=0.0),
        twin=machine(),
        slope=SimpleNamespace(angle=np.radians(2), gravity=9.81), contact=DEFAULTS, blocks=Blocks(),
        settings=Settings(3e-4, 5e-3, 101, 80, True), level=Level(level),
    )  # fmt: skip


@cache
def usual():
    """All of them by the stages' names, made once: figures change nothing in what they are given."""
    made_up = {
        "analytic": analytic, "multibody": multibody, "contact_study": make_study, "error_budget": make_budget,
        "twin": twin, "twin_ladder": ladder, "twin_pushes": pushes, "tradeoff": ways, "extremes": extreme_points,
        "imu": imu, "comparison": comparison, "calibration": calibration, "calibrated_twin": calibrated_twin,
        "stability": stability, "model_error": misses, "rough_ground": rough_ground,
    }  # fmt: skip
    return {name: make() for name, make in made_up.items()}


def results(**other):
    """All of them by the stages' names, `other` ones in their place."""
    return usual() | other


def given(name, factor=1.0, **other):
    """What the figure `name` is given of the made-up results, all numbers times a factor."""
    return scaled(given_to(name, parameters(), results(**other)), factor)


def drawn(name, factor=1.0, **other):
    """The figure `name` of the made-up results."""
    return figure(name).draw(given(name, factor, **other))


@cache
def shown(name):
    """The same, drawn once for all tests that only look at it."""
    with style.drawing():
        picture = drawn(name)
        plt.close(picture)
        FigureCanvasAgg(picture)  # Matplotlib 3.11 takes it from what is closed, and measures each text twice without
    return picture
