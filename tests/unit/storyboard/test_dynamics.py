"""TransitionDynamics: shapes, and what time, distance and rate mean (ASAM OpenSCENARIO XML 1.3, DynamicsShape)."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.dynamics import AREAS, PEAK_SLOPE, SHAPES, SLOPES, Transition, lateral_span, span


@pytest.mark.parametrize(
    ("shape", "quarter"), [("linear", 0.25), ("cubic", 0.15625), ("sinusoidal", (1.0 - math.cos(math.pi / 4.0)) / 2.0)]
)
def test_a_quarter_of_the_time_brings_the_share_of_the_shape(shape: str, quarter: float) -> None:
    change = Transition(shape, 4.0, 10.0, 30.0)
    assert change.advance(1.0) == pytest.approx(10.0 + 20.0 * quarter)


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_half_of_the_time_brings_half_of_the_change(shape: str) -> None:
    assert Transition(shape, 2.0, 0.0, 8.0).advance(1.0) == pytest.approx(4.0)


def test_a_step_is_at_its_target_at_once() -> None:
    change = Transition("step", 5.0, 0.0, 8.0)
    assert change.advance(0.0) == 8.0
    assert change.done


@pytest.mark.parametrize(("shape", "factor"), [("linear", 1.0), ("cubic", 1.5), ("sinusoidal", math.pi / 2.0)])
def test_rate_is_the_peak_rate(shape: str, factor: float) -> None:
    duration = span(shape, "rate", 2.0, -10.0)
    assert duration == pytest.approx(factor * 10.0 / 2.0)
    change = Transition(shape, duration, 10.0, 0.0)
    change.advance(0.5 * duration)
    assert change.rate() == pytest.approx(-2.0)


def test_the_sign_of_a_rate_does_not_matter() -> None:
    assert span("linear", "rate", -5.1, -10.2) == pytest.approx(2.0)


def test_a_rate_of_zero_never_gets_there() -> None:
    change = Transition("linear", span("linear", "rate", 0.0, 3.0), 1.0, 4.0)
    assert change.advance(1e6) == 1.0
    assert not change.done


def test_nothing_to_change_takes_no_time() -> None:
    assert span("cubic", "time", 4.0, 0.0) == 0.0


@pytest.mark.parametrize(("whole", "steps"), [(3.0, 300), (250.0, 2500)])
def test_whole_steps_end_on_the_target_in_spite_of_rounding(whole: float, steps: int) -> None:
    """2500 times 0.1 add up to 9.9e-12 less than 250."""
    change = Transition("sinusoidal", whole, 0.0, 1.0)
    for _ in range(steps):
        assert not change.done
        change.advance(whole / steps)
    assert change.done
    assert change.value == 1.0


@pytest.mark.parametrize("shape", ["cubic", "sinusoidal"])
def test_lateral_span_meets_the_acceleration_it_was_made_from(shape: str) -> None:
    duration = lateral_span(shape, 2.0, 3.5)
    change = Transition(shape, duration, 0.0, 3.5)
    h = 1e-4
    # both shapes accelerate most at their beginning: x = a h^2 / 2
    assert 2.0 * change.advance(h) / h**2 == pytest.approx(2.0, rel=1e-3)


EIGHTHS = [k / 8.0 for k in range(9)]


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_the_slope_is_the_derivative_of_the_shape_and_the_area_its_integral(shape: str) -> None:
    h = 1e-6
    for u in EIGHTHS[1:-1]:
        assert SLOPES[shape](u) == pytest.approx((SHAPES[shape](u + h) - SHAPES[shape](u - h)) / (2.0 * h), rel=1e-6)
        assert SHAPES[shape](u) == pytest.approx((AREAS[shape](u + h) - AREAS[shape](u - h)) / (2.0 * h), rel=1e-6)
    assert (AREAS[shape](0.0), AREAS[shape](1.0)) == pytest.approx((0.0, 0.5))


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_the_peak_slope_is_the_largest_one(shape: str) -> None:
    assert max(SLOPES[shape](u) for u in EIGHTHS) == pytest.approx(PEAK_SLOPE[shape])


def test_a_step_is_flat() -> None:
    assert [SHAPES["step"](u) for u in (0.0, 1.0)] == [1.0, 1.0]
    assert [SLOPES["step"](u) for u in (0.0, 1.0)] == [0.0, 0.0]
    assert [AREAS["step"](u) for u in (0.0, 0.5, 1.0)] == [0.0, 0.5, 1.0]


@pytest.mark.parametrize("dimension", ["time", "distance"])
def test_a_time_or_a_distance_is_the_span_itself(dimension: str) -> None:
    assert span("cubic", dimension, 4.0, 1.0) == span("cubic", dimension, -4.0, -1.0) == 4.0
    assert span("step", dimension, 4.0, 1.0) == 0.0


@pytest.mark.parametrize(("change", "seconds"), [(1e-10, 0.0), (-1e-10, 0.0), (1e-8, 4.0), (-1e-8, 4.0)])
def test_a_change_that_is_rounding_takes_no_time(change: float, seconds: float) -> None:
    assert span("linear", "time", 4.0, change) == seconds


def test_a_lateral_step_takes_no_time_and_one_without_acceleration_for_ever() -> None:
    assert lateral_span("step", 2.0, 3.5) == lateral_span("cubic", 2.0, 0.0) == 0.0
    assert lateral_span("cubic", 0.0, 3.5) == lateral_span("cubic", -1.0, 3.5) == math.inf


def test_lateral_spans_are_those_of_the_second_derivatives() -> None:
    """6 |d| / T^2 and pi^2 |d| / 2 T^2; to either side, and a linear shift like a cubic one."""
    assert lateral_span("cubic", 1.5, -3.5) == lateral_span("linear", 1.5, 3.5) == pytest.approx(math.sqrt(14.0))
    assert lateral_span("sinusoidal", 1.5, -3.5) == pytest.approx(math.pi * math.sqrt(3.5 / 3.0))


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_the_rate_is_that_of_the_value(shape: str) -> None:
    change = Transition(shape, 4.0, 10.0, 4.0)
    change.advance(1.0)
    before, rate = change.value, change.rate()
    assert (change.advance(1e-6) - before) / 1e-6 == pytest.approx(rate, rel=1e-4)
    assert rate < 0.0


@pytest.mark.parametrize("span_", [0.0, -1.0, math.inf])
def test_without_a_span_that_ends_there_is_no_rate(span_: float) -> None:
    assert Transition("linear", span_, 0.0, 1.0).rate() == 0.0


def test_when_done_there_is_no_rate() -> None:
    change = Transition("linear", 2.0, 0.0, 1.0)
    assert change.rate() == 0.5
    change.advance(2.0)
    assert change.rate() == 0.0


def test_a_transition_ends_with_its_span_and_not_before() -> None:
    change = Transition("linear", 2.0, 1.0, 5.0)
    assert (change.value, change.elapsed, change.done) == (1.0, 0.0, False)
    assert (change.advance(1.999), change.done) == (pytest.approx(4.998), False)
    assert (change.advance(0.001), change.done) == (5.0, True)


@pytest.mark.parametrize("shape", ["linear", "cubic"])
def test_straight_on_a_value_changes_by_what_one_says(shape: str) -> None:
    """From 5 to 1 in 8 s: 1 at a time takes 2 s each, whatever the shape."""
    change = Transition(shape, 8.0, 5.0, 1.0)
    assert [change.advance_straight(1.0) for _ in range(3)] == pytest.approx([4.0, 3.0, 2.0])
    assert change.elapsed == pytest.approx(6.0)
    assert (change.advance_straight(3.0), change.done) == (1.0, True)
