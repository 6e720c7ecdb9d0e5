"""What makes an effect provisional, what may be taken out of a model, what a verdict is: bounds from both sides."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import diagnose as diagnosing
from pytest_dvp.gap.diagnose.diagnose import _estimates, _folded, _given, _ladder, _measured, _misfit, _verdict
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.held_out import Fold, step
from pytest_dvp.gap.diagnose.imitation import imitation
from pytest_dvp.gap.diagnose.input_scales import implausible_scales, input_map
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit
from pytest_dvp.gap.diagnose.quiet_effects import changing_instead, is_evident, is_evident_apart, quiet
from pytest_dvp.gap.diagnose.removal import (
    SearchSpace,
    _removed,
    lost_held_out,
    price,
    removed_effect,
    searched,
)
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.diagnose.standing import REMAINDER_ONLY, _held_out, _implausible, _Left, _plausible
from pytest_dvp.gap.diagnose.trial import Trial
from tests.unit.gap.linear_world import ROWS, SEGMENTS, World, a_search, direction, tried
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

DRIVE, BRAKE, RATIO = ("drive_gain", "g"), ("brake_gain", "g"), ("steer_ratio", "g")


def key(low: float, high: float, neutral: float) -> Key:
    return Key("k", "-", low, high, neutral=neutral, least=0.1)


@pytest.mark.parametrize(
    ("of", "value", "plausible"),
    [(key(0.5, 1.5, 1.0), 0.5, True), (key(0.5, 1.5, 1.0), 0.499, False), (key(0.5, 1.5, 1.0), 1.5 + 9e-7, True),
     (key(0.5, 1.5, 1.0), 1.501, False), (key(0.5, 1.5, 0.0), 0.1, True), (key(0.5, 1.5, 0.0), 1.501, False),
     (key(0.5, 1.5, 0.5), -9.0, True), (key(0.5, 1.5, 2.0), 9.0, True), (key(0.5, 1.5, 2.0), 0.499, False),
     (key(0.5, 1.5, 1.5), 9.0, True), (key(0.5, 1.5, inf), 99.0, True), (key(0.5, 1.5, inf), 0.499, False),
     (key(0.5, 1.5, inf), 0.5 - 9e-7, True), (key(0.5, 1.5, 1.0), 0.5 - 2e-6, False)],
)  # fmt: skip
def test_a_value_is_plausible_between_nothing_and_the_far_end_of_its_range(
    of: Key, value: float, plausible: bool
) -> None:
    assert _plausible(of, value) is plausible


def named(name: str, **values: float) -> NamedEffect:
    return NamedEffect(name=name, parameters={k: Estimate(v, v, v, "-") for k, v in values.items()})


def test_a_value_outside_what_is_usual_is_told_with_the_range() -> None:
    gain, drag, limit = (find_effect(name) for name in ("drive_gain", "rolling_resistance", "brake_limit"))
    assert _implausible(named("drive_gain", g=1.1), gain, {}) == []
    assert _implausible(named("drive_gain", g=1.3), gain, {}) == ["g = 1.3 is outside what is usual, 0.7 to 1.2"]
    assert _implausible(named("drive_gain", g=1.3), gain, {"g": 1.2}) == []  # of a car that has 1.2, 8 % more
    assert len(_implausible(named("drive_gain", g=0.8), gain, {"g": 1.2})) == 1  # a third less
    assert _implausible(named("rolling_resistance", c=0.5), drag, {"c": 0.2}) == []
    (told,) = _implausible(named("rolling_resistance", c=0.5), drag, {"c": 0.05})
    assert told == "c = 0.5 is outside what is usual, 0.05 to 0.4 m/s^2"
    assert len(_implausible(named("brake_limit", limit=0.9), limit, {"limit": 5.0})) == 1
    fade = find_effect("brake_fade")
    assert _implausible(named("brake_fade", k=0.01, tau=9e9), fade, {}) == []  # how, not how much


def rest(**chi2: float) -> Any:
    """A whitened residual of one row whose channels have these squares."""
    from pytest_dvp.gap.compare.segments import CHANNELS

    return np.array([np.sqrt(chi2.get(name, 0.0)) for name in CHANNELS])


class Leaving:
    """A search that leaves given squares by channel, with all effects and without one; 100 samples of each channel."""

    def __init__(self, whole: Any, less: Any, *, excused: bool = False, count: int = 100) -> None:
        one = SimpleNamespace(residuals=lambda values: SimpleNamespace(count=np.full(8, count)))
        world: Any = SimpleNamespace(excused=excused, experiments=[one])
        world.lasting = lambda: SimpleNamespace(whitened=lambda values: values["rest"])
        self.target = world
        self.final = SimpleNamespace(values={"rest": whole}, fit=SimpleNamespace(residual=whole))
        self._less = SimpleNamespace(values={"rest": less}, fit=SimpleNamespace(residual=less))

    def without(self, final: Any, name: str) -> Any:
        return self._less


@pytest.mark.parametrize(
    ("left", "gain", "doubted"),
    [
        (151.0, 1019.0, True),
        (151.0, 1021.0, False),
        (149.0, 979.0, False),
        (200.0, 1999.0, True),
        (200.0, 2001.0, False),
    ],
)
@pytest.mark.parametrize("excused", [True, False])
def test_much_left_over_in_a_channel_it_acts_on_is_a_doubt_unless_it_explains_twenty_times_as_much(
    left: float, gain: float, doubted: bool, excused: bool
) -> None:
    search = Leaving(rest(v=left), rest(v=left + gain), excused=excused)
    found = _Left(search, search.final).doubts("x")  # type: ignore[arg-type]
    assert found == (["much is left over in v, on which it acts"] if doubted else [])


@pytest.mark.parametrize(("share", "doubted"), [(0.099, False), (0.101, True)])
def test_it_acts_on_a_channel_in_which_it_makes_a_tenth_of_its_change(share: float, doubted: bool) -> None:
    search = Leaving(rest(v=100.0, yaw=300.0, ax=50.0), rest(v=100.0 + 1e3 * (1 - share), yaw=300.0 + 1e3 * share))
    assert bool(_Left(search, search.final).doubts("x")) is doubted  # type: ignore[arg-type]
    none = Leaving(rest(yaw=300.0), rest(yaw=400.0), count=0)
    assert _Left(none, none.final).doubts("x") == []  # type: ignore[arg-type]
    both = Leaving(rest(v=300.0, yaw=300.0), rest(v=400.0, yaw=400.0))
    assert _Left(both, both.final).doubts("x") == ["much is left over in yaw, v, on which it acts"]  # type: ignore[arg-type]


def a_trial(chi2: float, *names: str, segments: Any = None, values: Any = None, fitted: int = 1) -> Trial:
    coordinates = tuple(Coordinate(name, find_effect(name).parameters[0]) for name in names)[:fitted]
    fit = Fit(coordinates, {}, np.zeros(1), chi2, np.zeros((len(coordinates), 1)))
    rows = np.full(SEGMENTS, chi2 / SEGMENTS) if segments is None else segments
    return Trial(names, values or {}, fit, rows)


class Without(Search):
    """A search that knows what is left without an effect."""

    less: Trial

    def without(self, best: Trial, name: str) -> Trial:
        return self.less


@pytest.mark.parametrize(
    ("gain", "excused", "evident", "doubt"),
    [(0.0011, False, (), ""), (0.0009, False, (), "one part"), (None, False, (), "one part"),
     (0.19, True, (), "remainder"), (0.21, True, (), ""), (0.19, True, ("drive_gain",), ""),
     (None, True, (), "one part")],
)  # fmt: skip
def test_an_effect_gains_on_data_held_out_or_in_nearly_every_draw(
    gain: float | None, excused: bool, evident: tuple[str, ...], doubt: str
) -> None:
    search = Without(World({}, excused=excused), ())  # type: ignore[arg-type]
    gains = np.full(SEGMENTS, -1.0)
    gains[0] = 100.0  # missing from 36 % of the draws
    search.less = a_trial(1051.0, segments=np.full(SEGMENTS, 20.0) + gains)
    final = a_trial(1000.0, "drive_gain", segments=np.full(SEGMENTS, 20.0))
    found = _held_out(search, final, "drive_gain", {} if gain is None else {"drive_gain": gain}, evident)
    words = {
        "": [],
        "remainder": [REMAINDER_ONLY],
        "one part": ["only one part of the drive shows it, and no data held out"],
    }
    assert found == words[doubt]
    search.less = a_trial(1051.0, segments=np.full(SEGMENTS, 21.0))
    assert _held_out(search, final, "drive_gain", {}, ()) == []


@pytest.mark.parametrize(("gain", "enough"), [(0.0041, True), (0.0039, False)])
def test_where_much_is_left_rounding_is_a_share_of_it(gain: float, enough: bool) -> None:
    search = Without(World({}), ())  # type: ignore[arg-type]
    search.less = a_trial(4000.0)
    assert (_held_out(search, a_trial(4000.0), "x", {"x": gain}, ()) == []) is enough


@pytest.mark.parametrize(("gain", "evident"), [(401.0, True), (399.0, False)])
def test_an_effect_is_evident_twenty_standard_deviations_from_nothing(gain: float, evident: bool) -> None:
    world = World({DRIVE: 10.0 * np.sqrt(gain) * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")
    assert is_evident(search, {DRIVE: 0.9}, "drive_gain", world) is evident  # type: ignore[arg-type]
    judges = (Fold(None, world),)  # type: ignore[arg-type]
    trial = search.trial(("drive_gain",), {DRIVE: 0.9})
    assert is_evident_apart(search, trial, "drive_gain", judges) is evident
    assert is_evident_apart(search, trial, "drive_gain", ()) is False
    other = Fold(world, world)  # type: ignore[arg-type]
    assert is_evident_apart(search, trial, "drive_gain", (other,)) is False
    weak = World({DRIVE: direction(0)}, {DRIVE: 0.9})
    assert is_evident_apart(search, trial, "drive_gain", (*judges, Fold(None, weak))) is False  # type: ignore[arg-type]
    world.model.effects = [SimpleNamespace(name="drive_gain", values={"g": 0.9})]  # the twin has it already
    assert is_evident(search, {DRIVE: 0.9}, "drive_gain", world) is False  # type: ignore[arg-type]


@pytest.mark.parametrize(("imitated", "evident"), [(0.0232, True), (0.0233, False)])
def test_and_it_is_beyond_what_the_remainder_imitates(imitated: float, evident: bool) -> None:
    """4.3 times a root mean square of 0.0232 is 0.0998."""
    world = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    world.model.remainder_shape.imitates = {"drive_gain": {"g": imitated}}
    search = a_search(world, "drive_gain")
    assert is_evident(search, {DRIVE: 0.9}, "drive_gain", world) is evident  # type: ignore[arg-type]


def test_a_quiet_effect_is_the_best_of_those_that_the_other_metric_shows() -> None:
    """In the metric in which the remainder lasts, the drive's gain is 25 standard deviations off, the brake's 22."""
    does = {DRIVE: 250.0 * direction(0), BRAKE: 220.0 * direction(1), RATIO: 150.0 * direction(2)}
    lasting = World(does, {DRIVE: 0.9, BRAKE: 0.9, RATIO: 0.9})
    small = {name: 0.01 * row for name, row in does.items()}
    world = World(small, {DRIVE: 0.9, BRAKE: 0.9, RATIO: 0.9}, excused=True, other=lasting)
    lasting.model = world.model
    search = a_search(world, "steer_ratio", "brake_gain", "drive_gain")
    found = quiet(search, search.trial((), {}))
    assert found is not None
    assert found.names == ("drive_gain",)
    assert found.chi2 == pytest.approx(ROWS, rel=0.01)
    lasting.does = {RATIO: does[RATIO], DRIVE: 0.0 * does[DRIVE], BRAKE: 0.0 * does[BRAKE]}
    assert quiet(search, search.trial((), {})) is None


@pytest.mark.parametrize(("apart", "changes"), [(399.0, True), (401.0, False)])
def test_a_constant_stands_twenty_standard_deviations_before_what_changes(apart: float, changes: bool) -> None:
    """What fades does exactly the same but for a part at right angles, which costs so much at the best point."""
    (fade,) = tried("brake_fade")
    points = [p for p in fade.points if 0.2 < fade.coordinates[1].to_unit(p["brake_fade", "tau"]) < 0.8]
    assert points
    world = Fading({BRAKE: 1000.0 * direction(0)}, {BRAKE: 0.9}, excused=True)
    world.apart = np.sqrt(apart)
    search = a_search(world, "brake_gain", refiners=("brake_fade",))
    final = search.trial(("brake_gain",), {BRAKE: 0.9})
    assert changing_instead(search, final) == ({"brake_gain": ("brake_fade",)} if changes else {})
    other = a_search(World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9}), "drive_gain", refiners=("brake_fade",))
    assert changing_instead(other, other.trial(("drive_gain",), {DRIVE: 0.9})) == {}


class Fading(World):
    """Any fade stands in for the brake's gain, but for a part at right angles."""

    apart: float

    def whitened(self, values: Any) -> Any:
        if values.get(("brake_fade", "k"), 0.0) > 0.0:
            return self.noise + self.apart * direction(1)
        return super().whitened(values)


class Applied:
    """A model with effects that have the values given, all other things of `linear_world`."""

    def __init__(self, **values: float) -> None:
        self.effects = [SimpleNamespace(name=n, effect=find_effect(n), values={find_effect(n).parameters[0].name: v})
                        for n, v in values.items()]  # fmt: skip


class Having(World):
    """A world whose model has gains of 0.9, which the car lacks or not."""

    def whitened(self, values: Any) -> Any:
        return super().whitened({DRIVE: 0.9, BRAKE: 0.9} | dict(values))


@pytest.mark.parametrize(("excused", "worth"), [(False, 50.0), (True, 200.0)])
def test_an_effect_of_the_model_goes_if_the_measurements_gain_without_it(excused: bool, worth: float) -> None:
    for gain, gone in ((worth - 1.0, False), (worth + 1.0, True)):
        does = {DRIVE: 10.0 * np.sqrt(gain) * direction(0), BRAKE: 100.0 * direction(1)}
        world = Having(does, {DRIVE: 1.0, BRAKE: 0.9}, excused=excused)
        model = Applied(drive_gain=0.9, brake_gain=0.9)
        assert _removed(world, model) == ({DRIVE: 1.0} if gone else {})  # type: ignore[arg-type]
    both = Having({DRIVE: 300.0 * direction(0), BRAKE: 200.0 * direction(1)}, {DRIVE: 1.0, BRAKE: 1.0}, excused=excused)
    assert _removed(both, Applied(drive_gain=0.9, brake_gain=0.9)) == {DRIVE: 1.0, BRAKE: 1.0}  # type: ignore[arg-type]


def test_a_set_has_a_price_for_each_value_fitted_and_each_effect_removed() -> None:
    found = SearchResult(a_trial(2000.0, "drive_gain", "brake_gain", fitted=2), {}, ())
    assert price(found, 1000, 1) == pytest.approx(2000.0 * 1.015)
    little = SearchResult(a_trial(900.0), {}, ())
    assert price(little, 1000, 0) == 1000.0


class Space(SearchSpace):
    """Searches whose results are given: with the effects of the model, and without those that seem too much."""

    results: dict[bool, SearchResult]

    def run(self, fixed: Any) -> Any:
        return Search(self.target, (), fixed=fixed), self.results[bool(fixed)]


def a_space(kept: Trial, without: Trial, *, excused: bool = False, does: float = 300.0) -> Any:
    world = Having({DRIVE: does * direction(0)}, {DRIVE: 1.0}, excused=excused)
    space = Space(world, (), (), (), {}, lambda text: None)  # type: ignore[arg-type]
    object.__setattr__(space, "results", {False: SearchResult(kept, {}, ()), True: SearchResult(without, {}, ())})
    return space


def test_the_search_without_an_effect_counts_if_it_explains_more() -> None:
    model: Any = Applied(drive_gain=0.9)
    better = searched(a_space(a_trial(1500.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (better.found.final.names, better.removed, better.instead) == (("steer_ratio",), {DRIVE: 1.0}, ())
    alike = searched(a_space(a_trial(1120.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (alike.removed, alike.instead) == ({DRIVE: 1.0}, ("brake_gain",))
    worse = searched(a_space(a_trial(1050.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (worse.found.final.names, worse.removed, worse.instead) == (("brake_gain",), {}, ())
    nothing = searched(a_space(a_trial(1050.0, "brake_gain"), a_trial(1100.0)), model)
    assert (nothing.found.final.names, nothing.removed) == ((), {DRIVE: 1.0})
    back = searched(a_space(a_trial(1400.0, "brake_gain"), a_trial(1100.0, "drive_gain")), model)
    assert (back.found.final.names, back.removed) == (("brake_gain",), {})
    right = searched(a_space(a_trial(1400.0, "brake_gain"), a_trial(1100.0), does=1.0), model)
    assert (right.found.final.names, right.removed) == (("brake_gain",), {})


@pytest.mark.parametrize(("more", "kept"), [(9.9, True), (10.2, False)])
def test_what_is_removed_costs_as_much_as_what_is_added(more: float, kept: bool) -> None:
    """Both have one value; the removal of one effect costs half a percent of 2,000."""
    found = searched(
        a_space(a_trial(2000.0 + more, "brake_gain"), a_trial(2000.0, "steer_ratio")), Applied(drive_gain=0.9)
    )  # type: ignore[arg-type]
    assert (found.removed == {}) is kept


def test_of_a_twin_that_learnt_its_car_nothing_is_taken_out_where_an_addition_explains_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model: Any = Applied(drive_gain=0.9)
    for left, gone in ((False, {}), (True, {DRIVE: 1.0})):
        monkeypatch.setattr(Search, "misfit", lambda self, now, left=left: left)
        space = a_space(a_trial(1500.0, "brake_gain"), a_trial(1100.0, "steer_ratio"), excused=True)
        assert searched(space, model).removed == gone


@pytest.mark.parametrize(
    ("held_out", "instead", "excused", "doubts"),
    [(0.1, (), False, []), (0.0, (), False, ["data held out do not gain without it"]), (None, (), False,
      ["data held out do not gain without it"]), (0.199, (), True, [REMAINDER_ONLY]), (0.201, (), True, []),
     (0.3, ("mass", "x"), False, ["the model does as well with mass, x added to it"])],
)  # fmt: skip
def test_a_removed_effect_says_what_speaks_against_it(
    held_out: float | None, instead: tuple[str, ...], excused: bool, doubts: list[str]
) -> None:
    found = removed_effect(find_effect("drive_gain"), 0.4, held_out, instead, excused=excused)
    assert (found.action, found.gain, found.rivals, list(found.doubts)) == ("remove", 0.4, instead, doubts)
    assert found.standing == ("provisional" if doubts else "confirmed")
    assert found.parameters == {"g": Estimate(1.0, 1.0, 1.0, "-")}
    assert removed_effect(find_effect("drive_gain"), -0.1, 1.0, (), excused=False).gain == 0.0
    assert removed_effect(find_effect("drive_gain"), 1.1, 1.0, (), excused=False).gain == 1.0


def test_what_an_effect_of_the_model_costs_on_data_held_out() -> None:
    world = World({DRIVE: 100.0 * direction(0)}, {DRIVE: 1.0})
    final = a_trial(1000.0, values={DRIVE: 1.0})
    judges = (Fold(None, world), Fold(None, World({}, count=500)))  # type: ignore[arg-type]
    assert lost_held_out(Applied(drive_gain=0.9), "drive_gain", final, judges) == pytest.approx(100.0 / 1500.0)  # type: ignore[arg-type]
    assert lost_held_out(Applied(drive_gain=0.9), "drive_gain", final, ()) is None  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("misfit", "rivals", "hidden", "verdict"),
    [(True, None, 0, "UNKNOWN"), (True, (), 0, "PARTIAL"), (False, (), 0, "NAMED"), (False, ("x",), 0, "AMBIGUOUS"),
     (False, None, 5, "NOTHING_MISSING"), (False, None, 6, "NOT_EXCITED")],
)  # fmt: skip
def test_a_verdict_says_what_is_left_what_is_named_and_what_was_not_excited(
    misfit: bool, rivals: tuple[str, ...] | None, hidden: int, verdict: str
) -> None:
    effects = () if rivals is None else (NamedEffect("a", {}), NamedEffect("b", {}, rivals=rivals))
    found = SearchResult(a_trial(1.0), {}, ("x",) * hidden)
    assert _verdict(misfit, effects, found, 10) == verdict


@pytest.mark.parametrize(
    ("heading", "slope", "shown", "turned"),
    [
        (0.3, 0.05, 0.05, 0.3),
        (3.0, 0.05, -0.05, 3.0 - np.pi),
        (-3.0, -0.05, 0.05, np.pi - 3.0),
        (6.0, 0.05, 0.05, 6.0 - 2 * np.pi),
    ],
)
def test_of_two_headings_of_a_slope_the_one_within_a_right_angle_is_told(
    heading: float, slope: float, shown: float, turned: float
) -> None:
    given = {"slope": Estimate(slope, slope - 0.01, slope + 0.02, "-"),
             "heading": Estimate(heading, heading - 0.1, heading + 0.2, "rad")}  # fmt: skip
    found = _folded(given)
    low, high = (-0.01, 0.02) if shown * slope > 0.0 else (-0.02, 0.01)
    assert (found["slope"].value, found["slope"].low, found["slope"].high) == pytest.approx(
        (shown, shown + low, shown + high)
    )
    assert (found["heading"].value, found["heading"].low) == pytest.approx((turned, turned - 0.1))
    assert found["heading"].high == pytest.approx(turned + 0.2)
    assert {e.unit for e in found.values()} == {"-", "rad"}


def test_values_of_an_effect_are_told_with_their_intervals() -> None:
    grade = find_effect("road_grade")
    coordinates = tuple(Coordinate("road_grade", k) for k in grade.parameters)
    names = [k.name for k in grade.parameters]
    assert names == ["slope", "heading"]
    gain = Coordinate("drive_gain", find_effect("drive_gain").parameters[0])
    values = {("road_grade", "slope"): 0.05, ("road_grade", "heading"): 3.0, DRIVE: 0.9}
    fit = Fit((*coordinates, gain), values, np.zeros(1), 1.0, np.zeros((3, 1)))
    sure = {("road_grade", "slope"): (0.04, 0.06), ("road_grade", "heading"): (2.9, 3.1), DRIVE: (0.8, 1.0)}
    trial = Trial(("road_grade", "drive_gain"), {}, fit, np.zeros(1))
    assert _estimates(trial, sure, "drive_gain") == {"g": Estimate(0.9, 0.8, 1.0, "-")}
    found = _estimates(trial, sure, "road_grade")
    assert found["slope"].value == pytest.approx(-0.05)
    assert found["heading"].value == pytest.approx(3.0 - np.pi)


def test_the_ladder_begins_with_what_would_be_missed_most() -> None:
    world = World({DRIVE: 200.0 * direction(0), BRAKE: 300.0 * direction(1)}, {DRIVE: 0.9, BRAKE: 0.9})
    search = a_search(world, "drive_gain", "brake_gain")
    final = search.trial(("drive_gain", "brake_gain"), {DRIVE: 0.9, BRAKE: 0.9})
    found = _ladder(search, final)
    assert [t.names for t in found] == [(), ("brake_gain",), ("brake_gain", "drive_gain")]
    assert [t.chi2 for t in found] == pytest.approx([ROWS + 1300.0, ROWS + 400.0, ROWS], rel=1e-3)
    assert len(_ladder(search, search.trial((), {}))) == 1


def test_a_model_is_told_as_given_and_without_one_more_of_what_the_car_lacks() -> None:
    world = Having({DRIVE: 200.0 * direction(0), BRAKE: 300.0 * direction(1)}, {DRIVE: 1.0, BRAKE: 1.0})
    search = Search(world, (), fixed={DRIVE: 1.0, BRAKE: 1.0})  # type: ignore[arg-type]
    found = _given(search, ("drive_gain", "brake_gain"), ())
    assert [(s.added, s.chi2_per_n) for s in found] == [("", pytest.approx(2.3)), ("drive_gain", pytest.approx(1.9))]


def test_a_step_of_the_ladder_tells_the_error_on_both_data() -> None:
    world = World({DRIVE: 100.0 * direction(0)}, {DRIVE: 0.9})
    search = a_search(world, "drive_gain")
    trial = search.trial(("drive_gain",), {DRIVE: 0.9})
    judges = (Fold(None, World({DRIVE: 200.0 * direction(0)}, {DRIVE: 1.0})), Fold(None, World({}, count=500)))  # type: ignore[arg-type]
    found = step(search, trial, judges)
    assert (found.added, found.chi2_per_n) == ("drive_gain", pytest.approx(1.0, rel=1e-3))
    assert found.held_out_chi2_per_n == pytest.approx((1400.0 + 1000.0) / 1500.0, rel=1e-2)
    assert found.held_out_rmse == {"v": pytest.approx(np.sqrt(0.5 * (1.4 + 1.0)), rel=1e-2)}
    assert (len(found.segments), len(found.held_out_segments)) == (SEGMENTS, 2 * SEGMENTS)
    assert sum(found.segments) == pytest.approx(trial.chi2)
    alone = step(search, trial, (), added="x")
    assert (alone.added, alone.held_out_chi2_per_n, alone.held_out_rmse) == ("x", None, {})


def test_a_misfit_of_data_held_out_is_that_of_the_model_as_it_is() -> None:
    fine, wrong = World({}), World({DRIVE: 200.0 * direction(0)}, {DRIVE: 0.9})
    assert _misfit((Fold(None, fine),)) is False  # type: ignore[arg-type]
    assert _misfit((Fold(None, fine), Fold(None, wrong))) is True  # type: ignore[arg-type]
    assert _misfit((Fold(wrong, wrong), Fold(None, wrong, SimpleNamespace()))) is False  # type: ignore[arg-type]


def test_values_of_a_twin_with_a_remainder_are_estimated_where_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    model: Any = SimpleNamespace(remainder_shape=SimpleNamespace(imitates={"drive_gain": {"g": 0.02}}))
    does = {DRIVE: 100.0 * direction(0)}
    lasting = World(does, {DRIVE: 0.8}, lasts=True)
    for excused, value in ((False, 0.9), (True, 0.8)):
        world = World(does, {DRIVE: 0.9}, excused=excused, other=lasting)
        world.exact = lasting.exact = lambda values: None  # type: ignore[attr-defined]
        monkeypatch.setattr(
            diagnosing, "intervals", lambda fit, starts, exact: {DRIVE: (fit.values[DRIVE] - 0.03, 2.0)}
        )
        search = a_search(world, "drive_gain")
        final, sure = _measured(search, search.trial(("drive_gain",), {DRIVE: 0.9}), model)
        assert final.values[DRIVE] == pytest.approx(value, abs=2e-3)
        wide = np.hypot(0.03, 4.3 * 0.02) if excused else 0.03
        assert final.values[DRIVE] - sure[DRIVE][0] == pytest.approx(wide)


def test_pedals_that_no_car_has_are_told() -> None:
    assert implausible_scales({"full_throttle": 0.5, "full_brake": 15.0, "steer_scale": 99.0}) == []
    assert implausible_scales({"full_throttle": 0.49}) == [
        "full_throttle = 0.49 m/s^2 is not what a full pedal does, 0.5 to 15"
    ]
    assert [text.split(" ")[0] for text in implausible_scales({"full_throttle": 15.1, "full_brake": 0.99})] == [
        "full_throttle", "full_brake",
    ]  # fmt: skip
    assert len(implausible_scales({"full_brake": 15.01})) == 1


@pytest.mark.parametrize(
    ("longitudinal", "steer", "fitted"),
    [("throttle_cmd + brake_cmd", "steer_cmd", ["full_throttle", "full_brake"]),
     ("throttle_cmd", "steer_cmd", ["full_throttle"]), ("motor_current", "steer_cmd", ["full_throttle", "full_brake"]),
     ("accel_cmd", "wheel", ["steer_scale"]), ("accel_cmd", "steer_cmd", []), ("accel_cmd", "steer", [])],
)  # fmt: skip
def test_scales_of_inputs_that_are_no_physical_quantity_are_fitted(
    longitudinal: str, steer: str, fitted: list[str]
) -> None:
    model = parse_model(
        f'[model]\nbase = "kinematic_bicycle"\n[inputs]\nsteer = "{steer}"\nlongitudinal = "{longitudinal}"\n'
        "[parameters]\nwheelbase = 2.7\n"
    )
    coordinates, start = input_map(model)
    assert sorted(c.key.name for c in coordinates) == sorted(fitted)
    assert start == {("inputs", name): getattr(model.inputs, name) for name in fitted}


class Drives(World):
    """Drives of a matched twin: in them an effect is off by nothing, but the remainder looks like some of it."""

    def settle(self, values: Any) -> None:
        assert values == {}


def test_what_a_remainder_imitates_is_what_a_fit_finds_where_nothing_is_hidden() -> None:
    """To first order: the remainder is 0.02 of it in one group of logs and 0.04 in another, wherever the derivative is
    taken. Where the range shows by less than 5 standard deviations nothing is said, and no more than a range is."""
    (candidate,) = tried("drive_gain")
    for offs, off in (((0.02, 0.04), np.sqrt(0.5 * (0.02**2 + 0.04**2))), ((0.9, -0.7), 0.5)):
        groups = [Drives({DRIVE: 100.0 * direction(0)}, {DRIVE: 1.0 + value}) for value in offs]
        found = imitation(groups, [candidate])  # type: ignore[arg-type]
        assert found == {"drive_gain": {"g": pytest.approx(off, rel=2e-3)}}
    (c,) = candidate.coordinates
    for size, told in ((5.1, True), (4.9, False)):
        weak = [Drives({DRIVE: size / abs(c.slope(0.5)) * direction(0)}, {DRIVE: 1.02})]
        assert bool(imitation(weak, [candidate])) is told  # type: ignore[arg-type]
