"""What makes an effect provisional, and what a known remainder does not hide: bounds from both sides."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose import standing as module
from pytest_dvp.gap.diagnose.candidates import is_usual
from pytest_dvp.gap.diagnose.dependence import Dependence
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.equation_error import Opinion
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.imitation import larger, placebos
from pytest_dvp.gap.diagnose.quiet_effects import quiet
from pytest_dvp.gap.diagnose.rivals import changing_instead
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.standing import (
    REMAINDER_ONLY,
    Evidence,
    _held_out,
    _implausible,
    _Left,
    _trace,
    with_standing,
)
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend.twin_remainder import _anew
from tests.unit.gap.linear_world import (
    BRAKE,
    DRIVE,
    NOISE,
    ROWS,
    SEGMENTS,
    Limited,
    World,
    a_search,
    a_trial,
    direction,
    tried,
)
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.remainder_shape import RemainderShape

RATIO = ("steer_ratio", "g")


def key(low: float, high: float, neutral: float) -> Key:
    return Key("k", "-", low, high, neutral=neutral, least=0.1)


@pytest.mark.parametrize(
    ("of", "value", "plausible"),
    [(key(0.5, 1.5, 1.0), 0.5, True), (key(0.5, 1.5, 1.0), 0.499, False), (key(0.5, 1.5, 1.0), 1.5 + 9e-7, True),
     (key(0.5, 1.5, 1.0), 1.501, False), (key(0.5, 1.5, 0.0), 0.1, True), (key(0.5, 1.5, 0.0), 1.501, False),
     (key(0.5, 1.5, 0.5), -9.0, True), (key(0.5, 1.5, 2.0), 9.0, True), (key(0.5, 1.5, 2.0), 0.499, False),
     (key(0.5, 1.5, 1.5), 9.0, True), (key(0.5, 1.5, inf), 99.0, True), (key(0.5, 1.5, inf), 0.499, False),
     (key(0.5, 1.5, inf), 0.5 - 9e-7, True), (key(0.5, 1.5, 1.0), 0.5 - 1.1e-6, False),
     (key(0.0, 100.0, 50.0), -9e-5, True), (key(0.0, 100.0, 50.0), -1.1e-4, False)],  # rounding: of the range
)  # fmt: skip
def test_a_value_is_plausible_between_nothing_and_the_far_end_of_its_range(
    of: Key, value: float, plausible: bool
) -> None:
    assert is_usual(of, value) is plausible


def named(name: str, **values: float) -> NamedEffect:
    return NamedEffect(name=name, parameters={k: Estimate(v, v, v, "-") for k, v in values.items()})


def test_a_value_outside_what_is_usual_is_told_with_the_range() -> None:
    gain, drag, limit = (find_effect(name) for name in ("drive_gain", "rolling_resistance", "brake_limit"))
    assert _implausible(named("drive_gain", g=1.1), gain, {}, 2.7) == []
    assert _implausible(named("drive_gain", g=1.3), gain, {}, 2.7) == ["g = 1.3 is outside what is usual, 0.7 to 1.2"]
    assert _implausible(named("drive_gain", g=1.3), gain, {"g": 1.2}, 2.7) == []  # of a car that has 1.2, 8 % more
    assert len(_implausible(named("drive_gain", g=0.8), gain, {"g": 1.2}, 2.7)) == 1  # a third less
    assert _implausible(named("rolling_resistance", c=0.5), drag, {"c": 0.2}, 2.7) == []
    (told,) = _implausible(named("rolling_resistance", c=0.5), drag, {"c": 0.05}, 2.7)
    assert told == "c = 0.5, 0.45 seen from what the model has, is outside what is usual, 0.05 to 0.4 m/s^2"
    assert len(_implausible(named("brake_limit", limit=0.9), limit, {"limit": 5.0}, 2.7)) == 1
    fade = find_effect("brake_fade")
    assert _implausible(named("brake_fade", k=0.01, tau=9e9), fade, {}, 2.7) == []  # how, not how much
    gain_at_nought = _implausible(named("drive_gain", g=0.8), gain, {"g": 0.0}, 2.7)
    assert gain_at_nought == []  # no change by a factor leads there: the value counts
    assert len(_implausible(named("drive_gain", g=1.3), gain, {"g": 0.0}, 2.7)) == 1


def rest(**chi2: float) -> Any:
    """A whitened residual of one row whose channels have these squares."""
    from pytest_dvp.gap.compare.segments import CHANNELS

    return np.array([np.sqrt(chi2.get(name, 0.0)) for name in CHANNELS])


class Leaving:
    """A search that leaves given squares by channel, with all effects and without one; 100 samples of each channel."""

    def __init__(self, whole: Any, less: Any, *, excused: bool = False, count: int = 100, known: float = 1.0) -> None:
        one = SimpleNamespace(residuals=lambda values: SimpleNamespace(count=np.full(8, count)))
        world: Any = SimpleNamespace(excused=excused, experiments=[one])
        world.lasting = lambda: SimpleNamespace(whitened=lambda values: values["rest"])
        world.anew = lambda: dict.fromkeys(CHANNELS, known)
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
    known = Leaving(rest(v=301.0), rest(v=400.0), excused=True, known=2.01)  # 1.5 times 2.01 is 3.015
    assert _Left(known, known.final).doubts("x") == []  # type: ignore[arg-type]
    none = Leaving(rest(yaw=300.0), rest(yaw=400.0), count=0)
    assert _Left(none, none.final).doubts("x") == []  # type: ignore[arg-type]
    both = Leaving(rest(v=300.0, yaw=300.0), rest(v=400.0, yaw=400.0))
    assert _Left(both, both.final).doubts("x") == ["much is left over in yaw, v, on which it acts"]  # type: ignore[arg-type]
    loses = Leaving(rest(v=100.0, yaw=300.0, ax=105.0), rest(v=110.0, yaw=301.05, ax=100.0))  # 1.05 of 11.05
    assert _Left(loses, loses.final).doubts("x") == []  # type: ignore[arg-type]


class Without(Search):
    """A search that knows what is left without an effect."""

    less: Trial

    def without(self, best: Trial, name: str) -> Trial:
        return self.less


@pytest.mark.parametrize(
    ("gain", "excused", "evident", "doubt"),
    [(0.0011, False, (), ""), (0.0009, False, (), "one part"), (None, False, (), "one part"),
     (-0.0009, False, (), "one part"), (-0.0011, False, (), "loses"),
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
        "loses": ["it loses on data held out"],
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


@pytest.mark.parametrize(("known", "left", "more"), [
    (1.0, 2.01, True), (1.0, 1.99, False), (2.2, 4.41, True), (2.2, 4.39, False),
])  # fmt: skip
def test_a_twin_may_leave_anew_what_it_left_of_the_drives_it_learnt_from(known: float, left: float, more: bool) -> None:
    world = World({}, excused=True, channels={"ax": left, "v": 0.5}, known={"ax": known})
    search = a_search(world, "drive_gain")
    assert search.misfit(search.trial((), {})) is more


@pytest.mark.parametrize(("known", "more"), [(1.1, True), (1.3, False)])
def test_and_over_all_channels_as_much_as_it_left_of_them(known: float, more: bool) -> None:
    """chi^2/N is 1.49 here; 1.3 times the mean of `known` and 1 is 1.365 and 1.495."""
    world = World({}, excused=True, channels={"ax": 1.0, "v": 1.0}, known={"ax": known}, noise=np.sqrt(1.49) * NOISE)
    search = a_search(world, "drive_gain")
    assert search.misfit(search.trial((), {})) is more


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


def test_what_another_drive_does_not_show_has_no_say_beside_what_it_shows() -> None:
    """The drive's gain does twice as much where it is fitted; in town only the brake's is asked for."""
    does = {DRIVE: 500.0 * direction(0), BRAKE: 250.0 * direction(1)}
    true = {DRIVE: 0.9, BRAKE: 0.9}
    world = World(does, true, excused=True)
    search = a_search(world, "drive_gain", "brake_gain")
    found = quiet(search, search.trial((), {}))
    assert found is not None
    assert found.names == ("drive_gain",)
    town = (Fold(None, World({DRIVE: 0.0 * does[DRIVE], BRAKE: does[BRAKE]}, true)),)  # type: ignore[arg-type]
    found = quiet(search, search.trial((), {}), town)
    assert found is not None
    assert found.names == ("brake_gain",)


def test_what_the_remainder_imitates_does_not_stand_in_the_way_of_a_quiet_effect() -> None:
    """Three effects gain more than the brake's, and each of them is of a size that the remainder imitates."""
    names = ("drive_gain", "steer_ratio", "mass")
    does = {(n, find_effect(n).parameters[0].name): 500.0 * direction(k) for k, n in enumerate(names)}
    does[BRAKE] = 250.0 * direction(3)
    world = World(does, dict.fromkeys(does, 0.9), excused=True)
    world.model.remainder_shape = RemainderShape(imitates={name: {key: 0.05} for name, key in does if name in names})
    search = a_search(world, *names, "brake_gain")
    found = quiet(search, search.trial((), {}))
    assert found is not None
    assert found.names == ("brake_gain",)


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
    same = Fading({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9})
    same.apart = 0.0
    other = a_search(same, "drive_gain", refiners=("brake_fade",))  # which refines no drive
    assert changing_instead(other, other.trial(("drive_gain",), {DRIVE: 0.9})) == {}


@pytest.mark.parametrize(("gain", "doubted"), [(0.49, True), (0.51, False)])
def test_what_gains_less_than_a_tenth_of_another_one_may_be_its_trace(gain: float, doubted: bool) -> None:
    gains = {"steer_ratio": 5.0, "steer_rate_limit": gain}
    says = ["beside steer_ratio, which explains more than 10 times as much, it may be a trace of that"]
    assert _trace("steer_rate_limit", gains) == (says if doubted else [])
    assert _trace("steer_ratio", gains) == []
    assert _trace("not_shown", gains) == []  # by held-out data, which say nothing of it
    assert _trace("steer_ratio", {"steer_ratio": -0.1}) == []  # nothing is a trace of itself
    assert _trace("steer_ratio", {"steer_ratio": -0.1, "mass": 0.0}) == []  # nor of what explains nothing itself
    assert _trace("steer_ratio", {"steer_ratio": -0.1, "mass": 0.01}) != []


def test_limits_that_the_remainder_looks_like_are_the_lowest_of_those_that_are_evident() -> None:
    """A limit of 5 m/s^2 explains (1000 / 5)^2 of chi^2, and 9^2 in the third world, which is too little."""
    lower = ("brake_limit", "limit")
    five, four = (Limited({lower: 1000.0 * direction(0)}, {lower: value}) for value in (5.0, 4.0))
    little = Limited({lower: 9.0 * 3.0 * direction(0)}, {lower: 3.0})
    model: Any = SimpleNamespace(effects=[])
    groups: Any = (five, four, little)
    sizes, limits = placebos(groups, tried("brake_limit"), model)
    assert (sizes, limits) == ({}, {"brake_limit": {"limit": pytest.approx(4.0, abs=0.1)}})
    assert placebos(groups[2:], tried("brake_limit"), model) == ({}, {})
    model.effects = [SimpleNamespace(name="brake_limit", values={"limit": 4.4})]
    sizes, limits = placebos(groups[:2], tried("brake_limit"), model)
    off = np.sqrt(np.mean([0.6**2, 0.4**2]))
    assert (sizes, limits) == ({"brake_limit": {"limit": pytest.approx(off, abs=0.05)}}, {})


@pytest.mark.parametrize(("row", "refuted"), [(36.0, False), (44.0, True)])
def test_a_limit_that_another_drive_refutes_is_none_that_the_remainder_looks_like(row: float, refuted: bool) -> None:
    """A limit of 4 adds (36 / 4)^2 or (44 / 4)^2 to the chi^2 of a drive that has none; 10^2 refute it."""
    lower = ("brake_limit", "limit")
    town = Limited({lower: 1000.0 * direction(0)}, {lower: 4.0})
    track = Limited({lower: row * direction(0)}, {lower: inf})
    model: Any = SimpleNamespace(effects=[])
    for groups in ((town, track), (track, town)):
        _, limits = placebos(groups, tried("brake_limit"), model)  # type: ignore[arg-type]
        assert limits == ({} if refuted else {"brake_limit": {"limit": pytest.approx(4.0, abs=0.1)}})
    model.effects = [SimpleNamespace(name="brake_limit", values={"limit": 8.0})]
    sizes, _ = placebos((town, track), tried("brake_limit"), model)  # type: ignore[arg-type]
    assert sizes  # of a limit that the twin has, another value is another size


def test_a_size_is_off_by_the_mean_over_all_drives_also_those_that_do_not_show_it() -> None:
    """A gain of 0.9 on one of two drives: 0.1 / sqrt(2)."""
    model: Any = SimpleNamespace(effects=[])
    shown, hidden = (World({DRIVE: size * direction(0)}, {DRIVE: 0.9}) for size in (1000.0, 90.0))
    sizes, limits = placebos((shown, hidden), tried("drive_gain"), model)  # type: ignore[arg-type]
    assert (sizes, limits) == ({"drive_gain": {"g": pytest.approx(0.0707, abs=2e-3)}}, {})
    assert larger({"drive_gain": {"g": 0.08}, "mass": {"ratio": 0.1}}, sizes | {"roll": {"angle": 0.2}}) == {
        "drive_gain": {"g": 0.08}, "mass": {"ratio": 0.1}, "roll": {"angle": 0.2},
    }  # fmt: skip
    assert larger({"drive_gain": {"g": 0.01}}, sizes) == sizes


def test_what_comes_anew_is_the_larger_one_of_the_drives_where_it_is_more_than_noise() -> None:
    groups: Any = (World({}, channels={"ax": 2.216, "v": 0.9}), World({}, channels={"ax": 1.3, "v": 0.8, "ay": 1.04}))
    assert _anew(groups) == {"ax": 2.22, "ay": 1.04}


class Fading(World):
    """Any fade stands in for the brake's gain, but for a part at right angles."""

    apart: float

    def whitened(self, values: Any) -> Any:
        if values.get(("brake_fade", "k"), 0.0) > 0.0:
            return self.noise + self.apart * direction(1)
        return super().whitened(values)


def test_everything_that_speaks_against_an_effect_is_listed_in_its_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "excitation", lambda log, own: SimpleNamespace(out_of_reach=log))
    monkeypatch.setattr(_Left, "__init__", lambda self, search, final: None)
    monkeypatch.setattr(_Left, "doubts", lambda self, name: ["much is left"] if name == "drive_gain" else [])
    world = World({}, excused=True)
    world.model.effects = [SimpleNamespace(name="drive_gain", values={"g": 0.9})]
    search = Without(world, ())  # type: ignore[arg-type]
    search.less = a_trial(2000.0)
    found = [
        NamedEffect("drive_gain", {"g": Estimate(1.3, 0.8, 1.4, "-")}, rivals=("mass",)),
        NamedEffect("brake_gain", {"g": Estimate(0.9, 0.88, 0.92, "-")}),
        NamedEffect("steer_ratio", {}, action="remove"), NamedEffect("gyro_bias", {}),
    ]  # fmt: skip
    change = Dependence("g", "brake_energy", 1.0, 0.8)
    evidence = Evidence({"drive_gain": 0.1, "brake_gain": 0.5}, {"drive_gain": Opinion("it disagrees", "brake_lag")},
                        {"drive_gain": change}, ("a scale is off",))  # fmt: skip
    logs: Any = [{"drive_gain": "no throttle", "brake_gain": "no brake"}, {"drive_gain": "too slow"}]
    known = {name: find_effect(name) for name in ("drive_gain", "brake_gain", "steer_ratio")}
    final = a_trial(1000.0, "drive_gain", "brake_gain", values={DRIVE: 1.3, BRAKE: 0.9})
    drive, brake, removed, other = with_standing(found, search, final, logs, evidence, known)
    assert drive.doubts == (
        "these data cannot tell it from mass", REMAINDER_ONLY, "these drives can hardly show it: no throttle",
        "regression without simulation votes for brake_lag",
        "g = 1.3, 1.44 seen from what the model has, is outside what is usual, 0.7 to 1.2",
        "the twin's known remainder imitates as much", "much is left", "a scale is off",
        "its g changes with brake energy",
    )  # fmt: skip
    assert (drive.standing, drive.rivals, drive.second_engine) == ("provisional", ("mass", "brake_lag"), "it disagrees")
    assert drive.depends_on is change
    assert (brake.standing, brake.doubts, brake.rivals) == ("provisional", ("a scale is off",), ())
    assert removed is found[2]
    assert other is found[3]
    fine = with_standing(found[1:2], search, final, [], Evidence({"brake_gain": 0.5}, {}, {}), known)
    assert (fine[0].standing, fine[0].doubts) == ("confirmed", ())
