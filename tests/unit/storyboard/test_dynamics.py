"""TransitionDynamics: shapes, and what time, distance and rate mean (ASAM OpenSCENARIO XML 1.3, DynamicsShape)."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.dynamics import Transition, lateral_span, span


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


def test_whole_steps_end_on_the_target_in_spite_of_rounding() -> None:
    change = Transition("sinusoidal", 3.0, 0.0, 1.0)
    for _ in range(300):
        change.advance(0.01)
    assert change.done
    assert change.value == 1.0


@pytest.mark.parametrize("shape", ["cubic", "sinusoidal"])
def test_lateral_span_meets_the_acceleration_it_was_made_from(shape: str) -> None:
    duration = lateral_span(shape, 2.0, 3.5)
    change = Transition(shape, duration, 0.0, 3.5)
    h = 1e-4
    # both shapes accelerate most at their beginning: x = a h^2 / 2
    assert 2.0 * change.advance(h) / h**2 == pytest.approx(2.0, rel=1e-3)
