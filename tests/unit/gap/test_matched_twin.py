"""Of a twin with a known remainder: what may be removed, what is a fragment of the remainder, what is a rival."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import held_out, removal, rivals, veto
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.removal import removed_effect
from pytest_dvp.gap.diagnose.rivals import rivals_over_segments
from pytest_dvp.gap.diagnose.search import SearchResult
from pytest_dvp.gap.diagnose.standing import ABOVE_REMAINDER
from vehicle.model.effect_catalogue import catalogue

COUNT = 1000
SEGMENTS = 20


class Found:
    """A search with known gains: chi^2 that each effect takes away where it is fitted and on the data held out, spread
    evenly over the segments."""

    def __init__(self, fitted: dict[str, float], held: dict[str, float], *, excused: bool = True, misfit: bool = False):
        self.fitted, self.held, self.count = fitted, held, COUNT
        self.target = SimpleNamespace(excused=excused)
        self.over, self.left = misfit, 0.0
        self.others: dict[str, list[SimpleNamespace]] = {}

    def trial(
        self, names: tuple[str, ...], values: Any = None, zoom: bool = False, like: Any = None
    ) -> SimpleNamespace:
        rest = [name for name in self.fitted if name not in names]
        chi2 = COUNT * (1.0 + self.left + sum(self.fitted[n] for n in rest))
        held = COUNT * (1.0 + sum(self.held[n] for n in rest))
        return SimpleNamespace(names=tuple(names), chi2=chi2, values={"held": held},
                               segment_chi2=np.full(SEGMENTS, chi2 / SEGMENTS))  # fmt: skip

    def finds(self, grown: Any) -> None:
        """Asked once more, it finds this."""
        self.start: dict[Any, float] = {}
        self.tick = lambda text: None
        self.grown, self.credible_set = grown, lambda best: best

    def nothing_else_found(self) -> None:
        self.finds(lambda now, turns, barred=(): now)

    def without(self, best: SimpleNamespace, name: str) -> SimpleNamespace:
        return self.trial(tuple(n for n in best.names if n != name))

    def misfit(self, best: SimpleNamespace) -> bool:
        return self.over

    def in_place_of(self, best: SimpleNamespace, name: str) -> list[SimpleNamespace]:
        return self.others.get(name, [])

    def is_rival(self, best: SimpleNamespace, other: SimpleNamespace, name: str) -> bool:
        return True

    def is_credible(self, trial: Any, name: str) -> bool:
        return True

    @staticmethod
    def bootstrap_share(worse: np.ndarray, better: np.ndarray) -> float:
        draws = np.random.default_rng(1).multinomial(len(worse), np.full(len(worse), 1.0 / len(worse)), size=400)
        return float(np.mean(draws @ (worse - better) > 0.0))


def judge() -> Fold:
    """Held-out data that know what each set leaves of them."""
    of = SimpleNamespace(
        count=COUNT,
        whitened=lambda values: np.array([np.sqrt(values["held"])]),
        by_segment=lambda r: np.full(SEGMENTS, float(r @ r) / SEGMENTS),
    )
    return Fold(None, of)  # type: ignore[arg-type]


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (veto, held_out, rivals):
        monkeypatch.setattr(module, "fold_excites", lambda *_: True)
        monkeypatch.setattr(module, "refit_on_fold", lambda search, fold, trial, without="": trial)
    monkeypatch.setattr(veto, "is_beyond_remainder", lambda *_: False)
    monkeypatch.setattr(veto, "is_imitated", lambda *_: False)
    monkeypatch.setattr(veto, "is_clear", lambda *_: False)
    monkeypatch.setattr(veto, "is_evident_apart", lambda *_: False)
    monkeypatch.setattr(veto, "quiet", lambda *_: None)
    monkeypatch.setattr(veto, "as_told", lambda search, trial: trial)
    monkeypatch.setattr(veto, "chosen", lambda search, found, judges: found)
    monkeypatch.setattr(veto, "grown_for_held_out", lambda search, found, judges: found)
    monkeypatch.setattr(veto, "refined", lambda search, best, rivals: best)


def judged(search: Found) -> tuple[str, ...]:
    found = SearchResult(search.trial(tuple(search.fitted)), {}, ())  # type: ignore[arg-type]
    return veto.judged(search, found, (judge(),), lambda: ()).found.final.names  # type: ignore[arg-type]


def test_what_gains_no_more_than_the_remainder_changes_by_is_taken_out() -> None:
    little = 0.9 * ABOVE_REMAINDER
    assert judged(Found({"mass": 1.0, "roll": little}, {"mass": 1.0, "roll": little})) == ("mass",)
    assert judged(Found({"mass": 1.0, "roll": little}, {"mass": 1.0, "roll": little}, excused=False)) == (
        "mass",
        "roll",
    )


def test_what_explains_much_where_it_is_fitted_is_no_fragment() -> None:
    assert judged(Found({"steer_sticking": 3.0 * ABOVE_REMAINDER}, {"steer_sticking": 0.01})) == ("steer_sticking",)


def test_unless_it_is_no_larger_than_what_the_remainder_imitates(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compliance of 0.0005 rad/kN, where two drives with nothing new gave 0.0004: it halved the error of one drive
    and took nothing off the other."""
    monkeypatch.setattr(veto, "is_imitated", lambda search, trial, name: name == "steer_compliance")
    much = 3.0 * ABOVE_REMAINDER
    assert judged(Found({"steer_compliance": much}, {"steer_compliance": 0.01})) == ()
    assert judged(Found({"steer_compliance": much}, {"steer_compliance": much})) == ("steer_compliance",)


@pytest.mark.parametrize(("held", "kept"), [(-0.04, True), (-0.06, False)])
def test_what_is_clear_the_remainder_may_lose_a_little_where_it_hardly_acts(
    monkeypatch: pytest.MonkeyPatch, held: float, kept: bool
) -> None:
    """A steering that sticks after a standstill: seen in one drive, absent in the other; a loss of 5 % is let pass."""
    for rule in ("is_clear", "is_beyond_remainder"):
        monkeypatch.setattr(veto, rule, lambda search, trial, name, *_: name == "steer_sticking")
    assert judged(Found({"steer_sticking": 1.0}, {"steer_sticking": held})) == (("steer_sticking",) if kept else ())
    assert judged(Found({"steer_sticking": 0.3}, {"steer_sticking": 0.0})) == ("steer_sticking",)
    assert judged(Found({"roll": 1.0}, {"roll": held})) == ()


@pytest.mark.parametrize(("left", "loss", "stays"), [(1.5, 0.19, True), (1.5, 0.21, False), (0.5, 0.19, False)])
def test_far_from_the_noise_a_fifth_of_a_gain_may_be_lost(left: float, loss: float, stays: bool) -> None:
    """Beside a mass, an effect gains 1 where it is fitted; chi^2/N is 2.5 or 1.5 with it."""
    search = Found({"mass": 3.0, "steer_rate_limit": 1.0}, {"mass": 3.0, "steer_rate_limit": -loss}, excused=False)
    search.left = left
    assert ("steer_rate_limit" in judged(search)) is stays


def test_what_is_left_without_the_vetoed_ones_may_hide_another(monkeypatch: pytest.MonkeyPatch) -> None:
    search = Found({"roll": 0.3, "gyro_bias": 1.0}, {"roll": 0.0, "gyro_bias": 1.0})
    monkeypatch.setattr(veto, "quiet", lambda search, left, judges: search.trial(("gyro_bias",)))
    found = SearchResult(search.trial(("roll",)), {}, ())  # type: ignore[arg-type]
    names = veto.judged(search, found, (judge(),), lambda: ()).found.final.names  # type: ignore[arg-type]
    assert names == ("gyro_bias",)


def test_where_too_much_is_left_the_best_name_is_still_told() -> None:
    search = Found({"imu_misalignment": 0.15, "roll": 0.15}, {"imu_misalignment": 0.12, "roll": 0.001}, misfit=True)
    assert judged(search) == ("imu_misalignment",)


@pytest.mark.parametrize(
    ("fitted", "held", "kept"),
    [
        (2.1 * ABOVE_REMAINDER, 0.0, True),  # more than the remainder makes, and nothing held out shows it
        (1.9 * ABOVE_REMAINDER, 0.0, False),  # so little, the remainder may make
        (1.0, -0.009, True),
        (1.0, -0.011, False),  # held-out data speak against it by more than a hundredth of what it explains
    ],
)
def test_too_much_without_it_and_imitated_it_stays_unless_held_out_data_speak_against_it(
    monkeypatch: pytest.MonkeyPatch, fitted: float, held: float, kept: bool
) -> None:
    monkeypatch.setattr(veto, "is_imitated", lambda *_: True)
    search = Found({"brake_fade": fitted}, {"brake_fade": held})
    search.misfit = lambda best: not best.names  # type: ignore[method-assign]
    search.nothing_else_found()
    assert judged(search) == (("brake_fade",) if kept else ())


def test_what_held_out_data_refute_makes_way_for_what_they_do_not() -> None:
    """A gain that one drive asks for and the other one refutes, and the limit that explains nearly as much."""
    search = Found({"brake_gain": 2.0, "brake_limit": 1.9}, {"brake_gain": -1.0, "brake_limit": 0.0})
    search.misfit = lambda best: not best.names  # type: ignore[method-assign]
    asked: list[tuple[str, ...]] = []

    def grown(now: Any, turns: Any, barred: tuple[str, ...] = ()) -> SimpleNamespace:
        asked.append(tuple(barred))
        return search.trial(("brake_limit",))

    search.finds(grown)
    found = SearchResult(search.trial(("brake_gain",)), {}, ("roll",))  # type: ignore[arg-type]
    told = veto.judged(search, found, (judge(),), lambda: ())  # type: ignore[arg-type]
    assert (told.found.final.names, told.vetoed) == (("brake_limit",), ("brake_gain",))
    assert told.found.not_excited == ("roll",)
    assert asked == [("brake_gain",)]


def test_what_the_remainder_may_make_does_not_stay_beside_what_is_new(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the drive too much is left, without the brake not."""
    monkeypatch.setattr(veto, "is_imitated", lambda *_: True)
    search = Found({"drive_gain": 5.0, "brake_gain": 2.1 * ABOVE_REMAINDER}, {"drive_gain": 0.0, "brake_gain": 0.0})
    search.misfit = lambda best: "drive_gain" not in best.names  # type: ignore[method-assign]
    search.nothing_else_found()
    assert judged(search) == ("drive_gain",)


def test_what_means_nothing_is_not_found_again_and_again() -> None:
    """Far from the car an effect is taken up without being sure of it, and a sure set has it no more."""
    search = Found({"brake_gain": 2.0, "brake_limit": 1.9}, {"brake_gain": -1.0, "brake_limit": 0.0})
    search.misfit = lambda best: True  # type: ignore[method-assign]
    asked: list[set[str]] = []

    def grown(now: Any, turns: Any, barred: Any = ()) -> SimpleNamespace:
        asked.append(set(barred))
        return search.trial(tuple({"brake_limit"} - set(barred)))

    search.finds(grown)
    search.credible_set = lambda best: search.trial(())
    found = SearchResult(search.trial(("brake_gain",)), {}, ())  # type: ignore[arg-type]
    assert veto.judged(search, found, (judge(),), lambda: ()).found.final.names == ()  # type: ignore[arg-type]
    assert asked == [{"brake_gain"}, {"brake_gain", "brake_limit"}]


def test_a_twin_keeps_what_it_learnt_where_an_addition_explains_all(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: Any) -> Any:
        raise AssertionError("asked which effects to remove")

    monkeypatch.setattr(removal, "_removed", never)
    search = Found({"drive_gain": 1.0}, {"drive_gain": 1.0})
    found = SearchResult(search.trial(("drive_gain",)), {}, ())  # type: ignore[arg-type]
    space = SimpleNamespace(target=search.target, run=lambda fixed: (search, found))
    assert removal.searched(space, None) == (search, found, {}, ())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("held", "instead", "excused", "standing"),
    [
        (1.0, (), True, "confirmed"),
        (1.0, ("drive_gain",), True, "provisional"),
        (0.5 * ABOVE_REMAINDER, (), True, "provisional"),
        (0.5 * ABOVE_REMAINDER, (), False, "confirmed"),
        (0.0, (), False, "provisional"),
        (None, (), False, "provisional"),
    ],
)
def test_a_removal_is_confirmed_by_data_held_out_alone(
    held: float | None, instead: tuple[str, ...], excused: bool, standing: str
) -> None:
    found = removed_effect(catalogue()["mass"], 0.5, held, instead, excused=excused)
    assert (found.standing, found.rivals, found.action) == (standing, instead, "remove")
    assert bool(found.doubts) == (standing == "provisional")


def other(name: str, segments: np.ndarray, held: float) -> SimpleNamespace:
    return SimpleNamespace(names=(name,), chi2=float(segments.sum()), values={"held": held}, segment_chi2=segments)


def test_a_rival_does_as_well_in_many_draws_of_segments() -> None:
    search = Found({"steer_ratio": 1.0}, {"steer_ratio": 1.0})
    best = search.trial(("steer_ratio",))
    even = best.segment_chi2
    one_event = even + 5.0 * np.eye(SEGMENTS)[0] - 0.2  # behind in one segment only, ahead in the others
    everywhere = even + 2.0
    explains_little = even + 40.0 * np.tile([1.0, -0.9], SEGMENTS // 2) + 24.0
    search.others = {
        "steer_ratio": [
            other("steer_asymmetry", one_event, COUNT),
            other("understeer", everywhere, COUNT),
            other("roll", explains_little, 2.0 * COUNT),
        ]
    }
    found = rivals_over_segments(search, (judge(),), best)  # type: ignore[arg-type]
    assert found == {"steer_ratio": ("steer_asymmetry",)}
