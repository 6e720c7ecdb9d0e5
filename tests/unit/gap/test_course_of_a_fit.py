"""How a fit goes on and ends, by the parts that it calls; how unsure values are; tables and sentences of answers."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.error_location import Where
from pytest_dvp.gap.compare.iso18571 import _corridor, _rated
from pytest_dvp.gap.diagnose import least_squares as module
from pytest_dvp.gap.diagnose.beyond_remainder import taken_out
from pytest_dvp.gap.diagnose.dependence import Dependence
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, Stop, _jackknife, fit, widen_dead_times
from pytest_dvp.gap.diagnose.quiet_effects import along_the_way
from pytest_dvp.gap.words.comparison import columns, places
from pytest_dvp.gap.words.diagnosis import headline, standing_lines
from pytest_dvp.gap.words.failure_explanation import _effect
from tests.unit.gap.linear_world import DRIVE, World, a_search, tried
from vehicle.model.effect import Key

# --- the course


def coordinate(name: str = "k", **more: Any) -> Coordinate:
    return Coordinate("effect", Key(name, "s", 0.0, 1.0, 0.0, 0.1), **more)


class Course:
    """A fit whose steps are given: each round comes to the next of `levels`; notes what is called in which order."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, levels: Any, *, jumps: float = 0.0, valley: float = 0.0
    ) -> None:
        self.calls: list[Any] = []
        self.levels = [math.sqrt(level) for level in levels]
        self.jumps, self.valley = jumps, valley
        for name in ("_derive", "_improve", "_over_jumps", "_into_valleys", "_zoom"):
            monkeypatch.setattr(module, name, getattr(self, name))
        monkeypatch.setattr(module, "broyden_update", lambda *asked: self.calls.append("update"))
        self.target: Any = SimpleNamespace(whitened=lambda values: np.array([self.levels[0]]), sample=0.02)

    def _derive(self, coordinates: Any, jacobian: Any, residual: Any, r: Any, u: Any, which: Any = None) -> None:
        self.calls.append("derive" if which is None else ("derive", list(which)))

    def _improve(self, coordinates: Any, residual: Any, jacobian: Any, u: Any, r: Any, best: float, damping: float,
                 tries: int) -> Any:  # fmt: skip
        self.calls.append(tries)
        if len(self.levels) > 1:
            self.levels.pop(0)
        return u + 0.01, np.array(self.levels[:1]), self.levels[0] ** 2, damping

    def _over_jumps(self, coordinates: Any, sample: float, residual: Any, u: Any, r: Any, best: float) -> Any:
        self.calls.append("jump")
        left, self.jumps = best - self.jumps, 0.0
        return u, np.array([math.sqrt(left)]), left

    def _into_valleys(self, coordinates: Any, residual: Any, u: Any, r: Any, best: float) -> Any:
        self.calls.append("valley")
        return (u + 0.1 if self.valley else u), r, best - self.valley

    def _zoom(self, coordinates: Any, residual: Any, u: Any, r: Any, best: float) -> Any:
        self.calls.append("zoom")
        return u, r, best

    def run(self, *, known: Any = None, zoom: bool = False, dead_time: float = 0.0, **stop: Any) -> Fit:
        one = coordinate(dead_time=dead_time)
        return fit(self.target, (one,), {one.name: 0.5}, stop=Stop(**{"enough": 1.0, **stop}), zoom=zoom, known=known)


def lent() -> Fit:
    one = coordinate()
    return Fit((one,), {one.name: 0.4}, np.zeros(1), 0.0, np.ones((1, 1)))


@pytest.mark.parametrize(
    ("levels", "given", "calls"),
    [
        # a round that gains goes on with what was seen; one that does not has derivatives taken anew once
        ([100.0, 50.0, 49.5], {}, [("derive", [0]), 5, "update", 4, ("derive", [0]), 5, "valley"]),
        ([100.0, 99.0, 98.5], {}, [("derive", [0]), 5, "update", 4, ("derive", [0]), 5, "valley"]),  # just enough
        ([100.0, 99.1], {}, [("derive", [0]), 5, "valley"]),
        ([100.0, 50.0, 49.5], {"zoom": True},
         [("derive", [0]), 5, "update", 4, ("derive", [0]), 5, "valley", "zoom", "derive"]),
        # lent derivatives are not fresh
        ([100.0, 99.5], {"known": lent()}, [("derive", []), 4, ("derive", [0]), 5, "valley"]),
        # far from what is asked for it may stay rough
        ([100.0, 99.5], {"known": lent(), "above": 99.0}, [("derive", []), 4]),
        ([100.0, 99.5], {"known": lent(), "above": 99.5}, [("derive", []), 4, ("derive", [0]), 5, "valley"]),
        ([100.0, 99.5], {"above": 99.0}, [("derive", [0]), 5]),
        # dead times are moved where no derivative leads on
        ([100.0, 99.5], {"dead_time": 0.1}, [("derive", [0]), 5, "jump", "valley"]),
        ([100.0, 99.5], {"dead_time": 0.1, "above": 99.0}, [("derive", [0]), 5]),
        # six times as many rounds as it says
        ([100.0, 90.0, 80.0, 70.0, 60.0, 50.0, 40.0, 30.0], {"rounds": 1},
         [("derive", [0]), 5, "update", *[4, "update"] * 5, "valley"]),
    ],
)  # fmt: skip
def test_a_fit_goes_on_while_it_gains_and_looks_twice_before_it_ends(
    levels: Any, given: dict[str, Any], calls: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, levels)
    course.run(**given)
    assert course.calls == calls


def test_half_of_the_derivatives_are_taken_anew_those_first_whose_values_have_moved_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Five values, of which the fourth moves most and the first next; a half of five is three."""
    every = tuple(coordinate(name) for name in "abcde")
    course = Course(monkeypatch, [100.0, 50.0, 49.5, 49.4, 49.3])
    away = np.array([0.02, 0.0, 0.01, 0.05, 0.0])
    improve = course._improve

    def moved(coordinates: Any, residual: Any, jacobian: Any, u: Any, *more: Any) -> Any:
        return (u + away, *improve(coordinates, residual, jacobian, u, *more)[1:])

    monkeypatch.setattr(module, "_improve", moved)
    fit(course.target, every, {one.name: 0.5 for one in every}, stop=Stop(enough=1.0))
    derived = [("derive", [0, 1, 2, 3, 4]), 5, "update", 4, ("derive", [3, 0, 2]), 4, ("derive", [1, 4]), 5, "valley"]
    assert course.calls == derived
    some = Fit(every[1:3], {one.name: 0.5 for one in every[1:3]}, np.zeros(1), 0.0, np.ones((2, 1)))
    course = Course(monkeypatch, [100.0, 99.5])  # two are lent: only these are of another place
    fit(course.target, every, {one.name: 0.5 for one in every}, stop=Stop(enough=1.0), known=some)
    assert course.calls == [("derive", [0, 3, 4]), 4, ("derive", [1, 2]), 5, "valley"]


def test_a_jump_that_gains_is_followed_by_another_round(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, [100.0, 99.5], jumps=20.0)
    course.run(dead_time=0.1)
    assert course.calls[:5] == [("derive", [0]), 5, "jump", "derive", 5]
    few = Course(monkeypatch, [100.0, 99.9], jumps=0.8)
    few.run(dead_time=0.1)
    assert few.calls == [("derive", [0]), 5, "jump", "valley"]


def test_after_a_valley_the_derivatives_are_those_of_its_bottom(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, [100.0, 99.5], valley=3.0)
    found = course.run()
    assert course.calls[-2:] == ["valley", "derive"]
    assert found.chi2 == pytest.approx(96.5)
    assert found.values["effect", "k"] == pytest.approx(0.5 + 0.01 + 0.1)


# --- how sure


@pytest.mark.parametrize(
    ("steep", "reach"),
    [
        (1e9, (0.002, 0.002)),  # any move is seen: its share of a sample, here a tenth of 20 ms
        (2.4 / 0.005, (0.005, 0.005)),  # 2.5 standard deviations lie between a quarter of a sample and the half
        (2.4 / 0.01, (0.01, 0.01)),
        (0.0, (0.02, 0.02)),  # no farther than a sample
    ],
)
def test_a_dead_time_is_as_unsure_as_nothing_changes(steep: float, reach: tuple[float, float]) -> None:
    late, plain = coordinate("T", dead_time=0.1), coordinate("g")
    values = {late.name: 0.3, plain.name: 0.5}

    def whitened(given: Any) -> Any:
        return np.array([steep * (given[late.name] - 0.3), 3.0])

    found = Fit((late, plain), values, np.array([0.0, 3.0]), 9.0, np.zeros((2, 2)))
    target: Any = SimpleNamespace(whitened=whitened, sample=0.02)
    sure = {late.name: (0.2999, 0.3001), plain.name: (0.4, 0.6)}
    wide = widen_dead_times(target, found, values, sure)
    assert wide[late.name] == pytest.approx((0.3 - reach[0], 0.3 + reach[1]))
    assert wide[plain.name] == (0.4, 0.6)
    wider = widen_dead_times(target, found, values, {**sure, late.name: (0.1, 0.9)})
    assert wider[late.name] == (0.1, 0.9)


def test_a_dead_time_ends_at_nothing_and_each_side_counts_by_itself() -> None:
    late = coordinate("T", dead_time=0.1)
    short = Fit((late,), {late.name: 0.005}, np.zeros(1), 0.0, np.zeros((1, 1)))
    asked: list[float] = []

    def whitened(given: Any) -> Any:
        asked.append(given[late.name])
        return np.array([1e9 * max(given[late.name] - 0.005, 0.0)])  # later is seen, earlier not

    bounded = dataclasses.replace(late, key=dataclasses.replace(late.key, minimum=0.0))
    short = dataclasses.replace(short, coordinates=(bounded,))
    target: Any = SimpleNamespace(whitened=whitened, sample=0.02)
    (ends,) = widen_dead_times(target, short, {late.name: 0.005}, {late.name: (0.004, 0.006)}).values()
    assert ends == pytest.approx((0.0, 0.007))
    assert min(asked) == 0.0  # a model cannot answer before it is asked


@pytest.mark.parametrize("parts", [2, 4, 10])
def test_the_variance_of_a_mean_by_leaving_out_segments(parts: int) -> None:
    """The jackknife of a mean of segment means y is sum (y - mean)^2 / (m (m - 1))."""
    rng = np.random.default_rng(parts)
    y = rng.normal(size=parts)
    y -= y.mean()  # at the best fit the scores add up to nothing
    found = _jackknife(np.ones((parts, 1, 1)), y[None, :], np.array([[1.0 / parts]]))
    assert found == pytest.approx([float(y @ y) / (parts * (parts - 1))])


def test_of_what_a_single_segment_knows_a_tenth_is_left_at_least() -> None:
    """One segment knows all: without it a tenth counts, so the value moves by ten times its share."""
    by_segment = np.array([[[4.0]], [[0.0]]])
    found = _jackknife(by_segment, np.array([[2.0, 0.0]]), np.array([[0.25]]))
    assert found == pytest.approx([(0.25 * 2.0 / 0.1) ** 2 * 0.5])


# --- ratings


@pytest.mark.parametrize(
    ("error", "norm", "limit", "power", "rating"),
    [(0.0, 2.0, 0.5, 1, 1.0), (0.5, 2.0, 0.5, 1, 0.5), (1.0, 2.0, 0.5, 1, 0.0), (3.0, 2.0, 0.5, 1, 0.0),
     (0.5, 2.0, 0.5, 2, 0.25), (0.0, 0.0, 0.5, 1, 1.0), (0.1, 0.0, 0.5, 1, 0.0)],
)  # fmt: skip
def test_a_rating_falls_from_one_to_nought_at_the_limit(
    error: float, norm: float, limit: float, power: int, rating: float
) -> None:
    assert _rated(error, norm, limit, power) == pytest.approx(rating)


def test_a_corridor_rates_by_the_square_between_a_twentieth_and_a_half_of_the_largest() -> None:
    reference = np.array([10.0, 0.0, 0.0, 0.0])
    away = np.array([0.5, 2.75, 5.0, 9.0])  # within, half way, at the outer edge, beyond
    assert _corridor(reference, reference + away) == pytest.approx((1.0 + 0.25) / 4.0)
    assert _corridor(reference, reference - away) == pytest.approx((1.0 + 0.25) / 4.0)
    assert _corridor(np.zeros(4), np.array([0.0, 0.0, 1e-9, 0.0])) == pytest.approx(0.75)


# --- places of an effect


def test_an_effect_that_the_model_has_is_off_at_its_values() -> None:
    world = World({})
    search = a_search(world, "drive_gain")
    assert taken_out(search, "drive_gain") == {DRIVE: 1.0}
    world.model.effects = [SimpleNamespace(name="mass", values={"ratio": 1.2}),
                           SimpleNamespace(name="drive_gain", values={"g": 0.9})]  # fmt: skip
    assert taken_out(search, "drive_gain") == {DRIVE: 0.9}


def test_places_of_all_logs_are_asked_with_each_of_the_other_values() -> None:
    """Ways of 0 to 40 m along x and one point far off; places 20 m apart."""
    logs = [SimpleNamespace(measured=np.column_stack([x, y, np.zeros(len(x))]))
            for x, y in (([0.0, 12.0, 25.0], [0.0, 0.0, 0.0]), ([40.0, 0.0, np.nan], [0.0, -21.0, 0.0]))]  # fmt: skip
    search: Any = SimpleNamespace(target=SimpleNamespace(experiments=logs))
    points = [{("e", "x"): 1.0, ("e", "y"): 2.0, ("e", "size"): size} for size in (3.0, 4.0, 3.0)]
    found = along_the_way(search, SimpleNamespace(name="e", points=points))  # type: ignore[arg-type]
    at = sorted({(point["e", "x"], point["e", "y"]) for point in found})
    assert at == [(0.0, -20.0), (0.0, 0.0), (20.0, 0.0), (40.0, 0.0)]
    assert sorted(point["e", "size"] for point in found) == [3.0] * 4 + [4.0] * 4


# --- words


def test_places_of_an_error_in_a_table() -> None:
    where = [Where("v", "braking", 0.9, 0.1), Where("ax", "cruise", 0.05, 0.0)]
    lines = [line.split() for line in places(where)]
    assert lines[0] == ["channel", "where", "share", "of", "error", "share", "of", "time"]
    assert lines[1:] == [["v", "braking", "90", "%", "10", "%"], ["ax", "cruise", "5", "%", "0", "%"]]
    many = [Where("v", f"r{k}", 0.9, 0.1) for k in range(9)]
    assert len(places(many)) == 1 + 8
    assert len(places(many, 3)) == 1 + 3


def test_columns_of_words_stand_left_and_figures_right() -> None:
    assert columns([("a", "b", "c", "d"), ("aa", "bb", "cc", "dd")]) == ["a    b  c    d", "aa  bb  cc  dd"]


def diagnosis(*effects: NamedEffect, chi2: Any = (3.0, 1.0)) -> Diagnosis:
    steps = tuple(Step("" if k == 0 else "mass", one, {"v": one}, {"v": 0.1}, one) for k, one in enumerate(chi2))
    return Diagnosis("NAMED", effects, (), steps, {"v": 0.05}, {})


RATIO = {"ratio": Estimate(1.1, 1.0, 1.2, "-")}


@pytest.mark.parametrize(("parameters", "what"), [(RATIO, "mass"), ({**RATIO, "more": RATIO["ratio"]}, "mass.ratio")])
@pytest.mark.parametrize(("end", "moves"), [(1.2, "rises"), (1.0, "falls")])
def test_a_value_that_changes_while_driving_is_told(parameters: Any, what: str, end: float, moves: str) -> None:
    effect = NamedEffect("mass", parameters, standing="confirmed", depends_on=Dependence("ratio", "speed", 1.1, end))
    (line,) = standing_lines(diagnosis(effect))
    assert line == f"{what} {moves} from 1.10 to {end:.2f} with speed"


def test_a_part_is_a_share_of_what_was_beyond_the_noise() -> None:
    """From 3 to 2 is half of it; from 1.5 to 1.25, too."""
    for chi2 in ((3.0, 2.0), (1.5, 1.25)):
        found = dataclasses.replace(diagnosis(NamedEffect("mass", RATIO), chi2=chi2), verdict="PARTIAL")
        assert "that explains 50 % of the error" in headline(found, "M")


@pytest.mark.parametrize(
    ("effect", "text"),
    [
        (NamedEffect("mass", RATIO), "mass: ratio = 1.1 (1.0 to 1.2), explains 7 % of the error, no rivals"),
        (NamedEffect("lag", {"tau": Estimate(0.2, 0.1, 0.3, "s")}, rivals=("a", "b")),
         "lag: tau = 0.2 s (0.1 to 0.3), explains 7 % of the error, rivals: a, b"),
        (NamedEffect("mass", RATIO, action="remove"), "remove mass"),
    ],
)  # fmt: skip
def test_an_effect_in_one_line(effect: NamedEffect, text: str) -> None:
    assert _effect(effect, "7 %") == text


def test_effects_that_are_tried_have_their_points_from_the_strongest_on() -> None:
    (gain,) = tried("drive_gain")
    sizes = [abs(point[DRIVE] - 1.0) for point in gain.points]
    assert sizes == sorted(sizes, reverse=True)
    assert len(gain.coarse) < len(gain.points)
    assert all(0.7 <= point[DRIVE] <= 1.2 for point in gain.points)
    assert min(sizes) > 0.0
