"""What sensors should show: against the study's own walk behind a filter step by step, and against differences."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfilt_zi

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.phases.motion import SINGLE_STANCE
from stages.analytic.walk.recording import record
from stages.analytic.walk.sampling import sample_walk
from stages.calibration.information.identifiability import free_names
from stages.calibration.observation import stretches
from stages.calibration.observation.measured_run import mid_stance
from stages.calibration.observation.prediction import predict
from stages.calibration.observation.signals import LowPass, Piece
from tests.analytic.differences import extrapolated
from tests.calibration.runs import DESIGN, disturbed, gait

#: A little longer on the other leg, with frames, and the plain one with legs that may differ.
UNLIKE = DesignPoint(
    dataclasses.replace(DESIGN.biped, other_leg_length=0.3331, frame_mass=0.02, frame_com=0.05), DESIGN.slope)
NAMES = (*free_names(DESIGN), "biped.other_leg_length")


@pytest.mark.parametrize("foot_hz", [40.0, 70.0])
def test_a_sensor_without_errors_shows_the_walk_behind_its_low_pass(foot_hz):
    """In smooth motion: what an impact adds to a filter is its impulse, which a sampled walk does not have."""
    layout, unknowns, sampling = disturbed(3, 1.9)
    sampling = dataclasses.replace(sampling, first_leg=0, bandwidth_hz={"hip": 40.0, "foot": foot_hz})
    unknowns[7:] = 0.0
    walker, point = gait()
    begin, _ = mid_stance(walker, point.z, 1e-10)
    unknowns[:7] = layout.middle[:7]
    since = layout.middle[layout.place("mid_stance")]
    sampling = dataclasses.replace(sampling, hip=sampling.hip - since, foot=sampling.foot - since)
    found = predict(DESIGN, (), unknowns, layout, sampling, 1e-10)
    y = np.concatenate([[0.0], begin])
    rate = 50_000.0
    walk = sample_walk(walker, record(walker, y, 1, 1e-10, SINGLE_STANCE), rate)
    first_strike = found.strikes[0, 0]
    for side in ("hip", "foot"):
        signals = np.column_stack([getattr(walk, f"{side}_specific_force"), getattr(walk, f"{side}_angular_velocity")])
        sections = butter(2, sampling.bandwidth_hz[side], fs=rate, output="sos")
        state = sosfilt_zi(sections)[:, :, None] * signals[0]
        smooth = sosfilt(sections, signals, axis=0, zi=state)[0]
        times = getattr(sampling, side) + sampling.late[side]
        seen = (times > 0.05) & (times < first_strike)
        expected = np.column_stack([np.interp(times[seen], walk.time, axis) for axis in smooth.T])
        assert seen.sum() > 8
        np.testing.assert_allclose(found.samples[side][seen, :, 0], expected, atol=2e-3 * np.abs(expected).max())


@pytest.fixture(scope="module")
def derived(request):
    """A design, a run off its gait and what its sensors should show, with derivatives by everything."""
    layout, unknowns, sampling = disturbed(1, 2.5)
    alike = request.param == "alike"
    drawn = DESIGN.with_value("biped.other_leg_length", 0.333) if alike else UNLIKE
    sampling = sampling if alike else dataclasses.replace(sampling, below_hip=0.231)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(stretches, "fastest_rate", lambda p: 55.0)
        yield drawn, layout, unknowns, sampling, predict(drawn, NAMES, unknowns, layout, sampling, 1e-10)


#: Numbers of the design, of the run's start (seven) and of its sensors.
COUNT = len(NAMES) + 27
#: So many are changed together: with signs, and by as much as makes each change what is shown by as much as the others.
TOGETHER = 4
SIGNS = np.random.default_rng(1).choice([-1.0, 1.0], COUNT)
ROBOTS = ("alike", "unlike")
#: Tolerance of what is differenced, over the smaller step.
NOISE = 1e-11 / 1e-6


def worst_of(derived, columns, signs):
    """Median and largest of what derivatives by some columns together are off, to the largest derivative of one.

    With panels that stay where they are: a change of the springs moves them, and by that what they leave out.
    """
    drawn, layout, unknowns, sampling, exact = derived
    assert len(NAMES) + len(layout.names) == COUNT
    by_all = np.concatenate([exact.samples[side][:, :, 1:] for side in ("hip", "foot")])
    sizes = np.array([*(DESIGN.value(name) for name in NAMES), *100 * layout.sizes])
    shown_by = sizes * np.abs(by_all).max(axis=(0, 1))
    chosen = np.argsort(shown_by)[columns]
    usual = np.median(shown_by[chosen])
    move = np.zeros(COUNT)
    move[chosen] = signs * sizes[chosen] * usual / shown_by[chosen]

    def at(change):
        design = drawn.with_values({name: drawn.value(name) + change * one for name, one in zip(NAMES, move)})
        found = predict(design, (), unknowns + change * move[len(NAMES) :], layout, sampling, 1e-11)
        return np.concatenate([found.samples["hip"], found.samples["foot"]])[:, :, 0]

    off = np.abs(by_all @ move - extrapolated(at, 2e-6)) / usual
    return np.median(off), off.max()


#: Some together, and in the slow tests each alone.
COLUMNS = [*(slice(first, first + TOGETHER) for first in range(0, COUNT, TOGETHER)),
           *(pytest.param(slice(number, number + 1), marks=pytest.mark.slow) for number in range(COUNT))]  # fmt: skip


@pytest.mark.parametrize("columns", COLUMNS, ids=lambda one: f"{one.start} to {one.stop - 1}")
@pytest.mark.parametrize("derived", ROBOTS, indirect=True)
def test_derivatives_are_those_of_extrapolated_differences(columns, derived):
    median, largest = worst_of(derived, columns, SIGNS[columns])
    assert median < 0.02 * NOISE and largest < 5.0 * NOISE


def test_a_foot_sensor_is_told_of_from_the_hip_or_from_the_foots_mass():
    """The same place told either way shows the same; on a leg that is longer below it, it is the hip's distance."""
    layout, unknowns, sampling = disturbed(2, 2)
    biped = DESIGN.biped
    hung = dataclasses.replace(sampling, below_hip=biped.leg_length - biped.foot_com - 0.004)
    put = dataclasses.replace(sampling, place=0.004)
    for design, told in ((DESIGN, put), (DESIGN.with_value("biped.foot_com", 0.104), sampling)):
        shown, other = (predict(design, (), unknowns, layout, one, 1e-9).samples["foot"][:, :, 0]
                        for one in (hung, told))  # fmt: skip
        np.testing.assert_allclose(shown, other, atol=1e-12 * np.abs(other).max())


def test_an_impact_is_felt_as_its_impulse():
    """The integral of the specific force through a heel strike, behind a filter that keeps integrals: the jump."""
    edges, nodes = np.linspace(0.0, 0.5, 11), 60
    signals = np.zeros((nodes, 1, 1))
    start, lasting = np.zeros(1), np.full(1, 0.5)
    piece = Piece(start, lasting, edges, signals, np.array([[0.7]]))
    after = Piece(lasting, lasting, edges, signals, np.zeros((1, 1)))
    times = np.arange(0.4, 0.95, 4e-6)
    shown = LowPass([piece, after], [0], 40.0).read(times)[0][:, 0, 0]
    assert np.abs(shown[times < 0.5]).max() == 0.0
    assert np.trapezoid(shown, times) == pytest.approx(0.7, rel=1e-6)


def test_a_hip_that_rubs_is_walked_and_derived():
    """Its friction turns with the hip within a step; the derivative by it is that of a difference, down to none."""
    layout, unknowns, sampling = disturbed(1, 2.5)

    def shown(friction, *by):
        """What the hip's sensor shows (n, 3), and where it is asked for by how much more with friction."""
        rubbing, tolerance = DESIGN.with_value("biped.hip_friction", friction), 1e-10 if by else 1e-11
        found = predict(rubbing, by, unknowns, layout, sampling, tolerance).samples["hip"]
        return (found[:, :, 0], found[:, :, 1]) if by else found[:, :, 0]

    _, by = shown(3e-3, "biped.hip_friction")
    expected = (shown(3e-3 + 1e-6) - shown(3e-3 - 1e-6)) / 2e-6
    np.testing.assert_allclose(by, expected, atol=2e-4 * np.abs(expected).max())
    least, by = shown(1e-9, "biped.hip_friction")
    np.testing.assert_allclose(by, (shown(1e-6) - least) / (1e-6 - 1e-9), atol=2e-3 * np.abs(by).max())
    np.testing.assert_allclose(least, shown(0.0), atol=1e-3)
