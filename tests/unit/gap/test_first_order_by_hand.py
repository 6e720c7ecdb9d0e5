"""What effects promise to first order, on a fit with three residuals that is linear by construction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.imitation import imitation, moderated

REST = np.array([5.0, 3.0, 4.0])  # chi^2 50, of which 25 lies along what is fitted already: the first component


def plain(u: float) -> float:
    return u


def beyond_one(u: float) -> float:
    return max(u - 1.0, 0.0)


def gain(strength: Callable[[float], float] = plain, across: float = -1.0) -> FirstOrderGain:
    """An effect that changes the residuals by w (7, across, 0): of it only `across` is new.

    What is left is 25 + 2 * 3 across w + w^2: with across = -1 least at w = 3, where it is 16.
    """
    target: Any = SimpleNamespace(
        count=1, whitened=lambda values: REST + strength(values.get("a", 0.0)) * np.array([7.0, across, 0.0])
    )
    fit = SimpleNamespace(residual=REST, jacobian=np.array([[2.0, 0.0, 0.0]]))
    now: Any = SimpleNamespace(values={}, fit=fit)
    return FirstOrderGain(target, now)


def candidate(*names: str, jumps: bool = False) -> Any:
    """Coordinates that are their own units; a weaker point is the share of it."""
    key = SimpleNamespace(late=False, name="", where=False)
    coordinates = [
        SimpleNamespace(name=name, key=key, to_unit=float, value=float, within=float, jumps=jumps) for name in names
    ]
    return SimpleNamespace(
        own={}, coordinates=coordinates, weaker=lambda point, share: [{name: share * u for name, u in point.items()}]
    )


def left(found: list[tuple[float, Mapping[str, float]]]) -> list[tuple[float, float]]:
    return [(chi2, point["a"]) for chi2, point in found]


@pytest.mark.parametrize("needed", [0.0, 1.0])
def test_an_effect_that_comes_and_goes_is_followed_downhill_from_its_points(needed: float) -> None:
    found = left(gain().remaining_chi2(candidate("a", jumps=True), [{"a": 6.0}, {"a": 1.0}], needed))
    assert found[:2] == [(25.0, 6.0), (20.0, 1.0)]
    assert [value for _, value in found[2:]] == pytest.approx([3.0] * (1 if needed else 2), abs=0.031)
    assert min(found)[0] == pytest.approx(16.0, abs=0.001)


@pytest.mark.parametrize("way", [0.12, -0.12, 0.06, -0.06, 0.03, -0.03])
def test_an_effect_that_comes_and_goes_is_looked_at_in_three_distances_either_way(way: float) -> None:
    """It is of size 1 everywhere, which leaves 25 - 6 + 1, but at that distance from 1, where it is of size 3."""
    comes = gain(lambda u: 3.0 if abs(u - 1.0 - way) < 1e-9 else 1.0)
    assert left(comes.remaining_chi2(candidate("a", jumps=True), [{"a": 1.0}], 1.0)) == [
        (20.0, 1.0),
        (pytest.approx(16.0), pytest.approx(1.0 + way)),
    ]


def test_a_point_at_which_nothing_comes_says_nothing_of_the_next_one() -> None:
    found = left(gain(beyond_one).remaining_chi2(candidate("a", jumps=True), [{"a": 0.5}, {"a": 3.0}]))
    assert found[0] == (17.0, 3.0)
    assert found[-1][1] == pytest.approx(4.0, abs=0.031)  # 1 beyond what does nothing
    assert gain(beyond_one).remaining_chi2(candidate("a", jumps=True), [{"a": 0.5}]) == []


@pytest.mark.parametrize(
    ("strength", "across", "points", "expected"),
    [
        (plain, -1.0, (), []),
        (plain, -1.0, (2.0,), [(17.0, 2.0)]),
        (plain, -1.0, (2.0, 1.0), [(17.0, 2.0), (20.0, 1.0), (18.25, 1.5)]),  # and between the best and its neighbour
        (plain, -1.0, (2.5, 2.0, 1.0), [(16.25, 2.5), (17.0, 2.0), (20.0, 1.0), (16.5625, 2.25)]),
        (plain, -1.0, (6.0,), [(25.0, 6.0), (16.0, 3.0)]),  # half of the change were best
        (plain, -1.0, (6.0, 4.0), [(25.0, 6.0), (17.0, 4.0), (20.0, 5.0), (16.0, 3.0)]),
        (plain, -1.0, (3.0,), [(16.0, 3.0)]),  # as it is best: nothing weaker is hoped for
        (plain, 1.0, (2.0,), [(41.0, 2.0)]),
        (beyond_one, -1.0, (0.5,), []),
        (beyond_one, -1.0, (0.5, 3.0), []),  # weaker points come later: after one that does not show, no more
        (beyond_one, -1.0, (3.0, 0.5), [(17.0, 3.0), (21.0625, 1.75), (18.640625, 2.375)]),
        (beyond_one, -1.0, (1.5, 0.5), [(22.25, 1.5), (23.5625, 1.25), (22.890625, 1.375)]),  # 1 does not show
        (beyond_one, 1.0, (3.0, 0.5), [(41.0, 3.0), (30.0625, 1.75), (25.765625, 1.125), (27.81640625, 1.4375)]),
    ],
)  # fmt: skip
def test_what_is_left_at_points_of_an_effect(
    strength: Callable[[float], float], across: float, points: tuple[float, ...], expected: list[tuple[float, float]]
) -> None:
    found = gain(strength, across).remaining_chi2(candidate("a"), [{"a": u} for u in points])
    assert left(found) == [pytest.approx(pair, rel=1e-12) for pair in expected]


def test_an_effect_of_two_keys_has_no_neighbours_on_a_line() -> None:
    found = gain().remaining_chi2(candidate("a", "b"), [{"a": 2.0, "b": 0.0}, {"a": 1.0, "b": 0.0}])
    assert left(found) == [pytest.approx(pair) for pair in ((17.0, 2.0), (20.0, 1.0))]


@pytest.mark.parametrize(
    ("needed", "expected"),
    [
        (0.0, [(16.0, 3.0), (17.0, 2.0), (16.25, 2.5)]),
        (89.0, [(16.0, 3.0), (17.0, 2.0), (16.25, 2.5)]),  # it promises 36/4 = 9: a tenth of 90
        (91.0, [(17.0, 2.0)]),
    ],
)
def test_an_effect_without_hope_is_looked_at_once(needed: float, expected: list[tuple[float, float]]) -> None:
    found = gain().remaining_chi2(candidate("a"), [{"a": 3.0}, {"a": 2.0}], needed)
    assert left(found) == [pytest.approx(pair) for pair in expected]


def test_a_single_point_is_looked_at_whatever_it_promises() -> None:
    assert left(gain().remaining_chi2(candidate("a"), [{"a": 6.0}], 1e9)) == [(25.0, 6.0), pytest.approx((16.0, 3.0))]


def test_the_strongest_change_is_kept() -> None:
    """Square of 2 (7, -1, 0), of the last question only."""
    asked = gain()
    assert asked.strongest == 0.0
    asked.remaining_chi2(candidate("a"), [{"a": 3.0}])
    asked.remaining_chi2(candidate("a"), [{"a": 2.0}, {"a": 1.0}])
    assert asked.strongest == pytest.approx(200.0)
    asked.remaining_chi2(candidate("a"), [])
    assert asked.strongest == 0.0


# --- what a remainder imitates


def drives(rest: tuple[float, float], slope: float) -> Any:
    """Residuals that a key changes by `slope` over its range, along the first of them."""
    return SimpleNamespace(
        settle=lambda values: None,
        whitened=lambda values: np.array(rest) + np.array([slope * values.get("brake_gain.g", 0.0), 0.0]),
    )


def asked_for(points: tuple[float, ...]) -> Any:
    """A key with a range of 2 in its own unit."""
    key = SimpleNamespace(name="g", unit="-")
    c = SimpleNamespace(name="brake_gain.g", key=key, to_unit=float, value=float, slope=lambda u: 2.0)
    return SimpleNamespace(coordinates=(c,), points=[{"brake_gain.g": u} for u in points])


@pytest.mark.parametrize(
    ("rest", "slope", "points", "off"),
    [
        ((3.0, 4.0), 10.0, (0.0,), -0.6),  # -3/10 of the range, which is 2
        ((3.0, 4.0), -10.0, (0.0, 0.5, 1.0), 0.6),
        ((30.0, 4.0), 10.0, (0.0,), -2.0),  # farther than the range: at its end
        ((3.0, 4.0), 5.0, (0.0,), None),  # 25 of chi^2 are too few
        ((3.0, 4.0), 5.01, (0.0,), -6.0 / 5.01),
        ((0.0, 4.0), 10.0, (0.0,), 0.0),
    ],
)
def test_what_a_remainder_imitates(
    rest: tuple[float, float], slope: float, points: tuple[float, ...], off: float | None, monkeypatch: Any
) -> None:
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: False)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.moderated", lambda found, formal, count: found)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.rounded_imitation", lambda found: found)
    found: Any = imitation([drives(rest, slope)], [asked_for(points)])
    if off is None:
        assert found == {}
    else:
        places = 1 if len(points) == 1 else 2  # the first and the middle one
        assert found["brake_gain.g"] == pytest.approx([off] * places, rel=1e-5, abs=1e-12)


def test_what_hardly_strays_by_chance_is_moderated_by_what_all_stray() -> None:
    """Three keys stray by 2, 2 and 0 of their formal standard deviations: the median square is 4, and so of each
    4 / 0.455 = 8.8 are to be expected. Of two drives, the squares found count for 2, what is to be expected for 4."""
    formal = {("a", "k"): [1.0, 1.0], ("b", "k"): [0.1, 0.1], ("c", "k"): [1.0, 1.0]}
    found = {("a", "k"): [2.0, -2.0], ("b", "k"): [0.2, 0.2], ("c", "k"): [0.0, 0.0]}
    expected = 4.0 / 0.455
    assert moderated(found, formal, 2) == {
        ("a", "k"): [pytest.approx(np.sqrt((2.0 * 4.0 + 4.0 * expected) / 6.0))],
        ("b", "k"): [pytest.approx(0.1 * np.sqrt((2.0 * 4.0 + 4.0 * expected) / 6.0))],
        ("c", "k"): [pytest.approx(np.sqrt(4.0 * expected / 6.0))],
    }
    assert moderated({}, {}, 2) == {}
    assert moderated({("a", "k"): [3.0]}, {("a", "k"): [0.0]}, 1) == {("a", "k"): [pytest.approx(3.0 / np.sqrt(5.0))]}


def test_the_formal_deviation_of_what_is_imitated(monkeypatch: pytest.MonkeyPatch) -> None:
    """A key that changes a residual by 10 over its range of 2 is known to 0.2."""
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: False)
    seen: list[Any] = []
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.moderated", lambda *asked: seen.append(asked) or {})
    imitation([drives((3.0, 4.0), 10.0), drives((1.0, 4.0), -10.0)], [asked_for((0.0,))])
    ((found, formal, count),) = seen
    assert found["brake_gain.g"] == pytest.approx([-0.6, 0.2], rel=1e-5)
    assert formal["brake_gain.g"] == pytest.approx([0.2, 0.2], rel=1e-5)
    assert count == 2


def test_keys_that_change_other_samples_imitate_each_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """3 + 10 g and 4 - 20 h are least at -0.3 and 0.2 of a range of 2."""
    for name in ("moderated", "rounded_imitation"):
        monkeypatch.setattr(f"pytest_dvp.gap.diagnose.imitation.{name}", lambda found, *rest: found)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: False)
    group: Any = SimpleNamespace(
        settle=lambda values: None,
        whitened=lambda at: np.array([3.0 + 10.0 * at.get("g", 0.0), 4.0 - 20.0 * at.get("h", 0.0)]),
    )
    both = [SimpleNamespace(name=n, key=None, to_unit=float, value=float, slope=lambda u: 2.0) for n in "gh"]
    found: Any = imitation([group], [SimpleNamespace(coordinates=both, points=[{"g": 0.0, "h": 0.0}])])  # type: ignore[list-item]
    assert found == {"g": pytest.approx([-0.6], rel=1e-5), "h": pytest.approx([0.4], rel=1e-5)}


@pytest.mark.parametrize(
    ("smooth", "jumps", "steps"),
    [
        (4000.0, 0.0, [0.006]),  # 24 standard deviations
        (3000.0, 0.0, [0.006, 0.012]),  # 18: twice as long at least
        (1000.0, 0.0, [0.006, 0.024]),  # 6: 1.2 times as long as would do
        (0.0, 0.0, [0.006, 0.5]),
        (10.0, 0.0, [0.006, 0.5]),  # 0.06, so 2.4 of the range would do
        (100.0, 40.0, [0.006, 0.045628, 0.113056, 0.226112]),  # 3.2, 9.7 and 17.6, then 29.6
    ],
)
def test_a_slope_is_taken_over_a_step_that_is_evident(
    smooth: float, jumps: float, steps: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error that goes on in proportion in one sample, and by a root where an event comes later in others."""
    asked: list[float] = []

    def whitened(at: Mapping[str, float]) -> Any:
        u = at.get("g", 0.0)
        if u:
            asked.append(u)
        return np.array([3.0 + smooth * u, 4.0 + jumps * np.sqrt(u)])

    for name in ("moderated", "rounded_imitation"):
        monkeypatch.setattr(f"pytest_dvp.gap.diagnose.imitation.{name}", lambda found, *rest: found)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: False)
    c = SimpleNamespace(name="g", key=None, to_unit=float, value=float, slope=lambda u: 1.0)
    group: Any = SimpleNamespace(settle=lambda values: None, whitened=whitened)
    found: Any = imitation([group], [SimpleNamespace(coordinates=[c], points=[{"g": 0.0}])])  # type: ignore[list-item]
    assert asked == pytest.approx(steps, rel=1e-3)
    slope = np.array([smooth, jumps / np.sqrt(steps[-1])])
    known = bool(slope @ slope > 25.0)
    assert found == ({"g": [pytest.approx(-(slope @ [3.0, 4.0]) / (slope @ slope), rel=1e-3)]} if known else {})


@pytest.mark.parametrize(("u", "side"), [(0.49, 1.0), (0.51, -1.0)])
def test_a_slope_is_taken_towards_the_middle_of_the_range(u: float, side: float, monkeypatch: Any) -> None:
    for name in ("moderated", "rounded_imitation"):
        monkeypatch.setattr(f"pytest_dvp.gap.diagnose.imitation.{name}", lambda found, *rest: found)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: False)
    group: Any = SimpleNamespace(
        settle=lambda values: None,
        whitened=lambda at: np.array(
            [5.0 + (8000.0 if side * (at.get("g", u) - u) > 0.0 else 0.0) * (at.get("g", u) - u)]
        ),
    )
    c = SimpleNamespace(name="g", key=None, to_unit=float, value=float, slope=lambda u: 1.0)
    found: Any = imitation([group], [SimpleNamespace(coordinates=[c], points=[{"g": u}])])  # type: ignore[list-item]
    assert found == {"g": [pytest.approx(-5.0 / 8000.0, rel=1e-4)]}


@pytest.mark.parametrize(("how", "known"), [(True, False), (False, True)])
def test_a_key_that_only_says_how_imitates_nothing_alone(how: bool, known: bool, monkeypatch: Any) -> None:
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.says_how", lambda key: how)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.moderated", lambda found, formal, count: found)
    monkeypatch.setattr("pytest_dvp.gap.diagnose.imitation.rounded_imitation", lambda found: found)
    two = asked_for((0.0,))
    idle = SimpleNamespace(name="other", key=None, to_unit=float, value=float, slope=lambda u: 1.0)
    two.coordinates, two.points = (*two.coordinates, idle), [{"brake_gain.g": 0.0, "other": 0.0}]
    found: Any = imitation([drives((3.0, 4.0), 10.0)], [two])
    assert list(found) == (["brake_gain.g"] if known else [])


@pytest.mark.parametrize("why", ["own", "where"])
def test_a_point_that_changes_nothing_ends_the_look_only_where_weaker_ones_follow(why: str) -> None:
    """The model's own value lies between points, and a hill may lie at any of its places."""
    points: list[Mapping[Any, float]] = [{"a": 3.0}, {"a": 0.0}, {"a": 2.0}]
    plain, other = candidate("a"), candidate("a")
    if why == "own":
        other.own = {"a": 0.0}
    else:
        other.coordinates[0].key.where = True
    assert 2.0 not in {point["a"] for _, point in gain().remaining_chi2(plain, points)}
    assert {2.0, 3.0} <= {point["a"] for _, point in gain().remaining_chi2(other, points)}
