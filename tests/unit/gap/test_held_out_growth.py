"""Far from the noise, what only the fitted drive asks for makes room for what held-out drives ask for as well."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import held_out_choice
from pytest_dvp.gap.diagnose.held_out_growth import LARGEST, LOSES, MORE, SUSPECTS, TURNS, grown_for_held_out
from pytest_dvp.gap.diagnose.search import FAR, MOST, PRACTICAL, SearchResult
from tests.unit.gap.held_out_sets import COUNT, HeldOutSets, judge

BAND, HILL, TRUE = "pedal_deadband", "road_profile", "rolling_resistance"


class Sets(HeldOutSets):
    """Without an effect, what `next_to` tells of the rest pays, unless it is barred."""

    bare = False

    def __init__(self, held: dict[str, float], next_to: dict[str, str], **more: Any) -> None:
        super().__init__(held, **more)
        self.known = defaultdict(lambda: SimpleNamespace(effect=SimpleNamespace(tyres=False)))
        self.next_to = next_to
        self.instead: tuple[str, ...] = ()
        self.room: list[int] = []
        self.offers: tuple[str, ...] = ()

    def without(self, final: SimpleNamespace, name: str) -> SimpleNamespace:
        return self.trial([n for n in final.names if n != name])

    def in_place_of(self, final: SimpleNamespace, name: str) -> list[SimpleNamespace]:
        rest = [n for n in final.names if n != name]
        return [self.trial((*rest, other)) for other in self.instead if other not in final.names]

    def paying(self, now: SimpleNamespace, barred: Sequence[str], most: int) -> list[SimpleNamespace]:
        assert most == LARGEST
        return [self.trial((*now.names, name)) for name in self.offers if name not in (*now.names, *barred)]

    def grown(self, now: SimpleNamespace, turns: list[Any], barred: Sequence[str], most: int) -> SimpleNamespace:
        self.room.append(most - len(now.names))
        more = self.next_to.get(" ".join(sorted(now.names)), "")
        return self.trial((*now.names, more)) if more and more not in barred else now


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_out_choice, "refit_on_fold", lambda search, fold, trial: trial)


def after(search: Sets, names: Sequence[str], judges: int = 1) -> SearchResult:
    begin = SearchResult(search.trial(names), dict.fromkeys(names, ()), ())  # type: ignore[arg-type]
    return grown_for_held_out(search, begin, (judge(),) * judges)  # type: ignore[arg-type]


@pytest.mark.parametrize(("gain", "taken"), [(1.1 * PRACTICAL, True), (0.9 * PRACTICAL, False), (-0.5, False)])
def test_a_set_grown_anew_is_taken_where_held_out_data_clearly_gain(gain: float, taken: bool) -> None:
    search = Sets({BAND: 10.0, "": 10.0, TRUE: 10.0 - 10.0 * gain}, {"": TRUE})
    found = after(search, [BAND])
    assert found.final.names == ((TRUE,) if taken else (BAND,))
    assert found.rivals == ({TRUE: (BAND,)} if taken else {BAND: ()})
    assert search.said[0] == f"held-out data need no {BAND}: chi²/N 10"
    if not taken:  # the segments begin again where the set that stays leaves them
        assert search.settled[-1] == found.final.values


@pytest.mark.parametrize(("alone", "asked"), [(1.04, True), (1.06, False)])
def test_only_what_held_out_data_hardly_need_is_asked_for(alone: float, asked: bool) -> None:
    """Without it they are left with `alone` times as much."""
    search = Sets({BAND: 10.0, "": 10.0 * alone, TRUE: 5.0}, {"": TRUE})
    assert after(search, [BAND]).final.names == ((TRUE,) if asked else (BAND,))


def test_one_after_the_other_makes_room_and_what_went_does_not_come_back() -> None:
    held = {
        f"{BAND} {HILL}": 10.0, HILL: 9.9, BAND: 10.0, f"{TRUE} {HILL}": 9.0, f"{HILL} {TRUE}": 9.0, TRUE: 8.9,
        "road_grade " + TRUE: 7.0,
    }  # fmt: skip
    search = Sets({" ".join(sorted(k.split())): v for k, v in held.items()}, {HILL: TRUE, TRUE: "road_grade"})
    found = after(search, [BAND, HILL])
    assert found.final.names == (TRUE, "road_grade")
    assert found.rivals == {TRUE: (BAND,), "road_grade": (HILL,)}
    back = Sets({"": 9.3, BAND: 3.0, TRUE: 9.0}, {"": BAND})
    assert after(back, [TRUE]).final.names == (BAND,)
    assert after(back, [BAND]).final.names == (BAND,)
    assert back.said == [f"held-out data need no {TRUE}: chi²/N 9"]


def test_one_that_fits_less_well_in_its_place_is_asked_too_unless_it_went_before() -> None:
    """What explains the drive that is fitted best is not always what explains the next one."""
    search = Sets({BAND: 10.0, TRUE: 6.0}, {})
    search.instead = (HILL, TRUE)
    assert after(search, [BAND]).final.names == (TRUE,)
    back = Sets({BAND: 10.0, TRUE: 6.0}, {})  # in the place of the second one, the first one that went would be best
    back.held |= {" ".join(sorted((BAND, "mass"))): 3.0, HILL: 5.9, f"{HILL} {TRUE}": 1.0}
    back.instead = (TRUE, BAND)
    assert BAND not in after(back, [BAND]).final.names
    held = {f"mass {BAND}": 10.0, "mass": 10.0, BAND: 20.0, f"mass {TRUE}": 6.0, TRUE: 6.1, f"{BAND} {TRUE}": 1.0}
    two = Sets({" ".join(sorted(names.split())): left for names, left in held.items()}, {})
    two.instead = (TRUE, BAND)  # nor may it come in the place of another one, once that is hardly needed
    assert after(two, ["mass", BAND]).final.names == ("mass", TRUE)


def test_however_many_effects_there_are_some_may_come() -> None:
    names = [f"effect_{k}" for k in range(MOST + 4)]
    search = Sets({}, {})
    after(search, names)
    assert set(search.room) == {MORE}
    alone = Sets({}, {})
    after(alone, [BAND])
    assert set(alone.room) == {MOST}


def test_what_only_goes_is_left_to_the_veto() -> None:
    """It allows a loss there that is small beside what the effect gains where it is fitted."""
    assert after(Sets({BAND: 10.0, "": 5.0}, {}), [BAND]).final.names == (BAND,)
    both = Sets({BAND: 10.0, "": 5.0, TRUE: 5.0 - 0.9 * 10.0 * PRACTICAL}, {"": TRUE})
    assert after(both, [BAND]).final.names == (BAND,)
    both.held[TRUE] = 5.0 - 1.1 * 10.0 * PRACTICAL
    assert after(both, [BAND]).final.names == (TRUE,)


def test_no_more_is_tried_than_is_worth_the_time() -> None:
    names = [f"effect_{k}" for k in range(SUSPECTS + 2)]
    search = Sets({}, {})
    after(search, names)
    assert len(search.said) == SUSPECTS
    alike = Sets({}, {})  # each set with one more in the place of another is better by a tenth
    alike.trial = lambda names, values=None, zoom=False, like=None: SimpleNamespace(  # type: ignore[method-assign]
        names=tuple(names), values={"held": 10.0 * 0.9 ** sum("new" in n for n in names) * COUNT}, chi2=4.0 * COUNT
    )
    alike.in_place_of = lambda final, name: [  # type: ignore[method-assign]
        alike.trial([*(n for n in final.names if n != name), f"new_{len(alike.said)}"])
    ]
    found = after(alike, [f"effect_{k}" for k in range(TURNS + 3)]).final.names
    assert sum("new" in name for name in found) == TURNS


def test_near_the_noise_beside_a_known_remainder_and_without_other_data_nothing_is_done() -> None:
    held, following = {BAND: 10.0, "": 10.0, TRUE: 5.0}, {"": TRUE}
    assert after(Sets(held, following, level=1.01 * FAR), [BAND]).final.names == (TRUE,)
    assert after(Sets(held, following, level=FAR), [BAND]).final.names == (TRUE,)
    assert after(Sets(held, following, level=0.99 * FAR), [BAND]).final.names == (BAND,)
    assert after(Sets(held, following, excused=True), [BAND]).final.names == (BAND,)
    assert after(Sets(held, following), [BAND], judges=0).final.names == (BAND,)
    parts = (dataclasses.replace(judge(), fitted=judge().judge),)
    search = Sets(held, following)
    begin = SearchResult(search.trial([BAND]), {BAND: ()}, ())  # type: ignore[arg-type]
    assert grown_for_held_out(search, begin, parts) is begin  # type: ignore[arg-type]


@pytest.mark.parametrize(("gain", "taken"), [(1.1 * PRACTICAL, True), (0.9 * PRACTICAL, False)])
def test_below_the_noise_of_held_out_data_a_gain_counts_against_the_noise(gain: float, taken: bool) -> None:
    search = Sets({BAND: 0.5, "": 0.5, TRUE: 0.5 - gain}, {"": TRUE})
    assert after(search, [BAND]).final.names == ((TRUE,) if taken else (BAND,))


@pytest.mark.parametrize(("loss", "taken"), [(0.9 * LOSES, True), (1.1 * LOSES, False), (-0.2, True)])
def test_what_the_fitted_drive_asks_for_is_added_unless_held_out_data_lose_by_it(loss: float, taken: bool) -> None:
    search = Sets({BAND: 10.0, f"{BAND} {TRUE}": 10.0 * (1.0 + loss)}, {})
    search.offers = (TRUE,)
    found = after(search, [BAND])
    assert found.final.names == ((BAND, TRUE) if taken else (BAND,))
    assert found.rivals == ({BAND: (), TRUE: ()} if taken else {BAND: ()})
    assert search.said[0] == f"held-out data on {TRUE}, effect 2: chi²/N 10"


def test_what_held_out_data_refuse_leaves_the_place_to_the_next_one() -> None:
    search = Sets({BAND: 10.0, f"{BAND} {HILL}": 11.0, f"{BAND} {TRUE}": 9.0, f"{BAND} {HILL} {TRUE}": 8.0}, {})
    search.offers = (HILL, TRUE)
    assert after(search, [BAND]).final.names == (BAND, TRUE)


@pytest.mark.parametrize("bare", [False, True])
def test_beside_what_nearly_every_car_has_held_out_data_choose_the_next_effect(bare: bool) -> None:
    held = {BAND: 10.0, f"{BAND} {HILL}": 9.95, f"{BAND} {TRUE}": 8.0, f"{BAND} {HILL} {TRUE}": 7.9}
    search = Sets(held, {})
    search.bare = bare
    search.offers = (HILL, TRUE)
    assert after(search, [BAND]).final.names == ((BAND, TRUE, HILL) if bare else (BAND, HILL, TRUE))


def test_there_the_next_effect_is_one_of_the_three_that_pay_most() -> None:
    held = {"mass": 9.9, "gyro_bias": 9.8, HILL: 9.7, TRUE: 5.0, f"{HILL} {TRUE}": 4.0}
    search = Sets({" ".join(sorted((BAND, *names.split()))): left for names, left in held.items()} | {BAND: 10.0}, {})
    search.bare = True
    search.offers = ("mass", "gyro_bias", HILL, TRUE)
    assert after(search, [BAND]).final.names == (BAND, HILL, TRUE)


def test_it_ends_near_the_noise_and_with_as_many_effects_as_one_can_look_at() -> None:
    names = [f"effect_{k}" for k in range(2 * LARGEST)]
    search = Sets({}, {})
    search.offers = tuple(names)
    assert len(after(search, names[:1]).final.names) == LARGEST
    near = Sets({}, {}, level=0.99 * FAR)
    near.offers = tuple(names)
    assert after(near, names[:1]).final.names == (names[0],)


class Zoomed(Sets):
    """Each set knows whether its values were looked for closely, and from which set they came."""

    def trial(self, names: Sequence[str], values: Any = None, zoom: bool = False, like: Any = None) -> SimpleNamespace:
        found = super().trial(names, values, zoom, like)
        found.zoom, found.like = zoom, like
        return found


def test_a_set_that_comes_in_the_place_of_another_is_fitted_closely_at_last() -> None:
    found: Any = after(Zoomed({BAND: 10.0, "": 10.0, TRUE: 5.0}, {"": TRUE}), [BAND]).final
    assert found.names == found.like.names == (TRUE,)
    assert found.zoom
    assert not found.like.zoom
