"""The course of a search on residuals that are linear in the values: every gain is known by hand.

An effect that is off by d from the car's value leaves (a d)^2 of chi^2, where a is the length of what one unit does.
"""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import is_certain
from pytest_dvp.gap.diagnose.chance_gain import _pieces, _surrogates, chance_gain
from pytest_dvp.gap.diagnose.changing_set import refined
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.masked_pairs import late_pair
from pytest_dvp.gap.diagnose.search import PRACTICAL, Search
from pytest_dvp.gap.diagnose.simpler_effects import plainer, simplified
from pytest_dvp.gap.diagnose.trial import Trial
from tests.unit.gap.linear_world import NOISE, ROWS, Given, World, a_search, direction, given, tried
from vehicle.model.effect import Key

DRIVE, BRAKE, RATIO, MASS = ("drive_gain", "g"), ("brake_gain", "g"), ("steer_ratio", "g"), ("mass", "ratio")


def hides(**gains: float) -> World:
    """Three gains that are 0.1 too low in the car; what each leaves of chi^2 is given."""
    keys = {"drive": DRIVE, "brake": BRAKE, "ratio": RATIO}
    does = {key: 10.0 * np.sqrt(gains.get(name, 0.0)) * direction(k) for k, (name, key) in enumerate(keys.items())}
    return World(does, dict.fromkeys(keys.values(), 0.9))


def test_effects_are_found_in_the_order_of_what_they_explain_with_their_values() -> None:
    world = hides(drive=400.0, brake=900.0, ratio=20.0)
    found = a_search(world, "drive_gain", "brake_gain", "steer_ratio").run()
    assert found.final.names == ("brake_gain", "drive_gain")
    assert found.final.values[BRAKE] == pytest.approx(0.9, abs=1e-3)
    assert found.final.values[DRIVE] == pytest.approx(0.9, abs=1e-3)
    assert found.final.chi2 == pytest.approx(ROWS + 20.0, abs=0.1)
    assert found.rivals == {"brake_gain": (), "drive_gain": ()}
    assert found.not_excited == ()
    assert world.settled[-1] == pytest.approx(found.final.values, abs=2e-3)


def test_what_does_the_same_is_a_rival_and_what_does_it_better_takes_the_place() -> None:
    """A payload does nearly what a weaker drive does: of 900 it leaves 10 (1 - 0.994^2 = 1.2 %), below 2 % of 1,000."""
    world = hides(drive=900.0)
    world.does[MASS] = 300.0 * direction(5, 0, 0.994)
    search = a_search(world, "drive_gain", "mass")
    found = search.run()
    assert (found.final.names, found.rivals) == (("drive_gain",), {"drive_gain": ("mass",)})
    apart = hides(drive=900.0)
    apart.does[MASS] = 300.0 * direction(5, 0, 0.97)  # leaves 53, more than 5 %
    found = a_search(apart, "drive_gain", "mass").run()
    assert (found.final.names, found.rivals) == (("drive_gain",), {"drive_gain": ()})
    start = search.trial(("mass",), {MASS: 1.0})
    best, rivals = search._contest(start)
    assert (best.names, rivals) == (("drive_gain",), {"drive_gain": ("mass",)})


def test_within_the_noise_nothing_is_named_and_what_would_not_have_shown_is_told() -> None:
    """At the end of its range a gain of 0.7 would change (0.3 a)^2: 0.05 of 1,000 at a = 23.6."""
    world = World({DRIVE: 23.0 * direction(0), BRAKE: 24.0 / 0.75 * direction(1)}, channels={"v": 0.99})
    found = a_search(world, "drive_gain", "brake_gain").run()
    assert (found.final.names, found.rivals) == ((), {})
    changes = {
        c.name: max(np.square([p[c.coordinates[0].name] - 1.0 for p in c.points]))
        for c in tried("drive_gain", "brake_gain")
    }
    expected = tuple(n for n, a in (("brake_gain", 32.0), ("drive_gain", 23.0)) if a**2 * changes[n] < 50.0)
    assert found.not_excited == expected
    assert "drive_gain" in found.not_excited


def test_an_effect_without_which_the_others_do_as_well_is_dropped() -> None:
    world = hides(drive=400.0, brake=40.0)
    search = a_search(world, "drive_gain", "brake_gain")
    both = search.trial(("brake_gain", "drive_gain"), {DRIVE: 0.9, BRAKE: 0.9})
    assert search.pruned(both).names == ("drive_gain",)
    more = a_search(hides(drive=400.0, brake=60.0), "drive_gain", "brake_gain")
    both = more.trial(("brake_gain", "drive_gain"), {DRIVE: 0.9, BRAKE: 0.9})
    assert set(more.pruned(both).names) == {"brake_gain", "drive_gain"}
    alone = more.trial(("brake_gain",), {BRAKE: 0.9})
    assert more.pruned(alone) is alone
    assert more.without(both, "drive_gain").names == ("brake_gain",)
    assert more.without(both, "drive_gain") is more.without(both, "drive_gain")
    nearer = more.trial(("brake_gain", "drive_gain"), {DRIVE: 0.9, BRAKE: 0.9, MASS: 1.1}, kept={MASS: 1.1})
    assert more.without(nearer, "drive_gain") is not more.without(both, "drive_gain")


def test_a_fit_keeps_what_is_fixed_and_what_is_said_of_the_car() -> None:
    world = hides(drive=400.0, brake=900.0)
    search = Search(world, tried("drive_gain", "brake_gain"), fixed={BRAKE: 0.95})  # type: ignore[arg-type]
    found = search.trial(("drive_gain",), {DRIVE: 1.0, ("parameters", "ay_x"): 0.3, MASS: 1.2}, kept={RATIO: 0.8})
    assert found.values == {DRIVE: pytest.approx(0.9, abs=1e-3), BRAKE: 0.95, ("parameters", "ay_x"): 0.3, RATIO: 0.8}
    assert found.segment_chi2.sum() == pytest.approx(found.chi2)
    assert found.chi2 == pytest.approx(ROWS + 0.25 * 900.0, abs=0.1)


@pytest.mark.parametrize(
    ("low", "high", "value", "certain"),
    [(0.85, 0.95, 0.939, True), (0.85, 0.95, 0.941, False), (0.9, 0.9, 0.9, False), (1.05, 1.15, 1.061, True),
     (1.05, 1.15, 1.059, False)],
)  # fmt: skip
def test_a_value_is_certain_if_it_is_clear_of_doing_nothing(
    low: float, high: float, value: float, certain: bool
) -> None:
    """1.2 half-widths of 0.05 are 0.06."""
    c = Coordinate("drive_gain", Key("g", "-", 0.7, 1.2, neutral=1.0, least=0.02))
    assert is_certain(c, value, (low, high)) is certain


@pytest.mark.parametrize(("high", "certain"), [(1.0 + 2.6, True), (1.0 + 2.7, False)])
def test_a_limit_is_certain_within_a_third_of_its_range(high: float, certain: bool) -> None:
    c = Coordinate("x", Key("limit", "m/s^2", -1.0, 7.0, neutral=inf, least=0.1))
    assert is_certain(c, 2.0, (1.0, high)) is certain


@pytest.mark.parametrize(("size", "worth"), [(0.0201, True), (0.0199, False)])
def test_a_value_that_is_worth_a_name_matters(size: float, worth: bool) -> None:
    """A smaller one matters if it gains twice what a first effect must: 60 of 1,000."""
    for gain, clearly in ((59.0, False), (61.0, True)):
        world = World({DRIVE: np.sqrt(gain) / size * direction(0)}, {DRIVE: 1.0 - size})
        search = a_search(world, "drive_gain")
        trial = search.trial(("drive_gain",), {DRIVE: 1.0 - size})
        assert search._matters(trial, "drive_gain", world) is (worth or clearly)  # type: ignore[arg-type]
        assert search._trifle(trial) is not (worth or clearly)


@pytest.mark.parametrize(("gain", "matters"), [(99.0, False), (101.0, True)])
def test_a_further_small_one_must_gain_twice_five_percent_beyond_what_the_others_adapt(
    gain: float, matters: bool
) -> None:
    """Half of what it does, the brake could do as well: to first order only the rest counts."""
    share = np.sqrt(0.5)
    world = World({DRIVE: np.sqrt(gain / 0.5) / 0.01 * direction(2, 1, share), BRAKE: 100.0 * direction(1)},
                  {DRIVE: 0.99, BRAKE: 0.8})  # fmt: skip
    search = a_search(world, "drive_gain", "brake_gain")
    trial = search.trial(("brake_gain", "drive_gain"), {DRIVE: 0.99, BRAKE: 0.8})
    assert search._matters(trial, "drive_gain", world) is matters  # type: ignore[arg-type]


def test_a_value_at_the_end_of_its_range_means_nothing() -> None:
    world = World({DRIVE: 100.0 * direction(0)}, {DRIVE: 0.3})
    search = a_search(world, "drive_gain")
    far = search.trial(("drive_gain",), {DRIVE: 0.7})
    assert far.values[DRIVE] > 0.5  # a quarter of the range beyond 0.7
    assert not search.is_credible(far, "drive_gain")
    fine = a_search(hides(drive=400.0), "drive_gain")
    assert fine.is_credible(fine.trial(("drive_gain",), {DRIVE: 0.9}), "drive_gain")


@pytest.mark.parametrize(("size", "left"), [(299.0, False), (301.0, True)])
@pytest.mark.parametrize(("worst", "more"), [(1.99, False), (2.01, True)])
def test_of_a_twin_with_a_known_remainder_more_is_left_in_all_or_in_one_channel(
    size: float, left: bool, worst: float, more: bool
) -> None:
    lasting = World({}, noise=NOISE + np.sqrt(size) * direction(0), channels={"v": worst})
    world = World({}, excused=True, other=lasting, noise=20.0 * NOISE)
    search = a_search(world)
    assert search.misfit(search.trial((), {})) is (left or more)


def projected(rows: Any, r: Any) -> Any:
    """r without what lies in the span of rows."""
    if not len(rows):
        return r
    q = np.linalg.qr(np.asarray(rows).T)[0]
    return r - q @ (q.T @ r)


def a_look(world: World, *names: str, **values: float) -> tuple[FirstOrderGain, Trial]:
    search = a_search(world, "drive_gain", "brake_gain", "mass", "brake_limit")
    start = {key: 1.0 for key in (DRIVE, BRAKE, MASS) if key[0] in names}
    now = search.trial(names, start)
    return FirstOrderGain(world, now), now  # type: ignore[arg-type]


@pytest.mark.parametrize("beside", [(), ("drive_gain",)])
def test_what_a_point_leaves_is_what_the_others_cannot_take_up(beside: tuple[str, ...]) -> None:
    world = hides(drive=900.0, brake=400.0)
    world.does[BRAKE] = 200.0 * direction(1, 0, 0.6)
    look, now = a_look(world, *beside)
    (candidate,) = tried("brake_gain")
    points = [{BRAKE: g, ("brake_gain", "motor"): 0.0} for g in (0.7, 0.8, 0.95)]
    found = look.remaining_chi2(candidate, points)
    basis = [world.does[DRIVE]] if beside else []

    def left(value: float) -> float:
        r = projected(basis, world.whitened(now.values | {BRAKE: value}))
        return float(r @ r)

    assert [(p[BRAKE], chi2) for chi2, p in found[:3]] == [(v, pytest.approx(left(v))) for v in (0.7, 0.8, 0.95)]
    assert look.strongest == pytest.approx(0.3**2 * 200.0**2)
    middles = sorted(p[BRAKE] for _, p in found[3:])
    best = min((0.7, 0.8, 0.95), key=left)
    line = [0.7, 0.8, 0.95]
    around = [0.5 * (best + line[j]) for j in (line.index(best) - 1, line.index(best) + 1) if 0 <= j < 3]
    change = projected(basis, -200.0 * 0.05 * direction(1, 0, 0.6))
    rest = projected(basis, world.whitened(now.values))
    hopes = {v: left(v) for v in middles if not any(abs(v - m) < 1e-9 for m in around)}
    assert all(any(abs(m - v) < 1e-9 for v in middles) for m in around)
    assert len(hopes) == 1  # where the straight line through the strongest point ends
    (optimum,) = hopes
    share = -float(change @ rest) / float(change @ change)
    assert optimum == pytest.approx(1.0 - 0.05 * share, abs=1e-6)
    for chi2, p in found[3:]:
        assert chi2 == pytest.approx(left(p[BRAKE]))


class Bites(World):
    """A limit that does something only below 3 m/s^2."""

    def whitened(self, values: Any) -> Any:
        value = values.get(("brake_limit", "limit"), inf)
        return self.noise + (20.0 * (min(value, 3.0) - 2.5)) * direction(0)


def test_where_a_limit_begins_to_bite_is_looked_at_more_closely() -> None:
    """Between the last point that shows (2) and the first that does not (6): halfway each time, four times at most."""
    world = Bites({})
    search = a_search(world, "brake_limit")
    look = FirstOrderGain(world, search.trial((), {}))  # type: ignore[arg-type]
    (candidate,) = tried("brake_limit")
    limit = ("brake_limit", "limit")
    (c,) = candidate.coordinates
    found = look.remaining_chi2(candidate, [{limit: 1.5}, {limit: 2.0}, {limit: 6.0}, {limit: 9.0}])
    values = [p[limit] for _, p in found]
    assert values[:2] == [1.5, 2.0]
    expected, strong, weak = [], 2.0, 6.0
    for _ in range(4):
        middle = c.value(0.5 * (c.to_unit(strong) + c.to_unit(weak)))
        if middle >= 3.0:
            weak = middle
            continue
        expected.append(middle)
        if abs(middle - 2.5) < 0.5:
            break
        strong = middle
    assert values[2 : 2 + len(expected)] == pytest.approx(expected)
    assert all(p[limit] < 3.0 for _, p in found)
    assert look.remaining_chi2(candidate, [{limit: 4.0}, {limit: 2.0}]) == []
    assert look.strongest == 0.0


def test_surrogates_keep_spectrum_size_and_gaps_of_each_piece() -> None:
    rng = np.random.default_rng(2)
    r = rng.normal(size=60) + 0.5
    r[[3, 7]] = 0.0
    even, odd, short = np.arange(0, 40, 2), np.arange(1, 30, 2), np.array([50, 51, 52])
    found = _surrogates(r, [even, odd, short], 200)
    assert found.shape == (200, 60)
    for piece in (even, odd):
        own = piece[r[piece] != 0.0]
        spectrum = np.abs(np.fft.rfft(found[:, own], axis=1))
        assert spectrum == pytest.approx(np.tile(np.abs(np.fft.rfft(r[own])), (200, 1)))
        assert (found[:, own] ** 2).sum(axis=1) == pytest.approx(np.full(200, r[own] @ r[own]))
        assert {-1.0, 1.0} == set(np.sign(found[:, own].sum(axis=1)))
        assert np.abs(found[:, own].mean(axis=0)).max() < 0.5
    assert (found[:, [3, 7, *range(50, 60)]] == 0.0).all()
    assert len({tuple(row) for row in found.round(9)}) == 200
    assert _surrogates(r, [even], 3)[0] == pytest.approx(_surrogates(r, [even], 3)[0])
    four = _surrogates(np.array([1.0, -2.0, 3.0, 0.5]), [np.arange(4)], 5)
    assert (four != 0.0).any()


def test_pieces_are_channels_of_segments_of_all_logs() -> None:
    from types import SimpleNamespace

    first = SimpleNamespace(edges=np.array([0, 16, 40]), channels=("x", "v"))
    second = SimpleNamespace(edges=np.array([0, 24]), channels=("yaw",))
    found = _pieces(SimpleNamespace(experiments=(first, second)))  # type: ignore[arg-type]
    assert [piece.tolist() for piece in found] == [[0, 8], [3, 11], [16, 24, 32], [19, 27, 35], [42, 50, 58]]


class Chance(World):
    """One channel of two segments; of the noise every row counts."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.experiments[0].edges = np.array([0, 500, 1000]) // 8 * 8
        self.experiments[0].channels = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")


def test_luck_gains_what_the_best_effect_explains_of_surrogates() -> None:
    rng = np.random.default_rng(6)
    noise = rng.normal(size=ROWS)
    noise[::7] = 0.0
    world = Chance(
        {DRIVE: 30.0 * direction(0), BRAKE: 30.0 * direction(1), MASS: np.where(noise != 0.0, 1e-9, 0.0)}, noise=noise
    )
    plain = chance_gain(world, {}, tried("drive_gain", "brake_gain", "mass"), draws=40)  # type: ignore[arg-type]
    kept = np.flatnonzero(noise)
    draws = _surrogates(noise, _pieces(world), 40)[:, kept]  # type: ignore[arg-type]
    units = [direction(k)[kept] / np.linalg.norm(direction(k)[kept]) for k in (0, 1)]
    best = np.max([(draws @ unit) ** 2 for unit in units], axis=0)
    assert plain == pytest.approx(np.quantile(best, 0.95) / ROWS)
    without = chance_gain(world, {DRIVE: 1.0}, tried("drive_gain", "brake_gain"), draws=40)  # type: ignore[arg-type]
    assert without == pytest.approx(np.quantile((draws @ units[1]) ** 2, 0.95) / ROWS)
    fitted = chance_gain(world, {}, tried("drive_gain", "brake_gain"), jacobian=world.does[DRIVE][None, :], draws=40)  # type: ignore[arg-type]
    free = np.array([projected([units[0]], row) for row in draws])
    other = projected([units[0]], units[1])
    assert fitted == pytest.approx(np.quantile((free @ other) ** 2 / (other @ other), 0.95) / ROWS)
    nothing = Chance({DRIVE: direction(0)}, noise=np.zeros(ROWS))
    assert chance_gain(nothing, {}, tried("drive_gain"), draws=3) == 0.0  # type: ignore[arg-type]


def refined_by(search: Given, *names: str) -> tuple[tuple[str, ...], dict[str, tuple[str, ...]]]:
    rivals: dict[str, tuple[str, ...]] = dict.fromkeys(names, ())
    return refined(search, search.trial(names, {}), rivals).names, rivals


def fading(constant: float, fade: float, both: float | None = None, **options: Any) -> Given:
    leaves = {"": 3000.0, "brake_gain": constant, "brake_fade": fade}
    leaves["brake_gain brake_fade"] = both if both is not None else min(constant, fade)
    return given(leaves, "brake_gain", refiners=("brake_fade",), **options)


@pytest.fixture
def one_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """To first order, one point of each effect is as good as any."""
    monkeypatch.setattr(FirstOrderGain, "__init__", lambda self, target, now: None)
    monkeypatch.setattr(FirstOrderGain, "remaining_chi2", lambda self, candidate, points, *needed: [(1.0, points[0])])


@pytest.mark.usefixtures("one_point")
def test_what_changes_while_driving_takes_the_place_of_a_constant_that_it_beats() -> None:
    assert refined_by(fading(1200.0, 1100.0), "brake_gain")[0] == ("brake_fade",)
    assert refined_by(fading(1200.0, 1201.0), "brake_gain") == (("brake_gain",), {"brake_gain": ("brake_fade",)})
    assert refined_by(fading(1200.0, 1300.0), "brake_gain") == (("brake_gain",), {"brake_gain": ()})
    assert refined_by(fading(1200.0, 1300.0, 1000.0), "brake_gain")[0] == ("brake_gain", "brake_fade")
    price = 1e-3 * ROWS
    assert refined_by(fading(1200.0, 1200.0 - 1.01 * price), "brake_gain")[0] == ("brake_fade",)
    assert refined_by(fading(1200.0, 1200.0 - 0.9 * price), "brake_gain")[0] == ("brake_gain",)


@pytest.mark.usefixtures("one_point")
def test_within_the_noise_a_single_constant_is_not_refined_and_nothing_needs_it() -> None:
    assert refined_by(fading(1000.0, 900.0, channels=0.9), "brake_gain")[0] == ("brake_gain",)
    assert refined_by(fading(1000.0, 900.0, channels=1.1), "brake_gain")[0] == ("brake_fade",)
    assert refined_by(fading(1000.0, 900.0, channels=0.9, excused=True), "brake_gain")[0] == ("brake_fade",)
    assert refined_by(fading(1000.0, 900.0))[0] == ()
    leaves = {"": 9e3, "brake_gain": 5e3, "drive_gain": 5e3, "brake_gain drive_gain": 1000.0, "brake_fade": 900.0,
              "drive_gain brake_fade": 890.0, "brake_gain drive_gain brake_fade": 890.0}  # fmt: skip
    two = given(leaves, "brake_gain", "drive_gain", refiners=("brake_fade",), channels=0.9)
    assert "brake_fade" in refined_by(two, "brake_gain", "drive_gain")[0]


@pytest.mark.usefixtures("one_point")
def test_of_a_bare_model_that_leaves_more_than_twice_the_noise_nothing_is_refined() -> None:
    for bare, left, name in ((True, 2001.0, "brake_gain"), (True, 2000.0, "brake_fade"), (False, 2001.0, "brake_fade")):
        search = fading(left, 1000.0)
        search.bare = bare
        assert refined_by(search, "brake_gain")[0] == (name,)


@pytest.mark.usefixtures("one_point")
def test_beside_a_known_remainder_a_gap_that_tells_nothing_is_no_reason_to_refine() -> None:
    assert refined_by(fading(1200.0, 1190.0, excused=True), "brake_gain") == (
        ("brake_gain",),
        {"brake_gain": ("brake_fade",)},
    )
    assert refined_by(fading(1200.0, 1100.0, excused=True), "brake_gain")[0] == ("brake_fade",)


@pytest.mark.usefixtures("one_point")
@pytest.mark.parametrize(("left", "looked"), [(1310.0, True), (1290.0, False)])
def test_beside_other_effects_a_change_is_looked_for_only_where_something_is_left(left: float, looked: bool) -> None:
    leaves = {"": 3000.0, "drive_gain": left, "brake_fade": 2900.0, "drive_gain brake_fade": 1000.0}
    search = given(leaves, "drive_gain", refiners=("brake_fade",))
    assert refined_by(search, "drive_gain")[0] == (("drive_gain", "brake_fade") if looked else ("drive_gain",))


@pytest.mark.usefixtures("one_point")
def test_a_change_must_pay_and_mean_something() -> None:
    assert refined_by(fading(1200.0, 1100.0, vague=("brake_fade",)), "brake_gain")[0] == ("brake_gain",)
    worth = fading(1200.0, 2950.0, 1190.0)  # alone it gains 1.7 % of what is left, beside the constant 0.8 %
    assert refined_by(worth, "brake_gain")[0] == ("brake_gain",)


def test_a_simpler_effect_takes_the_place_of_one_that_contains_it_if_it_does_as_well() -> None:
    for more, name in ((40.0, "steer_ratio"), (60.0, "steer_asymmetry")):
        leaves = {"steer_asymmetry": 1000.0, "steer_ratio": 1000.0 + more, "": 3000.0}
        search = given(leaves, "steer_asymmetry", "steer_ratio")
        assert simplified(search, search.trial(("steer_asymmetry",), {}), PRACTICAL).names == (name,)
    both = given({"steer_asymmetry steer_ratio": 1000.0}, "steer_asymmetry", "steer_ratio")
    start = both.trial(("steer_asymmetry", "steer_ratio"), {})
    assert simplified(both, start, PRACTICAL) is start


def test_effects_whose_values_mean_nothing_go_the_last_named_first() -> None:
    leaves = {"": 2000.0, "drive_gain": 1500.0, "brake_gain": 1800.0, "mass": 1900.0, "drive_gain brake_gain": 1250.0,
              "drive_gain mass": 1200.0, "brake_gain mass": 1400.0, "drive_gain brake_gain mass": 1000.0}  # fmt: skip
    names = ("drive_gain", "brake_gain", "mass")
    search = given(leaves, *names, vague=("brake_gain", "mass"))
    whole = search.trial(names, {})
    assert search._drop_implausible(whole).names == ("drive_gain",)
    assert given(leaves, *names)._drop_implausible(whole).names == names
    first = given(leaves, *names, vague=("drive_gain",))
    assert first._drop_implausible(whole).names == ("brake_gain", "mass")


def test_others_come_in_the_place_of_what_means_nothing_only_if_asked_for_and_if_a_misfit_is_left() -> None:
    leaves = {"drive_gain": 1500.0, "drive_gain mass": 1200.0, "drive_gain steer_ratio": 1000.0}
    search = given(leaves, "drive_gain", "mass", "steer_ratio", vague=("mass",))
    assert search._drop_implausible(whole := search.trial(("drive_gain", "mass"), {})).names == ("drive_gain",)
    assert search._drop_implausible(whole, refill=True).names == ("drive_gain", "steer_ratio")
    search.leaves |= {frozenset(["drive_gain"]): 1300.0}
    assert search._drop_implausible(whole, refill=True).names == ("drive_gain",)


@pytest.mark.usefixtures("one_point")
def test_a_plainer_form_may_take_its_place() -> None:
    """A body that rolls details a delay of the steering's answer; without either more is left."""
    (roll,) = tried("body_roll")
    plain = roll.effect.diagnosed.details
    assert plain
    leaves = {"": 1500.0, "body_roll": 1000.0, plain: 1200.0}
    search = given(leaves, "body_roll", plain)
    assert plainer(search, search.trial(("body_roll",), {}), "body_roll").names == (plain,)
    poor = given({**leaves, plain: 1600.0}, "body_roll", plain)
    assert plainer(poor, poor.trial(("body_roll",), {}), "body_roll").names == ()
    alone = given({"": 1500.0, "body_roll": 1000.0}, "body_roll")
    assert plainer(alone, alone.trial(("body_roll",), {}), "body_roll").names == ()


def test_effects_are_added_one_by_one_and_what_came_second_is_remembered() -> None:
    leaves = {"": 3000.0, "drive_gain": 1800.0, "brake_gain": 2000.0, "mass": 2500.0, "drive_gain brake_gain": 1400.0,
              "drive_gain mass": 1700.0, "drive_gain brake_gain mass": 1390.0}  # fmt: skip
    search = given(leaves, "drive_gain", "brake_gain", "mass")
    turns: list[Trial] = []
    assert search.grown(search.trial((), {}), turns).names == ("drive_gain", "brake_gain")
    assert [t.names for t in turns] == [("brake_gain",), ("drive_gain", "mass")]
    assert search.grown(search.trial((), {}), [], ["drive_gain"]).names[0] == "brake_gain"


def test_where_much_is_left_the_search_begins_again_from_what_came_second() -> None:
    """The first choice leads to 1,500; the second to 1,000, which leaves no more than noise."""
    leaves = {"": 3000.0, "drive_gain": 1800.0, "brake_gain": 2000.0, "mass": 2500.0, "drive_gain brake_gain": 1780.0,
              "drive_gain mass": 1790.0, "brake_gain mass": 1000.0, "drive_gain brake_gain mass": 995.0}  # fmt: skip
    search = given(leaves, "drive_gain", "brake_gain", "mass")
    assert search.run().final.names == ("brake_gain", "mass")
    leaves |= {"drive_gain": 1250.0}
    fine = given(leaves, "drive_gain", "brake_gain", "mass")
    assert fine.run().final.names == ("drive_gain",)


def test_the_search_begins_again_once() -> None:
    """What came second in its second round leads nowhere, and what came second in its first one is not asked any more:
    with two others it would have led to 1,000, but it takes as long as the search before."""
    leaves = {"": 3000.0, "drive_gain": 1800.0, "brake_gain": 2000.0, "drive_gain mass": 1500.0,
              "drive_gain steer_ratio": 1600.0, "brake_gain steer_offset": 1000.0}  # fmt: skip
    search = given(leaves, "drive_gain", "brake_gain", "mass", "steer_ratio", "steer_offset")
    assert search.run().final.names == ("drive_gain", "mass")


class Exchanging(Given):
    """A search that always finds another effect that leaves less: the next one of its candidates."""

    def in_place_of(self, best: Trial, name: str, among: Any = None) -> list[Trial]:
        names = list(self.known)
        return [self.trial((names[names.index(name) + 1],), {})]


def test_effects_of_a_set_are_exchanged_eight_times_at_most() -> None:
    names = ("drive_gain", "brake_gain", "mass", "steer_ratio", "steer_offset", "gyro_bias", "rolling_resistance",
             "aero_drag", "viscous_resistance", "brake_fade", "body_roll")  # fmt: skip
    search = Exchanging(World({}, channels={"v": 3.0}), tried(*names))  # type: ignore[arg-type]
    search.leaves = {frozenset([name]): 2000.0 - 50.0 * k for k, name in enumerate(names)}
    assert search._contest(search.trial((names[0],), {}))[0].names == (names[8],)


def test_pairs_of_effects_of_tyres_are_tried_together() -> None:
    names = [e for e in ("tyre_saturation", "tyre_relaxation", "understeer", "cornering_compliance") if tried(e)]
    tyres = [c.name for c in tried(*names) if c.effect.tyres and not c.detail]
    if len(tyres) < 2:
        pytest.skip("the catalogue has fewer than two plain effects of tyres")
    a, b = tyres[:2]
    leaves = {frozenset(pair): 2000.0 for pair in ((x, y) for x in tyres for y in tyres if x < y)}
    search = given({"": 2000.0, **{" ".join(k): v for k, v in leaves.items()}}, *names)
    search.leaves[frozenset((a, b))] = 1000.0
    (found,) = late_pair(search, search.trial((), {}))
    assert set(found.names) == {a, b}
    search.leaves[frozenset((a, b))] = 1950.0
    assert late_pair(search, search.trial((), {})) == []
    search.leaves[frozenset((a, b))], search.vague = 1000.0, (b,)
    assert late_pair(search, search.trial((), {})) == []
