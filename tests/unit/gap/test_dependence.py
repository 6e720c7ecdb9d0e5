"""Whether a value changes while driving: the line through its shifts, what of it is told, and what it may depend on."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import filled
from pytest_dvp.gap.diagnose.dependence import (
    QUANTITIES,
    Dependence,
    Dependences,
    _by_place,
    _quantile,
    _quantities,
    _windows,
)
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect import Key

FACTOR = Coordinate("mass", Key("factor", "-", 0.5, 1.5, neutral=1.0, least=0.02))
WINDOWS = 40
SEGMENT = np.repeat(np.arange(8), 5)


def dependences(count: int = 1000, chi2: float = 1000.0, value: float = 1.2, **given: Any) -> Dependences:
    found = object.__new__(Dependences)
    found._target = SimpleNamespace(count=count)  # type: ignore[assignment]
    trial = SimpleNamespace(values={FACTOR.name: value}, chi2=chi2, fit=SimpleNamespace(coordinates=(FACTOR,)))
    found._trial = trial  # type: ignore[assignment]
    found._offered = {}
    found._had = {}
    for name, entry in given.items():
        setattr(found, name, entry)
    return found


def line(of: Dependences, q: FloatArray, weight: FloatArray, shift: FloatArray, segment: Any = SEGMENT) -> Any:
    """What is told of windows that each ask for a shift (m,) of the value, with a weight (m,)."""
    return of._line("time", FACTOR, q, weight, -weight * shift, segment)


def a_case(rate: float = 0.1, spread: float = 1.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(5)
    q, weight = np.linspace(3.0, 50.0, WINDOWS), rng.uniform(50.0, 400.0, WINDOWS)
    own = spread * rng.normal(0.0, 0.004, WINDOWS)
    low, high = (float(q[np.searchsorted(np.cumsum(weight), p * weight.sum())]) for p in (0.05, 0.95))
    return q, weight, 0.03 + rate * (q - q.mean()) / (high - low) + own


def expected(q: FloatArray, weight: FloatArray, shift: FloatArray) -> tuple[float, float, float, float, float]:
    """Slope of the weighted line over the span of q from 5 to 95 % of the weight, its error clustered by segment (the
    sandwich of Liang and Zeger), the sum of squares of the span, and the span's ends from the middle."""
    low, high = (float(q[np.searchsorted(np.cumsum(weight), p * weight.sum())]) for p in (0.05, 0.95))
    slope, offset = np.polyfit(q, shift, 1, w=np.sqrt(weight))
    middle = np.average(q, weights=weight)
    z = (q - middle) / (high - low)
    rest = shift - offset - slope * q
    sums = [float((weight * z * rest)[k == SEGMENT].sum()) for k in range(8)]
    spread = float((weight * z * z).sum())
    return slope * (high - low), np.sqrt(np.square(sums).sum()) / spread, spread, low - middle, high - middle


def test_a_change_is_the_weighted_line_through_the_shifts_that_windows_ask_for() -> None:
    q, weight, shift = a_case()
    rate, error, spread, low, high = expected(q, weight, shift)
    assert rate > 4.0 * error
    ((gain, told),) = line(dependences(100, 100.0), q, weight, shift)
    assert gain == pytest.approx(rate**2 * spread / 100.0)
    assert (told.key, told.quantity) == ("factor", "time")
    assert told.start == pytest.approx(1.2 + rate * low / (high - low))
    assert told.end == pytest.approx(1.2 + rate * high / (high - low))
    ((_, down),) = line(dependences(100, 100.0), q, weight, -shift)
    assert down.start - down.end == pytest.approx(rate, rel=1e-6)
    assert told.as_dict() == {"quantity": "time", "from": told.start, "to": told.end, "effect": None, "key": "factor"}
    assert Dependence("k", "speed", 1.0, 2.0, "brake_fade").as_dict()["effect"] == "brake_fade"


@pytest.mark.parametrize(("factor", "told"), [(1.01, True), (0.99, False)])
@pytest.mark.parametrize("misfit", [0.5, 4.0])
def test_a_change_takes_three_percent_of_the_noise_or_of_the_error_away(
    factor: float, told: bool, misfit: float
) -> None:
    q, weight, shift = a_case()
    rate, _, spread, _, _ = expected(q, weight, shift)
    count = rate**2 * spread / (0.03 * max(1.0, misfit))  # with so many samples it takes just 3 %
    weight = weight * 1000.0 / count * factor
    assert bool(line(dependences(1000, misfit * 1000.0), q, weight, shift)) is told


@pytest.mark.parametrize(("size", "told"), [(0.97, True), (1.03, False)])
def test_a_change_is_told_if_it_is_four_standard_errors(size: float, told: bool) -> None:
    q, weight, shift = a_case(spread=1.0)
    rate, error, _, _, _ = expected(q, weight, shift)
    slope, offset = np.polyfit(q, shift, 1, w=np.sqrt(weight))
    rest = shift - offset - slope * q
    noisy = offset + slope * q + size * rate / (4.0 * error) * rest
    assert bool(line(dependences(), q, weight * 100.0, noisy)) is told


@pytest.mark.parametrize(("change", "told"), [(0.0101, True), (0.0099, False)])
def test_a_change_of_half_the_least_size_worth_a_name_is_told(change: float, told: bool) -> None:
    q, weight, _ = a_case()
    low, high = (float(q[np.searchsorted(np.cumsum(weight), p * weight.sum())]) for p in (0.05, 0.95))
    for sign in (1.0, -1.0):
        assert bool(line(dependences(value=1.0), q, weight * 1e4, sign * change * q / (high - low))) is told


@pytest.mark.parametrize(("value", "had", "matters"), [(1.2, 1.0, 0.03), (0.8, 1.0, 0.03), (1.2, 1.1, 0.015)])
def test_a_value_that_moves_by_little_of_what_it_differs_by_is_a_constant(
    value: float, had: float, matters: float
) -> None:
    q, weight, _ = a_case()
    low, high = (float(q[np.searchsorted(np.cumsum(weight), p * weight.sum())]) for p in (0.05, 0.95))
    of = dependences(value=value, _had={FACTOR.name: had})
    for share in (1.01, 0.99):
        assert bool(line(of, q, weight * 1e4, share * matters * q / (high - low))) is (share > 1.0)


def test_what_does_not_vary_or_is_not_known_changes_nothing() -> None:
    q, weight, shift = a_case()
    assert line(dependences(), np.full(WINDOWS, 3.0), weight, shift) == []
    q[7] = np.nan
    assert line(dependences(), q, weight, shift) == []


def test_of_what_does_nearly_as_well_the_first_is_told() -> None:
    """Time before energy: one that takes away 15 % less than the best still comes first."""
    own = np.ones(WINDOWS * 8)
    windows = [np.array([8 * k, 8 * k + 8]) for k in range(WINDOWS)]
    gains = {"time": 0.0, "brake_energy": 0.86, "motor_energy": 1.0, "speed": 0.9}

    class Ranked(Dependences):
        def _line(self, quantity: Any, *rest: Any) -> Any:
            return [(gains[quantity], Dependence("factor", quantity, 0.0, 1.0))] if gains.get(quantity) else []

    of = object.__new__(Ranked)
    fit = SimpleNamespace(jacobian=own[None, :], residual=own, coordinates=(FACTOR,))
    of._trial = SimpleNamespace(fit=fit)  # type: ignore[assignment]
    of._windows, of._segment = windows, SEGMENT
    of._series = dict.fromkeys(QUANTITIES, np.arange(float(WINDOWS)))
    of._offered = {("mass", "brake_energy"): "brake_fade", ("mass", "speed"): "other"}
    assert of._of_coordinate(0, FACTOR)[0][0] == 0.86
    assert of.of("mass") == Dependence("factor", "brake_energy", 0.0, 1.0, "brake_fade")
    gains["brake_energy"] = 0.84
    assert of.of("mass") == Dependence("factor", "motor_energy", 0.0, 1.0)
    assert of.of("drag") is None
    gains.clear()
    assert of.of("mass") is None
    gains["speed"] = 1.0
    fit.coordinates = (Coordinate("mass", Key("factor", "-", 0.5, 1.5, neutral=np.inf, least=0.02)),)
    assert of.of("mass") is None
    fit.coordinates = (Coordinate("mass", Key("tau", "s", 0.5, 1.5, neutral=1.0, least=0.02)),)
    assert of.of("mass") is None


def test_the_value_that_takes_most_away_is_told() -> None:
    other = Coordinate("mass", Key("load", "-", 0.5, 1.5, neutral=1.0, least=0.02))

    class Two(Dependences):
        def _of_coordinate(self, row: int, c: Coordinate) -> Any:
            return [((0.2, 0.5)[row], Dependence(c.key.name, "speed", 0.0, 1.0))]

    of = object.__new__(Two)
    of._trial = SimpleNamespace(fit=SimpleNamespace(coordinates=(FACTOR, other)))  # type: ignore[assignment]
    of._offered = {}
    assert of.of("mass") == Dependence("load", "speed", 0.0, 1.0)


@pytest.mark.parametrize(("shown", "told"), [(12, True), (11, False)])
@pytest.mark.parametrize(("weak", "counts"), [(1.1e-6, True), (0.9e-6, False)])
def test_twelve_windows_must_show_it_by_a_millionth_of_the_strongest(
    shown: int, told: bool, weak: float, counts: bool
) -> None:
    """One window more that is weak decides where eleven are strong."""
    seen: list[Any] = []

    class Listening(Dependences):
        def _line(self, quantity: Any, c: Any, q: Any, weight: Any, slope: Any, segment: Any) -> Any:
            seen.append((quantity, len(q), weight.tolist(), slope.tolist(), segment.tolist()))
            return []

    jacobian = np.zeros(30)
    jacobian[: shown - 1] = 2.0
    jacobian[20] = np.sqrt(4.0 * weak)
    of = object.__new__(Listening)
    fit = SimpleNamespace(jacobian=jacobian[None, :], residual=np.full(30, 3.0), coordinates=(FACTOR,))
    of._trial = SimpleNamespace(fit=fit)  # type: ignore[assignment]
    of._windows, of._segment = [np.array([k, k + 1]) for k in range(30)], np.arange(30) // 2
    of._series = dict.fromkeys(QUANTITIES, np.arange(30.0))
    assert of._of_coordinate(0, FACTOR) == []
    assert bool(seen) is (told and counts)
    if seen:
        quantity, number, weight, slope, segment = seen[0]
        assert (quantity, number, weight[:2], slope[:2], segment[:4]) == (
            "time",
            12,
            [4.0, 4.0],
            [6.0, 6.0],
            [0, 0, 1, 1],
        )
        assert [entry[0] for entry in seen] == ["time", "brake_energy", "motor_energy", "speed", "acceleration"]


def test_a_place_is_known_by_what_other_visits_ask_for() -> None:
    """Cell 1 is visited in segments 0, 3 and 4: 0 and 4 are apart by four, 3 and 4 are one visit."""
    cell = np.array([1.0, 1.0, 1.0, 2.0, 2.0])
    segment = np.array([0, 3, 4, 0, 9])
    weight, slope = np.array([2.0, 4.0, 8.0, 1.0, 5.0]), np.array([6.0, 4.0, -8.0, 3.0, 10.0])
    found = _by_place(cell, weight, slope, segment)
    assert found == pytest.approx([1.0, 0.0, -3.0, -2.0, -3.0])


@pytest.mark.parametrize(("visits", "told"), [(3, True), (2, False)])
def test_more_than_half_of_the_windows_come_back(visits: int, told: bool) -> None:
    cell = np.array([*[7.0] * visits, *np.arange(20.0, 20.0 + 4 - visits)])
    segment = 10 * np.arange(4)
    assert (_by_place(cell, np.ones(4), np.ones(4), segment) is not None) is told


def test_a_quantile_counts_weights() -> None:
    q, weight = np.array([5.0, 1.0, 3.0]), np.array([1.0, 2.0, 7.0])
    assert [_quantile(q, weight, share) for share in (0.05, 0.2, 0.21, 0.9, 0.95)] == [1.0, 1.0, 3.0, 3.0, 5.0]


def an_experiment(t: FloatArray, edges: list[int], **given: FloatArray) -> Any:
    measured = np.zeros((len(t), 8))
    for name, values in given.items():
        measured[:, ("x", "y", "yaw", "v", "yaw_rate").index(name)] = values
    segments = SimpleNamespace(starts=np.array(edges[:-1]), ends=np.array(edges[1:]))
    return SimpleNamespace(log=SimpleNamespace(t=t), measured=measured, segments=segments)


def quantities(e: Any) -> Any:
    whole = filled(e.log.t, e.measured)
    return _quantities(e, whole, max(1e-6, *(float(np.ptp(whole[:, k])) for k in (0, 1))) / 8.0)


def test_windows_last_a_second_within_their_segment_and_go_on_from_log_to_log() -> None:
    t = 0.1 * np.arange(50)
    first = an_experiment(t, [0, 33, 50], v=t, x=4.0 * t)
    second = an_experiment(t[:20], [0, 4, 20], v=2.0 + 0.0 * t[:20], y=7.0 * t[:20])
    windows, segment, series = _windows(SimpleNamespace(experiments=(first, second)))  # type: ignore[arg-type]
    rows = [(0, 11), (11, 22), (22, 33), (33, 41), (41, 50), (50, 54), (54, 62), (62, 70)]
    assert [(int(a) // 8, int(b) // 8) for a, b in windows] == rows
    assert all(int(a) % 8 == 0 == int(b) % 8 for a, b in windows)
    assert segment.tolist() == [0, 0, 0, 1, 1, 2, 3, 3]
    clock = np.append(t, t[:20])
    assert series["time"] == pytest.approx([clock[a:b].mean() for a, b in rows])
    side = 4.0 * 4.9 / 8.0  # of all logs, so that a cell is the same place in each
    cells = np.append(np.floor(4.0 * t / side), 1000.0 * np.floor(7.0 * t[:20] / side))
    assert series["place"] == pytest.approx([cells[(a + b) // 2] for a, b in rows])


@pytest.mark.parametrize("step", [0.25, 0.6])
def test_of_a_few_samples_a_second_a_speed_is_smoothed_over_its_two_neighbours(step: float) -> None:
    v = np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0])
    found = quantities(an_experiment(step * np.arange(6), [0, 6], v=v))
    assert found["speed"] == pytest.approx([0.0, 1.0, 1.0, 1.0, 0.0, 0.0])


def test_what_may_change_a_value_is_told_at_each_stamp() -> None:
    """A car that speeds up by 2 m/s^2 for 10 s and brakes by 4: energies per mass are half the squares of the speed."""
    t = 3.0 + 0.05 * np.arange(301)
    tau = t - t[0]
    v = np.where(tau < 10.0, 2.0 * tau, 20.0 - 4.0 * (tau - 10.0))
    found = quantities(an_experiment(t, [0, 301], v=-v, x=tau**2, y=3.0 * tau))
    assert found["time"] == pytest.approx(tau)
    half = 5  # 0.25 s
    padded = np.concatenate([np.full(half, v[0]), v, np.full(half, v[-1])])
    smooth = np.array([padded[i : i + 2 * half + 1].mean() for i in range(301)])
    assert found["speed"] == pytest.approx(smooth)
    inner = (tau > 0.5) & (tau < 9.5)
    assert found["acceleration"][inner] == pytest.approx(2.0)
    assert found["acceleration"][(tau > 10.5) & (tau < 14.4)] == pytest.approx(-4.0)
    assert found["motor_energy"][-1] == pytest.approx(0.5 * 20.0**2, rel=0.05)
    assert found["brake_energy"][190] == 0.0
    assert found["brake_energy"][-1] == pytest.approx(0.5 * 20.0**2, rel=0.05)
    steps = np.diff(t, prepend=t[0])
    accel = np.gradient(smooth, t)
    assert found["motor_energy"] == pytest.approx(list(itertools.accumulate(np.maximum(accel, 0.0) * smooth * steps)))
    assert found["brake_energy"] == pytest.approx(list(itertools.accumulate(np.maximum(-accel, 0.0) * smooth * steps)))
    side = 225.0 / 8.0
    assert found["place"] == pytest.approx(np.floor(tau**2 / side) + 1000.0 * np.floor(3.0 * tau / side))
