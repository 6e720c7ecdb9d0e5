"""The pieces of a fit, each where its answer follows by hand: coordinates, steps, jumps, valleys and the zoom."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import is_certain, says_how, sizes, without_finer
from pytest_dvp.gap.diagnose.least_squares import (
    VALLEYS,
    Coordinate,
    Fit,
    Stop,
    _derive,
    _improve,
    _into_valleys,
    _lend,
    _over_jumps,
    _zoom,
    intervals,
    widen_imitated,
)
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect

INF = math.inf


def coordinate(low: float = 0.0, high: float = 1.0, neutral: float = 0.5, **more: Any) -> Coordinate:
    key = {name: more.pop(name) for name in ("minimum", "maximum", "name", "late") if name in more}
    name = key.pop("name", "k")
    return Coordinate("effect", Key(name, "s", low, high, neutral, 0.1, **key), **more)


# --- coordinates


@pytest.mark.parametrize(
    ("low", "high", "u", "value"),
    [
        (1.0, 3.0, 0.5, 2.0),  # no more than three times as much: straight
        (1.0, 4.0, 0.5, 2.0),  # by ratio: the geometric mean
        (1.0, 4.0, 1.5, 8.0),
        (0.0, 4.0, 0.25, 1.0),  # from nought on there are no ratios
        (-1.0, 4.0, 1.2, 5.0),
    ],
)
def test_a_place_in_a_range_and_back(low: float, high: float, u: float, value: float) -> None:
    c = coordinate(low, high)
    assert c.value(u) == pytest.approx(value)
    assert c.to_unit(value) == pytest.approx(u)


def test_a_value_is_kept_within_what_the_equation_allows() -> None:
    c = coordinate(0.0, 2.0, minimum=-0.25, maximum=2.25)
    assert [c.value(u) for u in (-0.2, -0.1, 1.1, 1.2)] == pytest.approx([-0.25, -0.2, 2.2, 2.25])


@pytest.mark.parametrize(("value", "u"), [(0.0, -5.0), (0.001, -5.0), (0.01, -10.0 / 3.0)])
def test_a_ratio_of_nothing_counts_as_a_thousandth_of_the_low_end(value: float, u: float) -> None:
    """The range of 0.6 decades is one unit: 2 decades below its low end are 10/3 units, 3 decades are 5."""
    assert coordinate(1.0, 10.0**0.6).to_unit(value) == pytest.approx(u)


@pytest.mark.parametrize(
    ("low", "high", "neutral", "ends"),
    [
        (0.0, 1.0, 0.5, (-0.25, 1.25)),
        (1.0, 10.0, 5.0, (-0.25, 1.25)),
        (1.0, 10.0, 0.0, (-1.0, 1.25)),  # the least size is 0.1, one decade below 1
        (1.0, 10.0, 0.9, (-0.25, 1.25)),  # neutral + least is the low end: that is not lower
        (1.0, 10.0, 1.0, (-0.25, 1.25)),
    ],
)
def test_a_search_goes_a_quarter_of_the_range_beyond_or_to_the_least_size(
    low: float, high: float, neutral: float, ends: tuple[float, float]
) -> None:
    assert coordinate(low, high, neutral).search_limits == pytest.approx(ends)


@pytest.mark.parametrize(
    ("low", "high", "neutral", "ends"),
    [
        (0.0, 2.0, 1.0, (-0.25, 1.25)),
        (0.0, 2.0, 0.0, (0.0, 1.25)),
        (0.0, 2.0, -0.2, (-0.1, 1.25)),
        (0.0, 2.0, -3.0, (-0.25, 1.25)),
        (0.0, 2.0, 2.0, (-0.25, 1.0)),
        (0.0, 2.0, 2.2, (-0.25, 1.1)),
        (0.0, 2.0, INF, (-0.25, 1.25)),
        (0.0, 2.0, -INF, (-0.25, 1.25)),
        (1.0, 10.0, 1.0, (-0.25, 1.25)),  # by ratio
    ],
)
def test_a_search_never_goes_past_doing_nothing(
    low: float, high: float, neutral: float, ends: tuple[float, float]
) -> None:
    c = coordinate(low, high, neutral)
    assert (c.within(-9.0), c.within(9.0)) == pytest.approx(ends)
    assert c.within(0.5) == 0.5


@pytest.mark.parametrize(("u", "stopped"), [(-0.2495, True), (-0.248, False), (1.248, False), (1.2495, True)])
def test_a_thousandth_of_the_range_from_where_a_search_had_to_stop_is_there(u: float, stopped: bool) -> None:
    assert coordinate().is_at_limit(u) is stopped


@pytest.mark.parametrize(("low", "high", "u", "slope"), [(1.0, 3.0, 0.7, 2.0), (1.0, 4.0, 0.5, 2.0 * math.log(4.0))])
def test_the_slope_of_a_value_over_its_place(low: float, high: float, u: float, slope: float) -> None:
    assert coordinate(low, high).slope(u) == pytest.approx(slope, rel=1e-6)


# --- steps


def test_a_key_that_does_nothing_at_first_is_seen_over_the_step_that_it_names() -> None:
    """0.3 of a range of 0.6 from nothing on; elsewhere six thousandths, as any other."""
    slow_to_start = Coordinate("effect", Key("k", "s", 0.0, 0.6, 0.0, 0.05, minimum=0.0, step=0.3))
    assert [slow_to_start.step(u) for u in (0.0, 0.001, 0.499, 0.5)] == pytest.approx([0.5, 0.006, 0.006, -0.006])
    found = np.zeros((1, 1))
    _derive([slow_to_start], found, lambda place: np.maximum(place - 0.1, 0.0), np.zeros(1), np.zeros(1))
    assert found[0, 0] == pytest.approx(0.8)  # 0.4 beyond the part where nothing moves, over 0.5


def test_a_derivative_is_taken_over_six_thousandths_towards_the_middle() -> None:
    """Of u^2 it is 2 u + h forwards and 2 u - h backwards."""
    u = np.array([0.4, 0.5, 0.9])
    found = np.zeros((3, 3))
    _derive([coordinate()] * 3, found, lambda place: np.asarray(place**2), u**2, u)
    assert np.diag(found) == pytest.approx([0.806, 0.994, 1.794])
    assert found - np.diag(np.diag(found)) == pytest.approx(np.zeros((3, 3)))
    only = np.zeros((3, 3))
    _derive([coordinate()] * 3, only, lambda place: np.asarray(place**2), u**2, u, [1])
    assert only[1] == pytest.approx([0.0, 0.994, 0.0])
    assert not only[[0, 2]].any()


def steps(best_at: float, *, sign: float = 1.0, damping: float = 1e-3, tries: int = 5) -> tuple[float, float, float]:
    """One step from 0.5 towards where a straight residual is nought: place, chi^2, damping."""
    u = np.array([0.5])

    def residual(place: Any) -> Any:
        return 3.0 * (place - best_at)

    r = residual(u)
    jacobian = np.array([[3.0 * sign]])
    moved, _, best, left = _improve([coordinate()], residual, jacobian, u, r, float(r @ r), damping, tries)
    return float(moved[0]), best, left


@pytest.mark.parametrize(("damping", "after"), [(1e-3, 1e-4), (1e-7, 1e-7)])
def test_a_step_that_gains_is_taken_and_the_next_is_damped_a_tenth_as_much(damping: float, after: float) -> None:
    place, best, left = steps(0.6, damping=damping)
    assert place == pytest.approx(0.5 + 0.1 / (1.0 + damping))
    assert best == pytest.approx((3.0 * (0.6 - place)) ** 2)
    assert left == pytest.approx(after)


@pytest.mark.parametrize(("best_at", "place"), [(2.0, 0.85), (-2.0, 0.15)])
def test_a_step_is_no_longer_than_a_third_of_the_range(best_at: float, place: float) -> None:
    assert steps(best_at)[0] == pytest.approx(place)


@pytest.mark.parametrize("tries", [1, 2, 5])
def test_a_step_that_loses_is_tried_again_with_eight_times_the_damping(tries: int) -> None:
    place, best, left = steps(0.6, sign=-1.0, tries=tries)
    assert (place, best, left) == (0.5, pytest.approx(0.09), pytest.approx(1e-3 * 8.0**tries))


def test_what_changes_nothing_does_not_stop_the_others() -> None:
    u = np.array([0.5, 0.5])

    def residual(place: Any) -> Any:
        return np.array([2.0 * (place[0] - 0.7)])

    r = residual(u)
    moved, *_ = _improve([coordinate(), coordinate()], residual, np.array([[2.0], [0.0]]), u, r, float(r @ r), 1e-6, 1)
    assert moved == pytest.approx([0.7, 0.5], abs=1e-5)


# --- where no derivative leads


def dip(at: float, width: float, value: Callable[[Any], float]) -> Callable[[Any], Any]:
    """A residual of 1 everywhere but within `width` of a value, where it falls to nought."""
    return lambda u: np.array([min(1.0, abs(value(u) - at) / width)])


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75, 1.0, -0.25, -0.5, -0.75, -1.0])
def test_a_dead_time_is_moved_by_quarters_of_a_sample(share: float) -> None:
    late = coordinate(0.0, 0.5, 0.0, dead_time=0.1)
    other = coordinate(0.0, 0.5, 0.0)
    residual = dip(0.2 + 0.02 * share, 0.001, lambda u: float(late.value(u[0])))
    u = np.array([late.to_unit(0.2), 0.3])
    moved, r, best = _over_jumps([late, other], 0.02, residual, u, np.ones(1), 1.0)
    assert late.value(float(moved[0])) == pytest.approx(0.2 + 0.02 * share)
    assert (moved[1], best, float(r[0])) == (0.3, pytest.approx(0.0, abs=1e-9), pytest.approx(0.0, abs=1e-9))
    plain, _, left = _over_jumps([other, other], 0.02, residual, u, np.ones(1), 1.0)
    assert plain is u
    assert left == 1.0


@pytest.mark.parametrize("share", [1.25, -1.25, 0.125])
def test_nor_farther_than_a_sample_nor_between_the_quarters(share: float) -> None:
    late = coordinate(0.0, 0.5, 0.0, dead_time=0.1)
    residual = dip(0.2 + 0.02 * share, 0.001, lambda u: float(late.value(u[0])))
    u = np.array([late.to_unit(0.2)])
    assert _over_jumps([late], 0.02, residual, u, np.ones(1), 1.0)[0] is u


@pytest.mark.parametrize(("offset", "found"), [(0.05, True), (-0.05, True), (0.0125, True), (0.0525, False)])
def test_a_rough_error_is_looked_into_every_quarter_of_a_hundredth(offset: float, found: bool) -> None:
    assert VALLEYS.tolist() == pytest.approx([0.0025 * k for k in range(-20, 21)])
    rough, smooth = coordinate(rough=True), coordinate()
    u = np.array([0.4, 0.4])
    residual = dip(0.4 + offset, 0.001, lambda place: float(place[1]))
    moved, r, best = _into_valleys([smooth, rough], residual, u, np.ones(1), 1.0)
    assert moved == pytest.approx([0.4, 0.4 + offset if found else 0.4])
    assert best == pytest.approx(0.0 if found else 1.0, abs=1e-9)
    assert best == pytest.approx(float(r[0]) ** 2)
    same, *_ = _into_valleys([smooth, smooth], residual, u, np.ones(1), 1.0)
    assert same is u


@pytest.mark.parametrize(
    ("to_go", "gone"),
    [
        (0.03, 0.03),  # one step of 0.02, two of 0.005
        (-0.03, -0.03),
        (0.2, 0.106),  # four of each: 0.08, 0.02 and 0.006
        (-0.2, -0.106),
        (0.0009, 0.0015),  # the last step is 0.0015: nearer than none
        (0.0007, 0.0),
    ],
)
def test_a_zoom_takes_four_steps_of_three_lengths_either_way(to_go: float, gone: float) -> None:
    u = np.array([0.3, 0.5])

    def residual(place: Any) -> Any:
        return np.array([place[1] - 0.5 - to_go])

    r = residual(u)
    moved, left, best = _zoom([coordinate(), coordinate()], residual, u, r, float(r @ r))
    assert moved == pytest.approx([0.3, 0.5 + gone])
    assert best == pytest.approx((gone - to_go) ** 2, abs=1e-12)
    assert float(left[0]) == pytest.approx(gone - to_go, abs=1e-9)


def test_a_zoom_looks_upwards_first_and_goes_on_from_where_less_is_left() -> None:
    """Less is left a step of 0.02 above, still less one below: that is two steps from where it has gone."""
    u = np.array([0.5])

    def residual(place: Any) -> Any:
        return np.array([2.0 if place[0] > 0.51 else 1.0 if place[0] < 0.49 else 3.0])

    moved, _, best = _zoom([coordinate()], residual, u, residual(u), 9.0)
    assert moved == pytest.approx([0.52])
    assert best == 4.0


def test_derivatives_are_lent_by_name_from_a_fit_of_as_many_samples() -> None:
    a, b, c = (coordinate(name=name) for name in "abc")
    known = Fit((a, b), {}, np.zeros(3), 0.0, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]))
    found = np.zeros((2, 3))
    assert _lend(known, (b, c), found) == {0}
    assert found.tolist() == [[4.0, 5.0, 6.0], [0.0, 0.0, 0.0]]
    assert _lend(known, (a, b), np.zeros((2, 4))) == set()
    assert _lend(None, (a, b), np.zeros((2, 3))) == set()


def test_a_fit_goes_on_for_eight_rounds_while_a_round_gains_one() -> None:
    assert (Stop().rounds, Stop().enough, Stop().above) == (8, 1.0, INF)


# --- how sure


def test_an_interval_of_a_rough_value_is_wider_by_one_valley_and_by_what_small_steps_move() -> None:
    """Two and a half standard deviations; 0.0025 of a range of 2 is 0.005; 0.1 of a slope of 1 moves it by 0.1."""
    smooth, rough = coordinate(0.0, 2.0, -1.0), coordinate(0.0, 2.0, -1.0, rough=True)
    starts = np.array([0, 2])
    r = np.array([1.0, -1.0, 1.0, -1.0])
    jacobian = np.ones((1, 4))

    def half(c: Coordinate, exact: Any = None) -> float:
        found = Fit((c,), {c.name: 1.0}, r, 4.0, jacobian)
        low, high = intervals(found, starts, exact)[c.name]
        assert 1.0 - low == pytest.approx(high - 1.0)
        return high - 1.0

    assert half(smooth) == pytest.approx(2.0 * 2.5 * 0.5)  # of four samples of unit noise: sigma 1/2
    assert half(rough) - half(smooth) == pytest.approx(0.005)
    assert half(smooth, r - 0.1) - half(smooth) == pytest.approx(2.0 * 0.1)


def test_what_a_remainder_imitates_widens_an_interval_by_squares() -> None:
    """4.3 root mean squares of 1 beside half a width: 3 to one side makes sqrt(3^2 + 4.3^2)."""
    c = coordinate(0.0, 9.0, minimum=-2.0)
    found = Fit((c,), {c.name: 5.0}, np.zeros(1), 0.0, np.zeros((1, 1)))
    (ends,) = widen_imitated(found, {c.name: (2.0, 9.0)}, {"effect": {"k": 1.0}}).values()
    assert ends == pytest.approx((5.0 - math.hypot(3.0, 4.3), 5.0 + math.hypot(4.0, 4.3)))
    (ends,) = widen_imitated(found, {c.name: (2.0, 9.0)}, {"effect": {"k": 2.0}}).values()
    assert ends[0] == -2.0
    (ends,) = widen_imitated(found, {c.name: (2.0, 9.0)}, {"other": {"k": 1.0}}).values()
    assert ends == (2.0, 9.0)


@pytest.mark.parametrize(
    ("neutral", "value", "interval", "certain"),
    [
        (0.0, 1.21, (0.21, 2.21), True),  # 1.2 half widths of 1 from nothing
        (0.0, 1.19, (0.19, 2.19), False),
        (0.0, -1.21, (-2.21, -0.21), True),
        (0.0, 5.0, (5.0, 5.0), False),  # nothing that was measured moves with it
        (INF, 5.0, (4.0, 7.2), True),  # less than a third of a range of 10
        (INF, 5.0, (4.0, 7.4), False),
    ],
)
def test_a_value_is_certain(neutral: float, value: float, interval: tuple[float, float], certain: bool) -> None:
    assert is_certain(coordinate(0.0, 10.0, neutral), value, interval) is certain


def test_keys_that_say_how_are_known_and_those_that_come_late_do_not_count() -> None:
    sway = find_effect("body_roll")
    coordinates = tuple(Coordinate("body_roll", key) for key in sway.parameters)
    assert [c.key.name for c in coordinates if says_how(c.key)] == ["frequency", "damping", "lead", "inertia"]
    assert [c.key.name for c in sizes(coordinates)] == ["gain"]
    lag = (Coordinate("steer_lag", find_effect("steer_lag").parameters[0]),)
    assert sizes(lag) == lag  # it only says how: that is what there is
    every = (*coordinates, *lag)
    fit = Fit(every, {}, np.zeros(1), 0.0, np.arange(6.0)[:, None])
    left = without_finer(fit, "body_roll")
    assert [c.key.name for c in left.coordinates] == ["gain", "frequency", "damping", "tau"]
    assert left.jacobian[:, 0].tolist() == [0.0, 1.0, 2.0, 5.0]
    assert len(without_finer(fit, "steer_lag").coordinates) == 6
    late = coordinate(late=True)
    assert says_how(late.key)
