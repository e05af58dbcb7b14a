"""Values between the times at which something is known: positions and velocities, the largest, times of samples."""

import numpy as np
import pytest

from stages.biped.between_steps import (
    BLOCK,
    IMPACT_RATE,
    SPIKE_RATE,
    hermite,
    hermite_from,
    largest,
    largest_magnitudes,
    largest_sampled,
    refined_times,
    sampled_at,
    spans_above,
    time_above,
    uniform_times,
)

STEPS = np.array([0.0, 0.3, 0.4, 1.0])
TIME = np.linspace(0.0, 1.0, 2 * BLOCK + 7)  # more than two blocks


def rows(degree):
    """Two polynomials of a degree at the steps, with rates and their rates, and what they are at `TIME`."""
    rng = np.random.default_rng(degree)
    powers = [np.polynomial.Polynomial(rng.normal(size=degree + 1)) for _ in range(2)]
    at = [np.column_stack([power.deriv(order)(STEPS) for power in powers]) for order in range(3)]
    return at, [np.column_stack([power.deriv(order)(TIME) for power in powers]) for order in range(2)]


@pytest.mark.parametrize(("degree", "bent"), [(5, True), (3, False)])
def test_polynomials_of_its_own_degree_are_met_exactly(degree, bent):
    (place, rate, bend), wanted = rows(degree)
    for found, true in zip(hermite(STEPS, place, rate, bend if bent else None, TIME), wanted, strict=True):
        assert found == pytest.approx(true, abs=1e-12)


def test_one_time_or_many_or_one_step_alone_give_the_same():
    (place, rate, bend), _ = rows(7)
    many = hermite(STEPS, place, rate, bend, TIME)
    for row in (0, 1, 2):
        alone = hermite_from(row, STEPS, place, rate, bend)
        for number in np.flatnonzero((STEPS[row] <= TIME) & (STEPS[row + 1] > TIME))[::97]:
            one = hermite(STEPS, place, rate, bend, TIME[number : number + 1])
            for k, exact in enumerate(alone(float(TIME[number]))):
                assert np.array_equal(one[k][0], many[k][number]) and np.array_equal(exact, one[k][0])
        assert np.array_equal(alone(STEPS[row + 1])[0], place[row + 1])


# --- Largest values between the times at which something is known.


TIMES = np.linspace(0.0, 1.0, 41)


def test_a_peak_between_the_times_is_that_of_the_solution():
    peak = 0.3137
    when, value = largest(TIMES, np.cos(9.0 * (TIMES - peak)), lambda t: np.cos(9.0 * (t - peak)))
    assert value == pytest.approx(1.0, abs=1e-13) and when == pytest.approx(peak, abs=1e-12)


def test_an_end_and_a_kink_count_with_their_own_values():
    assert largest(TIMES, TIMES**3, lambda t: t**3) == (1.0, 1.0)
    when, value = largest(TIMES, -np.abs(TIMES - 0.5123), lambda t: -np.abs(t - 0.5123))
    assert value > -2e-3 and abs(when - 0.5123) < 2e-3, "nearer than a tenth of the spacing"


def test_spans_begin_and_end_at_roots():
    spans = spans_above(TIMES, np.sin(9.0 * TIMES), lambda t: np.sin(9.0 * t))
    assert np.array(spans) == pytest.approx(np.array([[0.0, np.pi / 9], [2 * np.pi / 9, 1.0]]), abs=1e-13)


def jumping(time, after):
    """Smooth on both sides of an event at .4137, where it jumps; with a peak of 2.5 before it."""
    return np.where(after, np.cos(3.0 * time), 2.5 + np.sin(7.0 * (time - 0.2)) - 1.0 - 40.0 * (time - 0.3) ** 2)


@pytest.mark.parametrize(("limit", "above"), [
    (-1.0, 3.0), (0.0, 2.0), (0.5, 1.625), (1.5, 0.625), (2.0, 0.0), (3.0, 0.0),
])  # fmt: skip
def test_the_time_above_a_limit_is_that_of_straight_lines(limit, above):
    """It was counted in samples: closer solvers changed nothing of it, or a whole sample."""
    time, values = np.array([0.0, 0.5, 1.5, 2.0, 3.0]), np.array([0.0, 1.0, 2.0, 0.0, 0.0])
    assert time_above(time, values, limit) == pytest.approx(above, abs=1e-15)


def test_both_sides_of_an_event_are_known_and_no_curve_leads_over_it():
    event, fine = 0.4137, np.linspace(0.0, 1.0, 401)
    values = jumping(fine, fine >= event)[:, None]
    times, found = sampled_at(fine, values, np.array([event]), fine)
    sides = np.flatnonzero(times == event)
    assert len(sides) == 2 and len(times) == len(fine) + 2
    assert found[sides, 0] == pytest.approx(jumping(np.full(2, event), np.array([False, True])), abs=1e-7)
    known = np.linspace(0.0, event, 200001)
    assert largest_sampled(times, found)[0] == pytest.approx(jumping(known, False).max(), abs=2e-10)


def test_events_nearer_than_two_samples_are_led_over_by_no_curve():
    """Two models land a fraction of a sample apart: their distance has a kink at each landing."""
    fine, events = np.linspace(0.0, 1.0, 401), np.array([0.41384, 0.41472])  # samples at .4125 and .415
    signal = np.interp(fine, [0.0, *events, 1.0], [0.0, 1.0, 0.9, 0.0])[:, None]
    times, found = sampled_at(fine, signal, events, fine)
    assert [(times == event).sum() for event in events] == [2, 2] and (np.diff(times) >= 0).all()
    assert largest_sampled(times, found)[0] == pytest.approx(1.0, abs=1e-12)
    times, _ = sampled_at(fine, signal, events, np.append(events[0], fine[fine > events[0]]))
    assert times[0] == events[0], "the first of what is wanted is there"


def test_an_end_between_two_samples_is_the_value_at_that_time():
    fine = np.arange(0.0, 1.2, 5e-4)
    times, found = sampled_at(fine, np.exp(fine)[:, None], np.zeros(0), np.append(fine[fine <= 1.00023], 1.00023))
    assert largest_sampled(times, found)[0] == pytest.approx(np.exp(1.00023), rel=1e-13)


@pytest.mark.parametrize("peak", [0.1, 0.31, 0.5023, 0.987])
def test_a_sampled_peak_is_found_to_the_fourth_power_of_the_spacing(peak):
    """Every column has its own, with the sign that its largest magnitude has."""

    def error(count):
        times = np.sort(np.linspace(0.0, 1.0, count) ** 1.3)
        signals = np.column_stack([np.cos(4.0 * (times - peak)), -3.0 * np.cos(4.0 * (times - peak))])
        return np.abs(largest_magnitudes(times, signals) - [1.0, 3.0]).max()

    assert error(41) < 1e-5 and error(161) < max(error(41) / 64, 1e-12)


#: As that of a leg of a third of a metre [s].
PENDULUM_TIME = 0.18


def test_even_times_reach_the_end_in_spite_of_rounding():
    times = uniform_times(0.3, 10.0)  # 0.3 * 10 is a little less than 3
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert times[-1] <= 0.3
    assert refined_times(0.3, 10.0, np.zeros(0), PENDULUM_TIME) == pytest.approx(times), "without heel strikes"


def test_heel_strikes_are_sampled_densely_and_nothing_else_is():
    times = refined_times(2.0, 100.0, np.array([0.5, 1.9999]), PENDULUM_TIME)
    spacing = np.diff(times)
    assert (spacing > 0).all()
    assert times[0] == 0.0 and times[-1] <= 2.0
    near = (times[:-1] > 0.4995) & (times[1:] < 0.508)
    assert spacing[near].max() <= 1.01 * PENDULUM_TIME / IMPACT_RATE
    spike = (times[:-1] >= 0.5) & (times[1:] < 0.50017)
    assert spacing[spike].max() <= 1.01 * PENDULUM_TIME / SPIKE_RATE and spike.sum() >= 36
    far = (times[:-1] > 0.6) & (times[1:] < 1.9)
    assert spacing[far] == pytest.approx(0.01)
