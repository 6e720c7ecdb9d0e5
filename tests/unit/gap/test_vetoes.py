"""What data that were not fitted on take out of a set, what a run's own set-up says, and how data are parted."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import held_out, run_setup, veto
from pytest_dvp.gap.diagnose.held_out import Fold, folds, folds_with_setup, refit_on_fold, step
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.rivals import rivals_over_segments
from pytest_dvp.gap.diagnose.run_setup import RunSetup, end_of_beginning, split_setup
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.diagnose.veto import Judged, allowed_loss, judged
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import BRAKE, DRIVE, MODEL, MOTOR, NOISE, ROWS, World, a_search, direction
from vehicle.model.effect_catalogue import find_effect

GYRO, OFFSET, MASS = ("gyro_bias", "b"), ("steer_offset", "offset"), ("mass", "ratio")


def coordinates(*names: str) -> tuple[Coordinate, ...]:
    return tuple(Coordinate(name, key) for name in names for key in find_effect(name).parameters)


def shows(key: tuple[str, str], chi2: float, change: float, *, k: int = 0) -> dict[tuple[str, str], Any]:
    """A row of the world in which a change of a value makes so much chi^2."""
    return {key: np.sqrt(chi2) / change * direction(k)}


# --- a run's own set-up


def test_the_beginning_of_a_run_says_where_its_zeros_stand_whatever_other_runs_say() -> None:
    first = World(shows(GYRO, 100.0, 0.02) | shows(DRIVE, 900.0, 0.1, k=1), hidden={GYRO: 0.02, DRIVE: 0.9})
    setup = RunSetup(first, coordinates("gyro_bias"), frozenset({"gyro_bias"}))  # type: ignore[arg-type]
    for values in ({DRIVE: 0.9}, {DRIVE: 0.9, GYRO: -0.5}):
        found = setup.fitted(values)
        assert found == {DRIVE: 0.9, GYRO: pytest.approx(0.02, abs=1e-4)}
        assert setup.fitted(values, without="gyro_bias") == {DRIVE: 0.9}
    assert setup.less("gyro_bias").coordinates == ()
    assert setup.less("steer_offset").coordinates == setup.coordinates


@pytest.mark.parametrize(("chi2", "taken"), [(0.95, False), (1.05, True)])
def test_a_zero_must_be_worth_a_thousandth_of_what_is_left(chi2: float, taken: bool) -> None:
    """A thousandth of 1000 samples of unit noise."""
    first = World(shows(GYRO, chi2, 0.02), hidden={GYRO: 0.02})
    setup = RunSetup(first, coordinates("gyro_bias"), frozenset({"gyro_bias"}))  # type: ignore[arg-type]
    assert (GYRO in setup.fitted({})) is taken


def test_what_is_no_zero_is_asked_only_if_another_run_has_it() -> None:
    first = World(shows(MASS, 900.0, 0.2), hidden={MASS: 1.2})
    setup = RunSetup(first, coordinates("mass"), frozenset())  # type: ignore[arg-type]
    assert setup.fitted({}) == {}
    assert setup.fitted({MASS: 1.0}) == {MASS: pytest.approx(1.2, abs=1e-3)}


def even_log(rows: int, begin: float = 0.0) -> Log:
    return Log({"t": begin + np.arange(rows) * 0.02, "v": np.ones(rows)})


@pytest.fixture
def as_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Experiments that are the logs they are made of."""
    for module in (held_out, run_setup):
        monkeypatch.setattr(module, "experiment_set", lambda logs, model, extra: logs)


def test_the_beginning_of_a_run_is_its_first_three_tenths() -> None:
    assert end_of_beginning(even_log(1001, begin=10.0)) == pytest.approx(10.0 + 0.3 * 20.0)


@pytest.mark.parametrize(("rows", "parted"), [(664, False), (667, True)])
def test_the_beginning_has_two_hundred_rows_or_the_run_has_no_set_up(rows: int, parted: bool, as_logs: None) -> None:
    """0.3 of 663 steps are 199 rows, of 666 steps they are 200."""
    found = split_setup({"a": even_log(rows), "b": even_log(2000)}, MODEL)
    assert len(found) == (2 if parted else 1)
    setup, rest = found[-1]
    assert setup.first["b"].t[-1] < rest["b"].t[0]  # type: ignore[index]
    assert rest["b"].t[0] == pytest.approx(0.3 * 1999 * 0.02, abs=0.021)  # type: ignore[index]
    assert len(setup.first["b"].t) + len(rest["b"].t) == 2000  # type: ignore[index]
    assert {"gyro_bias", "steer_offset"} <= setup.zeros
    assert "gnss_lever_arm" not in setup.zeros
    assert "gnss_lever_arm" in {c.effect for c in setup.coordinates}
    assert len(folds_with_setup({"a": even_log(rows), "b": even_log(2000)}, MODEL)) == (2 if parted else 0)


def test_logs_given_judge_and_several_logs_judge_each_other(as_logs: None) -> None:
    a, b, c = even_log(600), even_log(700), even_log(800)
    (given,) = folds({"a": a}, {"b": b}, MODEL)
    assert (given.fitted, dict(given.judge), given.setup) == (None, {"b": b}, None)  # type: ignore[call-overload]
    parts = folds({"a": a, "b": b, "c": c}, None, MODEL)
    assert [(sorted(f.fitted), sorted(f.judge)) for f in parts] == [  # type: ignore[call-overload, arg-type]
        (["b", "c"], ["a"]), (["a", "c"], ["b"]), (["a", "b"], ["c"]),
    ]  # fmt: skip
    both = folds({"a": a, "b": b}, None, MODEL)
    assert [(list(f.fitted), list(f.judge)) for f in both] == [(["b"], ["a"]), (["a"], ["b"])]  # type: ignore[call-overload, arg-type]
    assert folds_with_setup(None, MODEL) == ()


# --- refitted on the others


def two_effects(**more: Any) -> tuple[World, Search]:
    """Drive and brake are 10 % too weak, each of which makes a chi^2 of 900."""
    does = shows(DRIVE, 900.0, 0.1) | shows(BRAKE, 900.0, 0.1, k=1)
    world = World(does, hidden={DRIVE: 0.9, BRAKE: 0.9}, **more)
    return world, a_search(world, "drive_gain", "brake_gain")


def test_a_fold_fits_what_it_shows_and_keeps_the_value_of_the_rest() -> None:
    """Its data say 0.8 of the drive, and nearly nothing of the brake."""
    world, search = two_effects()
    best = search.trial(("drive_gain", "brake_gain"), {DRIVE: 1.0, BRAKE: 1.0})
    assert best.values == {DRIVE: pytest.approx(0.9), BRAKE: pytest.approx(0.9), MOTOR: 0.0}
    fitted = World(shows(DRIVE, 900.0, 0.1) | shows(BRAKE, 1.0, 0.1, k=1), hidden={DRIVE: 0.8, BRAKE: 0.5})
    found = refit_on_fold(search, Fold(fitted, world), best)  # type: ignore[arg-type]
    assert found.values == {DRIVE: pytest.approx(0.8), BRAKE: pytest.approx(0.9), MOTOR: 0.0}
    assert refit_on_fold(search, Fold(None, world), best) is best  # type: ignore[arg-type]


def test_a_set_up_of_its_own_is_asked_only_of_a_set_that_has_one() -> None:
    does = shows(GYRO, 900.0, 0.02) | shows(DRIVE, 900.0, 0.1, k=1)
    world = World(does, hidden={GYRO: 0.02, DRIVE: 0.9})
    search = a_search(world, "gyro_bias", "drive_gain")
    first = World(does, hidden={GYRO: -0.02, DRIVE: 0.9})
    setup = RunSetup(first, coordinates("gyro_bias"), frozenset({"gyro_bias"}))  # type: ignore[arg-type]
    fold = Fold(None, world, setup)  # type: ignore[arg-type]
    without = search.trial(("drive_gain",), {DRIVE: 1.0})
    assert refit_on_fold(search, fold, without) is without
    both = search.trial(("drive_gain", "gyro_bias"), {DRIVE: 1.0, GYRO: 0.0})
    assert refit_on_fold(search, fold, both).values[GYRO] == pytest.approx(-0.02, abs=1e-4)
    assert refit_on_fold(search, fold, both).values[DRIVE] == both.values[DRIVE]
    assert GYRO not in refit_on_fold(search, fold, both, without="gyro_bias").values


def test_a_step_tells_the_error_of_both_sides_per_sample() -> None:
    """Half of the judging data of 1000 and 500 samples: 1000 + 900 and 500 over 1500."""
    _, search = two_effects()
    trial = search.trial(("drive_gain",), {DRIVE: 1.0})
    one = World(shows(BRAKE, 900.0, 0.1), hidden={BRAKE: 0.9})
    other = World({}, noise=np.sqrt(0.5) * NOISE, count=500)
    found = step(search, trial, (Fold(None, one), Fold(None, other)))  # type: ignore[arg-type]
    assert found.added == "drive_gain"
    assert found.chi2_per_n == pytest.approx(1.9)
    assert found.held_out_chi2_per_n == pytest.approx((1000.0 + 900.0 + 500.0) / 1500.0)
    assert found.held_out_rmse == {"v": pytest.approx(np.sqrt((1.9 + 0.5) / 2.0))}
    assert sum(found.segments) == pytest.approx(1900.0)
    assert sum(found.held_out_segments) == pytest.approx(2400.0)
    alone = step(search, trial, (), "brake_gain")
    assert (alone.added, alone.held_out_chi2_per_n, alone.held_out_segments) == ("brake_gain", None, ())


@pytest.mark.parametrize(("share", "rivals"), [(0.9, ("brake_gain",)), (0.6, ())])
def test_who_explains_half_in_its_place_in_draws_of_all_segments_is_a_rival(share: float, rivals: Any) -> None:
    """What is as long as the drive's row and goes the same way in part leaves 1 - share^2 of its 900: 171 and 576."""
    does = shows(DRIVE, 900.0, 0.1) | {BRAKE: 300.0 * direction(1, 0, share)}
    world = World(does, hidden={DRIVE: 0.9}, noise=np.sqrt(8.0) * NOISE)
    search = a_search(world, "drive_gain", "brake_gain")
    best = search.trial(("drive_gain",), {DRIVE: 1.0})
    search.bootstrap_share = lambda worse, better, slack=0.0: 0.94  # type: ignore[method-assign]
    search.is_credible = lambda trial, name, target=None: True  # type: ignore[method-assign]
    assert rivals_over_segments(search, (), best) == {"drive_gain": rivals}
    search.bootstrap_share = lambda worse, better, slack=0.0: 0.95  # type: ignore[method-assign]
    assert rivals_over_segments(search, (), best) == {"drive_gain": ()}


# --- the veto


def named(*gains: tuple[tuple[str, str], float], **more: Any) -> tuple[Search, SearchResult]:
    """A set of effects with what each gains where it is fitted, chi^2/N; their values are 10 % or 0.02 off."""
    does: dict[tuple[str, str], Any] = {}
    hidden = {}
    for k, (key, gain) in enumerate(gains):
        off = 0.02 if key == GYRO else -0.1
        does |= shows(key, gain * ROWS, abs(off), k=k)
        hidden[key] = (0.0 if key == GYRO else 1.0) + off
    search = a_search(World(does, hidden=hidden, **more), *(key[0] for key, _ in gains))
    final = search.trial([key[0] for key, _ in gains], {key: 0.0 if key == GYRO else 1.0 for key, _ in gains})
    return search, SearchResult(final, {key[0]: ("other",) for key, _ in gains}, ())


def loses(key: tuple[str, str], loss: float) -> Fold:
    """Data on which the value found loses so much chi^2/N against doing nothing; a negative loss is a gain."""
    off = 0.02 if key == GYRO else -0.1
    neutral = 0.0 if key == GYRO else 1.0
    if loss < 0.0:
        return Fold(None, World(shows(key, -loss * ROWS, 0.1), hidden={key: neutral + off}))  # type: ignore[arg-type]
    return Fold(None, World(shows(key, loss * ROWS, abs(off)), hidden={key: neutral}))  # type: ignore[arg-type]


def after(search: Search, found: SearchResult, *judges: Fold, apart: Any = lambda: ()) -> Judged:
    return veto._veto(search, found, judges, apart, fragment=0.2)


@pytest.mark.parametrize(("fitted", "loss", "out"), [
    (2.0, 0.0199, False), (2.0, 0.0201, True),  # a hundredth of what it gains where it is fitted
    (0.06, 0.00099, False), (0.06, 0.00101, True),  # or a thousandth of the noise
    (2.0, -0.5, False),
])  # fmt: skip
def test_what_loses_on_other_data_goes_but_for_a_slight_loss(fitted: float, loss: float, out: bool) -> None:
    search, found = named((DRIVE, fitted))
    left = after(search, found, loses(DRIVE, loss))
    assert left.vetoed == (("drive_gain",) if out else ())
    assert left.found.final.names == (() if out else ("drive_gain",))
    if not out and loss > 0.0:
        assert left.gains == {"drive_gain": pytest.approx(-loss, rel=1e-3)}
        assert left.found is found


def test_the_worst_goes_first_and_the_others_may_stay() -> None:
    search, found = named((DRIVE, 2.0), (BRAKE, 2.0))
    does = shows(DRIVE, 300.0, 0.1) | shows(BRAKE, 400.0, 0.1, k=1)
    fold = Fold(None, World(does, hidden={DRIVE: 0.9, BRAKE: 1.0}))  # type: ignore[arg-type]
    left = after(search, found, fold)
    assert left.vetoed == ("brake_gain",)
    assert left.found.final.names == ("drive_gain",)
    assert left.found.rivals == {"drive_gain": ("other",)}
    assert left.gains == {"drive_gain": pytest.approx(0.3, rel=1e-3)}


def test_a_gain_is_the_mean_over_the_samples_of_all_judges() -> None:
    """0.3 on 1000 samples, and 0.6 x 1000 / 500 on 500: 900 over 1500."""
    search, found = named((DRIVE, 2.0))
    short = Fold(None, dataclasses.replace(loses(DRIVE, -0.6).judge, count=500))  # type: ignore[type-var]
    assert after(search, found, loses(DRIVE, -0.3), short).gains == {"drive_gain": pytest.approx(0.6, rel=1e-3)}


def test_without_other_data_nothing_is_vetoed() -> None:
    search, found = named((DRIVE, 2.0))
    assert after(search, found) == Judged(found, (), {}, ())


def zero_of_the_day(first: float, rest: float) -> Fold:
    """A run whose gyro is off by so much in its beginning and in the rest of it."""
    does = shows(GYRO, 2000.0, 0.02)
    setup = RunSetup(World(does, hidden={GYRO: first}), coordinates("gyro_bias"), frozenset({"gyro_bias"}))
    return Fold(None, World(does, hidden={GYRO: rest}), setup)  # type: ignore[arg-type]


def test_a_zero_that_loses_may_be_another_one_on_that_day() -> None:
    search, found = named((GYRO, 2.0))
    own = zero_of_the_day(-0.02, -0.02)
    left = after(search, found, loses(GYRO, 1.0), apart=lambda: (own,))
    assert (left.vetoed, left.judges) == ((), (own,))
    assert left.gains == {"gyro_bias": pytest.approx(2.0, rel=1e-3)}


@pytest.mark.parametrize("apart", [(), (zero_of_the_day(0.0, 0.0),)])
def test_a_zero_that_not_even_the_run_itself_shows_goes_and_the_judges_are_the_given_ones(apart: Any) -> None:
    search, found = named((GYRO, 2.0))
    given = loses(GYRO, 1.0)
    left = after(search, found, given, apart=lambda: apart)
    assert left.vetoed == ("gyro_bias",)
    assert left.judges == (given,)
    assert left.found.rivals == {}


@pytest.mark.parametrize(
    ("level", "shift", "out"), [(1.0, 0.00139, True), (1.0, 0.0015, False), (4.0, 0.0028, True), (4.0, 0.0029, False)]
)
def test_a_zero_of_its_own_must_gain_a_hundredth(level: float, shift: float, out: bool) -> None:
    """chi^2 2000 at 0.02 is 10 in 1000 samples at 0.02 sqrt(1/200) = 0.001414; where four times the noise is left it is
    a hundredth of that, at twice the shift."""
    search, found = named((GYRO, 2.0), noise=np.sqrt(level) * NOISE)
    left = after(search, found, loses(GYRO, 1.0), apart=lambda: (zero_of_the_day(shift, shift),))
    assert left.vetoed == (("gyro_bias",) if out else ())


def test_what_is_no_zero_is_not_judged_by_a_set_up() -> None:
    search, found = named((DRIVE, 2.0))
    assert after(search, found, loses(DRIVE, 1.0), apart=lambda: (zero_of_the_day(0.0, 0.0),)).vetoed == ("drive_gain",)
    asked: list[bool] = []
    left = after(search, found, loses(DRIVE, 1.0), apart=lambda: asked.append(True) or (zero_of_the_day(0.0, 0.0),))
    assert (left.vetoed, asked) == (("drive_gain",), [])  # for what is of the car, no judges of the day are made


@pytest.mark.parametrize(
    ("excused", "clear", "level", "fitted", "loss"),
    [
        (False, False, 1.0, 1.0, 0.01),
        (False, False, 2.0, 1.0, 0.01),
        (False, False, 2.01, 1.0, 0.2),  # what else is missing takes part in the loss
        (False, True, 1.0, 1.0, 0.01),
        (True, False, 3.0, 1.0, 0.01),
        (True, True, 3.0, 1.0, 0.05),
        (False, False, 2.0, 0.1, 2e-3),
        (False, False, 1.0, 0.0, 1e-3),
    ],
)
def test_how_much_an_effect_may_lose(
    monkeypatch: pytest.MonkeyPatch, excused: bool, clear: bool, level: float, fitted: float, loss: float
) -> None:
    monkeypatch.setattr(veto, "is_clear", lambda search, final, name: clear)
    search: Any = SimpleNamespace(target=SimpleNamespace(excused=excused))
    assert allowed_loss(search, SimpleNamespace(), "mass", level, fitted) == pytest.approx(loss)


@pytest.mark.parametrize(("shown", "excused", "loss"), [(True, True, 0.2), (False, True, 0.05), (True, False, 0.01)])
def test_what_both_drives_show_where_the_remainder_lasts_may_lose_a_fifth(
    monkeypatch: pytest.MonkeyPatch, shown: bool, excused: bool, loss: float
) -> None:
    asked = []
    monkeypatch.setattr(veto, "is_clear", lambda search, final, name: True)
    monkeypatch.setattr(veto, "as_told", lambda search, final: "as told")
    monkeypatch.setattr(veto, "is_evident_apart", lambda *given: asked.append(given) or shown)
    search: Any = SimpleNamespace(target=SimpleNamespace(excused=excused))
    judges: Any = ("a drive",)
    assert allowed_loss(search, SimpleNamespace(), "mass", 1.0, 1.0, judges) == pytest.approx(loss)
    assert asked == ([(search, "as told", "mass", judges)] if excused else [])
    assert allowed_loss(search, SimpleNamespace(), "mass", 1.0, 1.0) == pytest.approx(0.05 if excused else 0.01)


@pytest.mark.parametrize(
    ("fitted", "gain", "imitated", "beyond", "out"),
    [
        (0.39, 0.19, False, False, True),  # little where it is fitted, less than a fifth elsewhere
        (0.39, 0.21, False, False, False),
        (0.41, 0.19, False, False, False),  # not little: may be small elsewhere
        (0.41, 0.19, True, False, True),
        (0.39, 0.19, False, True, False),
    ],
)
def test_beside_a_known_remainder_what_gains_little_is_a_fragment(
    monkeypatch: pytest.MonkeyPatch, fitted: float, gain: float, imitated: bool, beyond: bool, out: bool
) -> None:
    """Little is two fifths of chi^2/N; a fifth is what a known remainder may change by."""
    for name, answer in (("is_imitated", imitated), ("is_beyond_remainder", beyond)):
        monkeypatch.setattr(veto, name, lambda *_, answer=answer: answer)
    search, found = named((DRIVE, fitted), excused=True)
    assert after(search, found, loses(DRIVE, -gain)).vetoed == (("drive_gain",) if out else ())
    search, found = named((DRIVE, fitted))
    assert after(search, found, loses(DRIVE, -gain)).vetoed == ()  # without a known remainder a gain is a gain


def test_a_vetoed_set_beside_a_remainder_is_judged_again_by_what_explains_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search, found = named((DRIVE, 2.0), (BRAKE, 2.0), excused=True)
    asked: list[tuple[float, bool]] = []

    def vetoing(search: Any, result: Any, judges: Any, apart: Any, *, fragment: float, new: bool = False) -> Judged:
        asked.append((fragment, new))
        left = search.trial(("drive_gain",), {DRIVE: 1.0})
        return Judged(dataclasses.replace(result, final=left), ("brake_gain",), {}, judges)

    monkeypatch.setattr(veto, "chosen", lambda search, found, judges: found)
    monkeypatch.setattr(veto, "_veto", vetoing)
    monkeypatch.setattr(veto, "refined", lambda search, left, rivals: left)
    search.misfit = lambda now: True  # type: ignore[method-assign]
    assert judged(search, found, (), lambda: ()).vetoed == ("brake_gain",)
    assert asked == [(0.2, False), (0.05, True)]
    asked.clear()
    search.misfit = lambda now: False  # type: ignore[method-assign]
    judged(search, found, (), lambda: ())
    assert asked == [(0.2, False)]
    asked.clear()
    more = search.trial(("drive_gain", "brake_gain"), {DRIVE: 1.0, BRAKE: 1.0})
    monkeypatch.setattr(veto, "refined", lambda search, left, rivals: more)
    assert judged(search, found, (), lambda: ()).vetoed == ("brake_gain", "brake_gain")
    assert asked == [(0.2, False), (0.05, False)]
    search.target.excused = False  # type: ignore[misc]
    asked.clear()
    assert judged(search, found, (), lambda: ()).vetoed == ("brake_gain",)
    assert asked == [(0.2, False)]


@pytest.mark.parametrize("rivalled", [False, True])
def test_a_veto_tells_that_its_judges_chose(monkeypatch: pytest.MonkeyPatch, rivalled: bool) -> None:
    search, found = named((DRIVE, 2.0))
    other = dataclasses.replace(found, rivals={"drive_gain": ("mass",)})
    monkeypatch.setattr(veto, "grown_for_held_out", lambda search, found, judges: other if rivalled else found)
    left = judged(search, found, (), lambda: ())
    assert left.chose == rivalled
    assert left.found is (other if rivalled else found)
