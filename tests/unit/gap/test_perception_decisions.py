"""What detections show of range, misses, false objects and occlusion, and when it is named: on made-up rows."""

from __future__ import annotations

from math import exp, inf, log, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.perception import diagnose_perception as module
from pytest_dvp.gap.perception.box_fit import Boxes, _of_object
from pytest_dvp.gap.perception.diagnose_perception import (
    _differs,
    _likelihood,
    _moves,
    _named,
    _near_neutral,
    _poisson,
    _Seen,
    _t,
    diagnose_perceptions,
    simulated_sensors,
)
from pytest_dvp.gap.perception.perceived_values import Perceived
from vehicle.model.effect_catalogue import find_effect

EFFECT = {name: find_effect(f"detection_{name}", ()) for name in ("latency", "range", "misses", "size", "offset")}


def seen_rows(far: Any, seen: Any, block: Any = None, thing: Any = None, **given: Any) -> _Seen:
    """Rows in the order of their distance, as `_Seen` has them."""
    found = object.__new__(_Seen)
    found.far, found.seen = np.asarray(far, dtype=float), np.asarray(seen, dtype=bool)
    found.thing = np.zeros(len(found.far), dtype=int) if thing is None else np.asarray(thing)
    found.block = np.arange(len(found.far)) if block is None else np.asarray(block)
    for name, value in given.items():
        setattr(found, name, value)
    return found


def test_the_likelihood_of_a_border_is_that_of_hits_and_misses_on_both_sides() -> None:
    """Before it a share of misses, after it a box only by chance (1 in 200); beyond it hardly any may be seen."""
    seen = np.array([True, True, False, True, *[False] * 30, True])
    found = _likelihood(seen)
    assert len(found) == len(seen) + 1
    for border in range(len(seen) + 1):
        hit, miss = int(seen[:border].sum()), int((~seen[:border]).sum())
        later, unseen = int(seen[border:].sum()), int((~seen[border:]).sum())
        share = min(max(miss / max(border, 1), 1e-4), 1.0 - 1e-4)
        value = hit * log(1.0 - share) + miss * log(share) + later * log(0.005) + unseen * log(0.995)
        too_much = later > 0.05 * (len(seen) - border)
        assert found[border] == (-inf if too_much else pytest.approx(value))
    assert np.isinf(found[3])
    assert np.isfinite(found[4])
    assert np.isinf(_likelihood(np.array([*[False] * 18, True]))[0])
    assert np.isfinite(_likelihood(np.array([*[False] * 19, True]))[0])


def test_quantiles_are_students_and_rates_have_garwoods_interval() -> None:
    assert _t(2) == pytest.approx(12.706, abs=1e-3)
    assert _t(11) == pytest.approx(2.228, abs=1e-3)
    assert _t(1) == _t(2)
    assert _poisson(0, 10.0) == pytest.approx((0.0, 0.0, -log(0.025) / 10.0))
    rate, low, high = _poisson(3, 2.0)
    assert rate == 1.5
    mean = 2.0 * high  # at the ends, 3 or fewer and 3 or more have a chance of 2.5 %
    assert exp(-mean) * (1.0 + mean + mean**2 / 2.0 + mean**3 / 6.0) == pytest.approx(0.025)
    mean = 2.0 * low
    assert 1.0 - exp(-mean) * (1.0 + mean + mean**2 / 2.0) == pytest.approx(0.025)


def ranged(before: int, after: int, *, blocks: int = 2) -> _Seen:
    """All seen up to 50 m, nothing beyond, a row a metre... of two objects that both cross the border."""
    n = before + after
    far = 50.5 - before + np.arange(n)
    block = np.minimum(np.arange(n) // max(1, n // 20), 10**6)
    block[before:] = np.arange(after) % blocks + 5000
    return seen_rows(far, np.arange(n) < before, block, np.arange(n) % 2)


def test_a_range_is_halfway_between_the_last_that_is_seen_and_the_first_that_is_not() -> None:
    found = ranged(40, 40)
    reach, low, high, gained, never = found._range()
    assert reach == pytest.approx(50.0)
    assert gained == pytest.approx(40 * log(0.9999) + 40 * log(0.995) - 40 * log(0.5) - 40 * log(0.5))
    assert never == 0.0
    likelihood = _likelihood(found.seen)
    likely = [k for k in range(81) if likelihood[k] > likelihood[40] - 3.0]
    around = found._between_objects(50.0)
    assert low == pytest.approx(min(found.far[likely[0] - 1], 50.0 - around))
    assert high == pytest.approx(max(found.far[likely[-1]], 50.0 + around))


def test_each_object_left_out_moves_the_border() -> None:
    """Objects 0 and 1 take turns a metre apart: without 0 the border lies between 49.5 + ... of 1 alone."""
    found = ranged(40, 40)
    moved = []
    for k in (0, 1):
        far = found.far[found.thing != k]
        moved.append(0.5 * (far[far < 50.0].max() + far[far > 50.0].min()))
    expected = 1.96 * sqrt(0.5 * sum((m - np.mean(moved)) ** 2 for m in moved))
    assert found._between_objects(50.0) == pytest.approx(expected)
    one = seen_rows(found.far, found.seen, found.block)
    assert one._between_objects(50.0) == 2.0
    assert (one._crosses(0, 50.0), one._crosses(0, 10.5), one._crosses(0, 90.0)) == (True, False, False)
    near = seen_rows(found.far, found.seen, found.block, np.where(found.far < 50.0, 0, np.arange(80) % 2))
    assert near._between_objects(50.0) == 2.0


@pytest.mark.parametrize(("blocks", "told"), [(2, True), (1, False)])
def test_a_range_needs_two_blocks_in_which_nothing_is_seen(blocks: int, told: bool) -> None:
    found = ranged(40, 40, blocks=blocks)._range()
    assert np.isfinite(found[0]) == told
    if not told:
        likelihood = _likelihood(ranged(40, 40).seen)
        assert found == (inf, 49.5, inf, 0.0, pytest.approx(0.5 * (likelihood[-1] - 80 * log(0.5))))


@pytest.mark.parametrize("after", [1, 2, 3, 4, 5])
def test_a_range_must_be_ten_times_as_likely_in_logarithms_as_none(after: int) -> None:
    found = ranged(40, after)
    likelihood = _likelihood(found.seen)
    assert np.isfinite(found._range()[0]) == (likelihood[40] - likelihood[-1] >= 10.0)
    assert {bool(np.isfinite(ranged(40, n)._range()[0])) for n in (2, 5)} == {True, False}


def test_no_rows_and_nothing_seen_show_no_range() -> None:
    assert seen_rows([], [])._range() == (inf, 0.0, inf, 0.0, 0.0)
    nothing = seen_rows(np.arange(50.0), np.zeros(50))
    assert nothing._range() == (inf, 0.0, inf, 0.0, pytest.approx(0.5 * 50 * (log(0.9999) - log(0.5))))
    every = seen_rows(np.arange(50.0), np.ones(50))
    assert every._range()[:4] == (inf, 49.0, inf, 0.0)


def test_misses_are_a_share_within_the_range_with_the_error_of_blocks() -> None:
    block = np.repeat([0, 1, 2, 3], 25)
    seen = np.ones(100)
    seen[[0, 1, 2, 3, 4, 5, 30, 60]] = 0.0
    found = seen_rows([*[10.0] * 99, 99.0], [*seen[:99], 0.0], block)
    rate, spread, gained = found._misses(50.0)
    assert rate == pytest.approx(8 / 99)
    sums = [6 - 25 * rate, 1 - 25 * rate, 1 - 25 * rate, 0 - 24 * rate]
    clustered = sqrt(sum(s * s for s in sums) * 4 / 3) / 99
    assert spread == pytest.approx(max(clustered, sqrt(rate * (1.0 - rate) / 99)))
    assert spread == pytest.approx(clustered)
    assert gained == pytest.approx(8 * log(rate / 0.005) + 91 * log(1.0 - rate))
    even = seen_rows(np.full(100, 10.0), np.tile([*[True] * 9, False], 10), np.repeat([0, 1], 50))
    assert even._misses(50.0)[1] == pytest.approx(sqrt(0.09 / 100))
    none = seen_rows(np.full(100, 10.0), np.ones(100), block)
    assert none._misses(50.0) == (0.0, pytest.approx(sqrt(0.01 / 100)), 0.0)
    assert found._misses(5.0) == (0.0, inf, 0.0)
    rare = seen_rows(np.full(1000, 10.0), np.arange(1000) > 0)
    assert rare._misses(50.0)[2] == 0.0  # one in a thousand is less likely as misses than as chance
    all_missed = seen_rows(np.full(10, 10.0), np.zeros(10))
    assert all_missed._misses(50.0)[2] == pytest.approx(10 * log(200.0))


def hidden(share: Any, seen: Any, distance: Any = 10.0) -> _Seen:
    share, seen = np.atleast_2d(share).astype(float), np.atleast_2d(seen).astype(bool)
    pairs = SimpleNamespace(hidden=share, seen=seen, distance=np.full(share.shape, 1.0) * distance)
    return seen_rows([], [], p=pairs, partly=np.ones(share.shape, dtype=bool))


def test_occlusion_is_the_share_up_to_which_an_object_is_seen() -> None:
    share = np.linspace(0.06, 0.96, 31)
    order = np.random.default_rng(0).permutation(31)
    value, low, high, gained = hidden(share[order], (share < 0.5)[order])._occlusion(50.0)
    assert value == pytest.approx(0.5 * (share[14] + share[15]))
    likelihood = _likelihood(share < 0.5)
    assert gained == pytest.approx(likelihood[15] - likelihood[-1])
    likely = [k for k in range(32) if likelihood[k] > likelihood[15] - 3.0]
    assert low == pytest.approx(min(share[likely[0] - 1], value - 0.1))
    assert high == pytest.approx(max(share[likely[-1]], value + 0.1))
    early, low, _, _ = hidden(share, share < 0.07)._occlusion(50.0)
    assert (early, low) == (pytest.approx(0.075), 0.0)
    assert hidden(share, np.ones(31))._occlusion(50.0) == (1.0, pytest.approx(0.96), 1.0, 0.0)
    assert np.isnan(hidden(share, share < 0.5, distance=51.0)._occlusion(50.0)[0])


@pytest.mark.parametrize(("rows", "told"), [(20, True), (19, False)])
def test_occlusion_needs_twenty_rows_partly_behind_others(rows: int, told: bool) -> None:
    share = np.linspace(0.1, 0.9, rows)
    found = hidden(share, share < 0.5)._occlusion(50.0)
    assert np.isfinite(found[0]) == told
    assert told or found[1:] == (0.0, 1.0, 0.0)


@pytest.mark.parametrize("last", [1, 2, 3])
def test_a_border_of_occlusion_is_twenty_times_as_likely_as_none(last: int) -> None:
    """Of 30 rows, the last few are not seen."""
    share = np.linspace(0.1, 0.9, 30)
    seen = np.arange(30) < 30 - last
    likelihood = _likelihood(seen)
    gained = likelihood[30 - last] - likelihood[-1]
    found = hidden(share, seen)._occlusion(50.0)
    assert (found[0] < 1.0) == (gained >= 3.0)
    if gained < 3.0:
        assert found[1] == pytest.approx(share[29 - last])


def a_position(loss: dict[tuple[int, ...], float], blocks: int = 10, latency: float = 0.1) -> Any:
    return SimpleNamespace(spread=np.array([latency, 0.2, 0.3]), noise=np.array([0.1, 0.02]), noise_worth=lambda: 7.0,
                           noise_spread=np.array([0.01, 0.003]), loss=lambda place, without: loss[without],
                           levels=lambda: None,
                           blocks=np.repeat(np.arange(blocks), 2))  # fmt: skip


@pytest.mark.parametrize(
    ("both", "lost", "blocks", "rivals"),
    [(100.0, 1.9, 10, True), (100.0, 2.1, 10, False), (20.1, 0.3, 10, True), (19.9, 0.3, 10, False),
     (1000.0, 19.0, 10, True), (1100.0, 21.0, 10, False), (1100.0, 21.0, 11, True)],
)  # fmt: skip
def test_latency_and_offset_are_rivals_if_one_can_stand_in_for_the_other(
    both: float, lost: float, blocks: int, rivals: bool
) -> None:
    loss = {(0, 1, 2): both, (0,): lost, (1, 2): 0.9 * both}
    found = seen_rows([], [], fitted=a_position(loss, blocks), place=np.zeros(3))._position_rivals()
    assert found == ({"detection_latency": ("detection_offset",)} if rivals else {})
    other = seen_rows([], [], fitted=a_position({**loss, (0,): 0.9 * both, (1, 2): lost}, blocks), place=np.zeros(3))
    assert other._position_rivals() == ({"detection_offset": ("detection_latency",)} if rivals else {})
    still = seen_rows([], [], fitted=a_position(loss, latency=inf), place=np.zeros(3))
    assert still._position_rivals() == {"detection_offset": ("detection_latency",)}


class Told(_Seen):
    """What is put together, from parts that are given."""

    def __init__(self, gained: float, alone: float, rate: float, false: int = 0, latency: float = 0.1) -> None:
        loss = {(0, 1, 2): 3.0, (0,): 5.0, (1, 2): 6.0}
        self.fitted, self.place = a_position(loss, latency=latency), np.array([0.05, 0.4, -0.2])
        self.boxes: Any = SimpleNamespace(objects=4, mean=np.array([1.1, 0.9, 0.05]),
                                          spread=np.array([0.02, 0.03, 0.01]), worth=np.array([2.0, 3.0]))  # fmt: skip
        self.far, self.block = np.array([1.0, 2.0, 3.0, 99.0]), np.array([0, 1, 1, 2])
        self.p: Any = SimpleNamespace(false=false)
        self.f: Any = SimpleNamespace(duration=20.0)
        self.gained, self.alone, self.rate = gained, alone, rate

    def _range(self) -> Any:
        return 50.0, 48.0, 53.0, self.gained, self.alone

    def _misses(self, reach: float) -> Any:
        return self.rate, 0.02, 4.0

    def _behind(self) -> Any:
        return None

    def _occlusion(self, reach: float) -> Any:
        return (0.5, 0.4, 0.6, 8.0) if self.rate else (float("nan"), 0.0, 1.0, 0.0)


def test_everything_is_put_together_with_students_intervals() -> None:
    found = Told(30.0, 0.0, 0.1, false=6).perceived()
    wide = _t(10)
    assert found.values["detection_latency", "T"] == pytest.approx((0.05, 0.0, 0.05 + wide * 0.1))
    assert found.values["detection_offset", "x"] == pytest.approx((0.4, 0.4 - wide * 0.2, 0.4 + wide * 0.2))
    assert found.values["detection_offset", "y"] == pytest.approx((-0.2, -0.2 - wide * 0.3, -0.2 + wide * 0.3))
    assert found.values["detection_noise", "sigma0"] == pytest.approx((0.1, 0.1 - wide * 0.01, 0.1 + wide * 0.01))
    assert found.values["detection_noise", "slope"] == pytest.approx((0.02, 0.02 - wide * 0.003, 0.02 + wide * 0.003))
    assert found.values["detection_range", "R"] == (50.0, 48.0, 53.0)
    assert found.values["detection_misses", "rate"] == pytest.approx((0.1, 0.0, 0.1 + _t(2) * 0.02))
    few = _t(4)
    assert found.values["detection_size", "length_ratio"] == pytest.approx((1.1, 1.1 - few * 0.02, 1.1 + few * 0.02))
    assert found.values["detection_size", "width_ratio"] == pytest.approx((0.9, 0.9 - few * 0.03, 0.9 + few * 0.03))
    assert found.values["detection_yaw", "b"] == pytest.approx((0.05, 0.05 - few * 0.01, 0.05 + few * 0.01))
    assert found.values["detection_occlusion", "share"] == (0.5, 0.4, 0.6)
    assert found.values["detection_false", "rate"] == _poisson(6, 20.0)
    assert found.worth == pytest.approx({
        "detection_latency": 5.0, "detection_offset": 6.0, "detection_noise": 7.0, "detection_range": 30.0,
        "detection_misses": 4.0, "detection_size": 2.0, "detection_yaw": 3.0, "detection_occlusion": 8.0,
        "detection_false": 6.0 * log(0.3 / 1e-3),
    })  # fmt: skip
    assert found.rivals == {}
    assert Told(30.0, 0.0, 0.1).perceived().worth["detection_false"] == 0.0
    bare = Told(30.0, 0.0, 0.0, latency=inf)
    bare.boxes.objects = 0
    absent = {"detection_latency", "detection_size", "detection_yaw", "detection_occlusion"}
    assert not absent & {name for name, _ in bare.perceived().values}


@pytest.mark.parametrize(
    ("gained", "alone", "rate", "rivals"),
    [(1.9, 0.0, 0.1, True), (2.0, 0.0, 0.1, False), (2.9, 1.0, 0.1, True), (3.1, 1.0, 0.1, False),
     (0.0, 0.0, 0.1, False), (1.9, 0.0, 0.0, False)],
)  # fmt: skip
def test_a_range_that_brings_little_more_than_misses_has_them_as_a_rival(
    gained: float, alone: float, rate: float, rivals: bool
) -> None:
    found = Told(gained, alone, rate).perceived().rivals
    assert found == ({"detection_range": ("detection_misses",)} if rivals else {})


class Model:
    """A model with the values that are given."""

    def __init__(self, **values: float) -> None:
        self.values = {(n.partition("__")[0], n.partition("__")[2]): v for n, v in values.items()}
        self.effects = [SimpleNamespace(name=name) for name, _ in self.values]

    def value(self, name: str, key: str) -> float | None:
        return self.values.get((name, key))


def perceived(name: str, key: str, *value: float) -> Perceived:
    return Perceived({(name, key): value}, {}, {})  # type: ignore[dict-item]


@pytest.mark.parametrize(
    ("value", "low", "high", "differs"),
    [(0.021, 0.01, 0.03, True), (0.019, 0.01, 0.03, False), (0.05, 0.001, 0.1, True), (0.05, -0.001, 0.1, False),
     (0.05, 0.049, 0.4, True)],
)  # fmt: skip
def test_an_effect_differs_by_its_least_size_and_beyond_its_interval(
    value: float, low: float, high: float, differs: bool
) -> None:
    found = perceived("detection_latency", "T", value, low, high)
    assert _differs(found, None, Model(), EFFECT["latency"], "T") is differs  # type: ignore[arg-type]
    given = Model(detection_latency__T=0.3)
    below = perceived("detection_latency", "T", 0.3 - value, 0.3 - high, 0.3 - low)
    assert _differs(below, None, given, EFFECT["latency"], "T") is differs  # type: ignore[arg-type]


@pytest.mark.parametrize(("away", "differs"), [(0.0501, True), (0.0499, False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_two_logs_differ_by_more_than_both_intervals_in_squares(away: float, differs: bool, side: float) -> None:
    twin = perceived(
        "detection_latency", "T", 0.2, 0.2 - (0.04 if side < 0 else 9.0), 0.2 + (0.04 if side > 0 else 9.0)
    )
    value = 0.2 + side * away
    found = perceived("detection_latency", "T", value, value - (0.03 if side > 0 else 9.0),
                      value + (0.03 if side < 0 else 9.0))  # fmt: skip
    assert _differs(found, twin, Model(), EFFECT["latency"], "T") is differs  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("value", "low", "high", "base", "differs"),
    [
        (inf, 32.1, inf, 30.0, True),
        (inf, 31.9, inf, 30.0, False),
        (30.0, 25.0, 32.0, inf, True),
        (inf, 80.0, inf, inf, False),
    ],
)
def test_a_range_that_is_beyond_what_was_seen_differs_from_a_nearer_one(
    value: float, low: float, high: float, base: float, differs: bool
) -> None:
    found = perceived("detection_range", "R", value, low, high)
    given = Model(detection_range__R=base)
    assert _differs(found, None, given, EFFECT["range"], "R") is differs  # type: ignore[arg-type]
    unknown = perceived("detection_range", "R", inf, 45.0, inf)
    near = perceived("detection_range", "R", 40.0, 38.0, 42.9)
    assert _differs(near, unknown, given, EFFECT["range"], "R") is True  # type: ignore[arg-type]
    nearer = perceived("detection_range", "R", 40.0, 38.0, 43.1)
    assert _differs(nearer, unknown, given, EFFECT["range"], "R") is False  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("has", "value", "moves"),
    [
        (None, 0.02, True),
        (None, 0.019, False),
        (0.2, 0.2201, True),
        (0.2, 0.19, False),
        (0.2, 0.2, False),
        (0.0, inf, True),
    ],
)
def test_a_model_that_needs_another_value_is_moved(has: float | None, value: float, moves: bool) -> None:
    given = Model() if has is None else Model(detection_latency__T=has)
    seen = perceived("detection_latency", "T", value, 0.0, 1.0)
    assert _moves(seen, given, EFFECT["latency"]) is moves  # type: ignore[arg-type]
    assert _moves(Perceived({}, {}, {}), given, EFFECT["latency"]) is False  # type: ignore[arg-type]


def test_an_effect_of_two_keys_moves_with_either() -> None:
    seen = Perceived({("detection_offset", "x"): (0.0, 0.0, 0.0), ("detection_offset", "y"): (0.3, 0.0, 0.5)}, {}, {})
    assert _moves(seen, Model(), EFFECT["offset"]) is True  # type: ignore[arg-type]


@pytest.mark.parametrize(("value", "near"), [(1.0, True), (1.0499, True), (0.95, False), (1.0501, False)])
def test_near_neutral_is_within_the_least_size_that_is_worth_a_name(value: float, near: bool) -> None:
    assert _near_neutral(EFFECT["size"], "length_ratio", Estimate(value, 0.0, 2.0, "-")) is near
    assert _near_neutral(EFFECT["range"], "R", Estimate(inf, 0.0, inf, "m")) is True


def test_what_is_named_says_what_to_do_and_what_speaks_against_it() -> None:
    seen = perceived("detection_misses", "rate", 0.01, 0.0, 0.03)
    kept = _named("detection_misses", seen, Model(), EFFECT["misses"], 0.4)  # type: ignore[arg-type]
    assert (kept.action, kept.gain, kept.standing, kept.doubts) == ("add", 0.4, "confirmed", ())
    given = Model(detection_misses__rate=0.2)
    assert _named("detection_misses", seen, given, EFFECT["misses"], 0.4).action == "remove"  # type: ignore[arg-type]
    more = Perceived({("detection_misses", "rate"): (0.1, 0.0, 0.2)}, {}, {"detection_misses": ("a", "b")})
    found = _named("detection_misses", more, given, EFFECT["misses"], 0.4)  # type: ignore[arg-type]
    assert (found.action, found.standing, found.rivals) == ("change", "provisional", ("a", "b"))
    assert found.doubts == ("these data cannot tell it from a, b",)
    assert found.parameters["rate"] == Estimate(0.1, 0.0, 0.2, "-")


def an_effect(name: str, gain: float, *width: float, value: float = 0.0) -> NamedEffect:
    parameters = {str(k): Estimate(value, 0.0, w, "m") for k, w in enumerate(width)}
    return NamedEffect(
        name=name, parameters=parameters, rivals=(), gain=gain, action="add", standing="confirmed", doubts=()
    )


def test_of_several_logs_the_narrowest_interval_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the widest of its values; one without a border is wider than all."""
    by_log = {"a": (an_effect("x", 0.5, 1.0, 3.0), an_effect("y", 0.4, 1.0)),
              "b": (an_effect("x", 0.4, 2.0, 2.0), an_effect("y", 0.9, 0.5, value=inf),
                    an_effect("c", 0.4, 1.0))}  # fmt: skip
    asked = []

    def diagnose(measured: Any, model: Any, *, twin: Any) -> Any:
        asked.append(twin)
        return by_log[measured.meta["name"]]

    monkeypatch.setattr(module, "diagnose_perception", diagnose)
    logs: Any = [SimpleNamespace(meta={"name": "a", "scenario": "s"}), SimpleNamespace(meta={"name": "b"})]
    found = diagnose_perceptions(logs, None, {"s": "the twin"})  # type: ignore[arg-type, dict-item]
    assert asked == ["the twin", None]
    assert [(e.name, e.gain, len(e.parameters)) for e in found] == [("c", 0.4, 1), ("x", 0.4, 2), ("y", 0.4, 1)]
    assert simulated_sensors(SimpleNamespace(meta={"stage": "pe"})) is True  # type: ignore[arg-type]
    assert simulated_sensors(logs[0]) is False


def boxes(count: int, rows: int = 12, **given: Any) -> tuple[Any, Any]:
    """Cars whose boxes are longer, narrower and turned, each by a little more than the one before."""
    fields = {"kind": "vehicle", "length": 4.0, "width": 2.0, "far": 25.0, "scatter": 0.001} | given
    n = count * rows
    thing = np.repeat(np.arange(count), rows)
    wave = np.tile(np.linspace(-1.0, 1.0, rows), count)
    yaw = 0.5 * np.arange(rows)
    table = SimpleNamespace(
        length=fields["length"] * (1.1 + 0.01 * thing) + fields["scatter"] * wave,
        width=fields["width"] * (0.8 - 0.01 * thing) + fields["scatter"] * wave,
        yaw=np.tile(yaw, count) + 0.1 + 0.01 * thing + np.pi * (np.arange(n) % 3),
    )
    track = SimpleNamespace(kind=fields["kind"], length=fields["length"], width=fields["width"], t=np.arange(rows),
                            yaw=np.angle(np.exp(1j * yaw)))  # fmt: skip
    log = SimpleNamespace(objects={str(k): track for k in range(count)}, detections=table)
    frames = SimpleNamespace(log=log, t=np.arange(float(rows)))
    row = np.arange(n).reshape(count, rows).T
    pairs = SimpleNamespace(seen=np.ones((rows, count), dtype=bool), row=row,
                            distance=np.full((rows, count), fields["far"]))  # fmt: skip
    return frames, pairs


def test_size_and_turn_of_boxes_are_medians_over_objects() -> None:
    found = Boxes(*boxes(5))
    assert found.objects == 5
    assert found.mean == pytest.approx([1.12, 0.78, 0.12], abs=1e-9)
    scatter = [0.02, 0.02, 1.4826 * 0.01]
    assert found.spread == pytest.approx(np.sqrt(0.5 * np.pi / 5) * np.array(scatter))
    off = np.array([0.12, -0.22, 0.12]) / found.spread
    assert found.worth == pytest.approx([0.5 * (off[0] ** 2 + off[1] ** 2), 0.5 * off[2] ** 2])


@pytest.mark.parametrize(
    ("given", "told"),
    [({"count": 3}, True), ({"count": 2}, False), ({"rows": 10}, True), ({"rows": 9}, False), ({"far": 25.1}, False),
     ({"kind": "pedestrian"}, False), ({"width": 0.0}, False), ({"length": 0.0}, False), ({"scatter": 0.0}, False)],
)  # fmt: skip
def test_boxes_tell_sizes_of_three_cars_nearby_with_ten_boxes_each(given: dict[str, Any], told: bool) -> None:
    found = Boxes(*boxes(**({"count": 3} | given)))
    assert (found.objects == 3) is told
    if not told:
        assert (found.mean.tolist(), found.spread.tolist(), found.worth.tolist()) == (
            [1.0, 1.0, 0.0],
            [0.0] * 3,
            [0.0] * 2,
        )


def test_the_turn_of_a_late_box_is_that_against_its_object_at_the_time_it_shows() -> None:
    """Objects that turn by 0.5 rad a second, boxes of 0.2 s ago: they are 0.1 rad behind, and yet not turned."""
    frames, pairs = boxes(3, rows=40)
    frames.log.detections.yaw -= 0.1 + 0.01 * np.repeat(np.arange(3), 40) + 0.1
    assert Boxes(frames, pairs, 0.2).mean[2] == pytest.approx(0.0, abs=0.003)  # the first box has none before it
    assert Boxes(frames, pairs).mean[2] == pytest.approx(-0.1, abs=1e-9)


def test_boxes_without_a_length_tell_nothing() -> None:
    frames, pairs = boxes(3)
    frames.log.detections.length[5] = 0.0
    assert _of_object(frames, pairs, 0, "0") is None
    assert _of_object(frames, pairs, 1, "1") is not None


def test_rows_in_clear_view_are_put_in_the_order_of_their_distance() -> None:
    """Two objects, two frames in blocks of five seconds; one is partly hidden at first, one row is out of view."""
    pairs: Any = SimpleNamespace(
        hidden=np.array([[0.05, 0.051], [0.0, 0.0]]), distance=np.array([[30.0, 5.0], [20.0, 40.0]]),
        seen=np.array([[True, True], [False, True]]), in_field_of_view=lambda: np.array([[True, True], [True, False]]),
    )  # fmt: skip
    none: Any = SimpleNamespace(objects={}, detections=None)
    found = _Seen(SimpleNamespace(t=np.array([4.9, 5.1]), log=none), pairs, "fit", np.zeros(3))  # type: ignore[arg-type]
    assert found.far.tolist() == [20.0, 30.0]
    assert found.seen.tolist() == [False, True]
    assert (found.block.tolist(), found.thing.tolist()) == ([1000, 0], [0, 0])
    assert found.partly.tolist() == [[False, True], [False, False]]
