"""The pictures of questions and of the package `bipedstudy`, from made-up answers."""

from types import SimpleNamespace

import numpy as np

import bipedstudy
from stages.analytic.maps.answers import Outcome
from stages.analytic.maps.box import Axis, Box
from stages.analytic.pictures import design_map, families, gaits
from stages.calibration.information.identifiability import Identifiability
from stages.calibration.reports import angle_report, identifiability_report
from stages.calibration.reports.sensor_picture import fit_picture
from stages.imu.export import picture
from tests.comparison.made_up import make_walk
from tests.figures.made_up_results import calibration, stability

AXES = (Axis("ground.slope_deg", "deg", 1.0, 4.0, False, 30), Axis("biped.stiffness", "N/m", 1e3, 1e4, True, 20),
        Axis("biped.foot_radius", "m", 0.05, 0.12, False, 5), Axis("biped.leg_inertia", "kg m^2", 1e-4, 2e-3, True, 4))


def design_map_of(count, size=None):
    """A map of so many axes, a grid or `size` scattered designs: some do not walk, some not stably."""
    axes = AXES[:count]
    box = Box(axes, size or int(np.prod([axis.steps for axis in axes])), None if size is None else 1)
    values = box.values(0, box.size)
    shares = box.shares(0, box.size)
    largest = 0.4 + shares.sum(axis=1) / count
    outcome = np.where(shares[:, 0] > 0.9, int(Outcome.NONE), np.where(
        largest < 1, int(Outcome.STABLE), int(Outcome.UNSTABLE)))
    gait = outcome != int(Outcome.NONE)
    columns = {axis.name: column for axis, column in zip(axes, values.T)}
    columns |= {"outcome": outcome, "largest_multiplier": np.where(gait, largest, np.nan),
                "period_s": np.where(gait, 0.5 + 0.05 * shares[:, -1] + 0.02 * shares[:, 0], np.nan)}
    return design_map.draw(box, columns)


def searches(goal_unit="1"):
    """A search over four parameters, and two that end elsewhere."""
    names = ("biped.foot_radius", "biped.foot_com", "biped.stiffness", "biped.damping")
    path = np.linspace([0.083, 0.1, 2800.0, 58.0], [0.1, 0.08, 3300.0, 70.0], 8)
    bounds = {name: (0.8 * value, 1.25 * value) for name, value in zip(names, path[0])}
    made = [SimpleNamespace(history=tuple(0.64 - 0.03 * (row + start) for row in range(8)), path=path)
            for start in range(3)]
    goal = SimpleNamespace(title="largest multiplier", unit=goal_unit)
    return gaits.draw_searches(made, bounds, goal)


def elasticities():
    """A gait with as many parameters as one in detail has, and a pair of multipliers."""
    names = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
             "biped.stiffness", "biped.damping", "biped.leg_inertia", "ground.slope_deg", "ground.gravity")
    shares = np.linspace(-1.0, 1.0, len(names))
    changes = SimpleNamespace(names=names, values=np.ones(len(names)))
    measures = ("period_s", "step_length_m", "speed_m_s", "step_frequency_hz")
    tangents = SimpleNamespace(changes=changes, elasticities=lambda: dict.fromkeys(measures, shares))
    pair = SimpleNamespace(values=np.array([-0.62 + 0.21j, -0.62 - 0.21j]),
                           elasticities=lambda: np.array([shares, np.where(shares > 0, np.nan, shares)]))
    return gaits.draw_elasticities(tangents, pair)


def run_of_sensors(stamp=True):
    """A run with phone stamps or with none but the sensors' own, and a verdict of many words."""
    time = np.arange(0.0, 8.0, 0.01)
    stamps = time + 0.03 + 0.002 * np.sin(9 * time)
    empty = np.full(len(time), np.nan)
    recording = SimpleNamespace(rows=len(time), phone_stamp=stamps if stamp else empty, server_stamp=empty,
                                device_stamp=empty)
    indexed = SimpleNamespace(recording=recording, index=np.arange(len(time)), segment=np.zeros(len(time), dtype=int),
                              batch_size=1, resets=0)
    motion = np.column_stack([np.sin(6 * time), 9.8 + np.cos(6 * time), 0 * time])
    sensor = SimpleNamespace(time=time, trace=SimpleNamespace(indexed=indexed), force=motion, rate=motion)
    words = tuple(f"the foot's stamps of packet {number} are late against those of the hip by more than they may be"
                  for number in range(4))
    return picture(SimpleNamespace(
        experiment=SimpleNamespace(name="2026-03-04_treadmill_long_name_of_a_run_007", origin="measured"),
        sensors={"hip": sensor, "foot": sensor},
        strikes=SimpleNamespace(time=np.arange(0.4, 8.0, 0.5), leg=np.arange(16) % 2),
        leg=SimpleNamespace(time=time, angle=0.3 * np.sin(6 * time), angle_error=0.01),
        verdict=SimpleNamespace(outcome="used with remarks",
                                sentences=lambda refused: () if refused else words)))


def saved(draw):
    """The one figure that a question saves."""
    kept = []
    draw(kept.append)
    return kept[0]


def residual_angles():
    """Encoders' residuals of steps that were not fitted."""
    wave = np.sin(np.linspace(0, 6, 60))
    residuals = {number: 2e-3 * np.column_stack([wave, wave]) * number for number in range(1, 6)}
    return saved(lambda save: angle_report._draw(
        SimpleNamespace(found=SimpleNamespace(residuals=residuals, steps=5)), save))


def standard_deviations():
    """What runs tell of eight parameters, and what further measurements would."""
    names = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
             "biped.stiffness", "biped.damping", "biped.leg_inertia")
    ones = np.ones(len(names))
    single, found = (Identifiability(names, ones, ones, runs, share * ones, np.zeros((0, 8)), (), ones, ones)
                     for runs, share in ((1, 0.05), (30, 0.01)))
    tried = [(f"a measurement of {name} by itself, to a share of a thousandth", 5e-3 * ones, "")
             for name in names[:6]]
    return saved(lambda save: identifiability_report._draw(found, single, tried, save))


def fit_of(side="fit"):
    """A fitted run."""
    fit = calibration().fits[0]
    return fit_picture({"hip": fit.hip, "foot": fit.foot}, fit.strikes, side)


#: Names of pictures, and what draws them.
PICTURES = {
    "map --figure, one axis": lambda: design_map_of(1),
    "map --figure, two axes": lambda: design_map_of(2),
    "map --figure, two axes, scattered": lambda: design_map_of(2, 300),
    "map --figure, three axes": lambda: design_map_of(3),
    "map --figure, three axes, scattered": lambda: design_map_of(3, 2000),
    "map --figure, four axes": lambda: design_map_of(4),
    "design --figure": searches,
    "sensitivity --figure": elasticities,
    "continue --figure": lambda: families.draw_families(stability().families, "slope [°]"),
    "basin --figure": lambda: families.draw_basin(stability().basin),
    "ingest --figure": run_of_sensors,
    "ingest --figure, no stamps": lambda: run_of_sensors(stamp=False),
    "calibrate --figure": fit_of,
    "calibrate --figure, angles": residual_angles,
    "calibrate --figure, plan": standard_deviations,
    "bs.plot": lambda: bipedstudy.plot(make_walk()),
    "bs.plot, six signals": lambda: bipedstudy.plot(
        make_walk(), "hip_position", "hip_velocity", "leg_angle", "ground_reaction", "hip_specific_force",
        "hip_angular_velocity"),
}
