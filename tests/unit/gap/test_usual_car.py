"""A search that begins with what nearly every car has."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import search as module
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.usual_car import USUAL, is_bare, usual_car
from pytest_dvp.logs.log import Log
from tests.truth.effects import TruthCar
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model

CAR = TruthCar()
MODEL = parse_model(
    f"[model]\nname = 'car'\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n"
    f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
)
HIDDEN = {
    "drive_delay": {"T": 0.15},
    "rolling_resistance": {"c": 0.2},
    "lift_off_braking": {"a": 0.5, "drive": 0.0},
    "steer_delay": {"T": 0.1},
    "steer_offset": {"offset": 0.02},
    "steer_ratio": {"g": 0.85},
}


def a_search(effects: Any) -> Search:
    columns = make_log(effects, "rich", 4, "mid")
    log = Log({name: np.ascontiguousarray(values[: 60 * 50]) for name, values in columns.items()})
    data = experiment_set({"rich": log}, MODEL)
    tried = [catalogue()[name] for name in (*USUAL, "steer_asymmetry")]
    return Search(data, candidates(MODEL, tried, ay=True))


def test_what_is_usual_is_known_to_the_catalogue() -> None:
    for name, values in USUAL.items():
        assert set(values) <= {key.name for key in catalogue()[name].parameters}
        catalogue()[name].complete(values)


@pytest.mark.nightly(by_day=1)
def test_several_effects_find_their_shares_at_once_and_the_others_go() -> None:
    found = usual_car(a_search(HIDDEN))
    assert set(HIDDEN) <= set(found.names)
    assert len(found.names) <= len(HIDDEN) + 2
    for name, values in HIDDEN.items():
        key, value = next(iter(values.items()))
        assert found.values[name, key] == pytest.approx(value, rel=0.05)
    assert found.chi2 < 1.1 * a_search(HIDDEN).count


@pytest.mark.parametrize(
    ("effects", "left", "excused", "bare"),
    [(4, 20.1, False, True), (4, 20.0, False, False), (3, 900.0, False, False), (5, 20.1, True, False)],
)
def test_a_few_effects_that_leave_much_say_that_the_model_is_bare(
    effects: int, left: float, excused: bool, bare: bool
) -> None:
    world: Any = SimpleNamespace(target=SimpleNamespace(excused=excused), count=10)
    assert is_bare(world, SimpleNamespace(names=("a",) * effects, chi2=10.0 * left)) is bare  # type: ignore[arg-type]


@pytest.mark.parametrize("left", [19.0, 21.0])
def test_a_bare_model_begins_anew_and_may_have_more_effects(left: float, monkeypatch: pytest.MonkeyPatch) -> None:
    search = object.__new__(Search)
    search.bare, search.apart, search._late, search.count = False, False, True, 10
    search.target = SimpleNamespace(excused=False, settle=lambda values: None)  # type: ignore[assignment]
    search.tried = {}
    few = SimpleNamespace(names=("a", "b", "c", "d"), values={}, chi2=10.0 * left)
    usual = SimpleNamespace(names=("u",), values={}, chi2=10.0)
    grown: list[Any] = []

    def grow(now: Any, turns: Any, barred: Any = (), most: int = 0, until: Any = None) -> Any:
        grown.append((now.names, search.bare, search._late))
        return now if until is None else few

    monkeypatch.setattr(module, "usual_car", lambda one: usual)
    monkeypatch.setattr(search, "grown", grow)
    monkeypatch.setattr(search, "trial", lambda names, values: SimpleNamespace(names=names, values=values, chi2=10.0))
    monkeypatch.setattr(search, "_whole_actuator", lambda now: now)
    found = search._risen(SimpleNamespace(names=()), [])  # type: ignore[arg-type]
    if left < 20.0:
        assert (found.names, grown) == (few.names, [((), False, False), (few.names, False, True)])
    else:
        assert (found.names, grown) == (("u",), [((), False, False), (("u",), True, False), (("u",), True, True)])


def test_where_drives_are_held_out_nothing_is_added_by_the_fitted_one_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    search = object.__new__(Search)
    search.bare, search.apart, search._late, search.count = False, True, True, 10
    search.target = SimpleNamespace(excused=False, settle=lambda values: None)  # type: ignore[assignment]
    search.tried = {}
    few = SimpleNamespace(names=("a", "b", "c", "d"), values={}, chi2=900.0)
    usual = SimpleNamespace(names=("u",), values={}, chi2=90.0)
    grown: list[Any] = []
    monkeypatch.setattr(module, "usual_car", lambda one: usual)
    monkeypatch.setattr(search, "grown", lambda now, *more, **keys: grown.append(now) or few)
    monkeypatch.setattr(search, "trial", lambda names, values: SimpleNamespace(names=names, late=search._late))
    found: Any = search._risen(SimpleNamespace(names=()), [])  # type: ignore[arg-type]
    assert (found.names, found.late, len(grown)) == (("u",), True, 1)


@pytest.mark.parametrize(
    ("bare", "left", "gone", "pays"),
    [
        (True, 3.0, "mass", True),
        (True, 1.9, "mass", False),
        (False, 3.0, "mass", False),
        (True, 3.0, "roll", False),
        (True, 3.0, "gear_changes", True),  # which the log shows by itself
    ],
)
def test_far_from_the_noise_what_is_usual_needs_to_pay_its_price_only(
    bare: bool, left: float, gone: str, pays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = object.__new__(Search)
    search.bare, search.count = bare, 10
    search.known = {name: SimpleNamespace(seen={}) for name in ("drive_lag", "mass", "roll")}  # type: ignore[misc]
    search.known["gear_changes"] = SimpleNamespace(seen={("gear_changes", "T"): 0.5})  # type: ignore[assignment]
    monkeypatch.setattr(search, "cost", lambda trial: trial.chi2)
    monkeypatch.setattr(search, "is_worth_adding", lambda less, best: False)
    best = SimpleNamespace(names=("drive_lag", gone), chi2=10.0 * left)
    less = SimpleNamespace(names=("drive_lag",), chi2=10.1 * left)
    assert search.pays(less, best) is pays  # type: ignore[arg-type]
    less.chi2 = 9.9 * left
    assert not search.pays(less, best)  # type: ignore[arg-type]


def test_what_no_strength_would_show_is_not_fitted() -> None:
    """A speed that is given from outside leaves mass, drive and brakes nothing to do."""
    search = a_search({"steer_ratio": {"g": 0.85}})
    search._shown = {"mass": 0.0, "drive_gain": 0.0, "steer_ratio": 40.0}
    begun: list[tuple[str, ...]] = []
    fitted = search.trial

    def trial(names: Any, start: Any, **keys: Any) -> Any:
        begun.append(tuple(names))
        return fitted((), search.start)

    search.trial = trial  # type: ignore[method-assign]
    usual_car(search)
    assert begun[0] == tuple(name for name in USUAL if name not in ("mass", "drive_gain"))
