"""grow: what all logs of a twin show together is added, and what they contradict each other in is not."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.extend import growth
from pytest_dvp.gap.extend.extension import Extension
from pytest_dvp.gap.extend.growth import ALL_SHOW, LOSES, NO_JUDGE, NONE_SHOWN, contradicts, grow, grown
from pytest_dvp.logs.log import Log
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import run_setups
from vehicle.model.model_file import parse_model

CAR = "[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\nyaw_inertia = 1400.0\n"
LATE = '[[effect]]\nname = "steer_delay"\n[effect.parameters.T]\nvalue = 0.1\n'
KNOWN = "[remainder]\nv.cruise = 0.5\nax.launch = 0.9\n"
HIDDEN = {"steer_delay": {"T": 0.2}, "drive_lag": {"tau": 0.3}}


@pytest.fixture(scope="module")
def found() -> Iterator[Extension]:
    """A twin with a wrong dead time and without the car's lag, and a remainder that excuses all of it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(growth, "with_shape", lambda twin, *more: twin)
        logs = {f"{k}.csv": Log(make_log(HIDDEN, "urban", k)) for k in (1, 2)}
        yield grow(logs, parse_model(CAR + LATE + KNOWN), fitted_on=("1.csv", "2.csv"))


def test_what_the_known_remainder_excuses_is_found_on_all_logs_together(found: Extension) -> None:
    assert [e.name for e in found.effects] == ["drive_lag"]
    assert found.model.value("drive_lag", "tau") == pytest.approx(0.3, rel=0.05)
    assert found.model.value("steer_delay", "T") == pytest.approx(0.2, rel=0.03)


def test_each_rung_says_what_was_done_and_the_error_falls(found: Extension) -> None:
    assert [rung.change for rung in found.ladder[:2]] == ["", "~ fitted again"]
    assert [rung.change for rung in found.ladder[2:]] == [f"+ {e.name}" for e in found.effects]
    left = [rung.step.chi2_per_n for rung in found.ladder]
    assert left == sorted(left, reverse=True)
    assert left[-1] == pytest.approx(1.0, abs=0.15)
    assert found.explained
    assert not found.refusal


def test_no_held_out_error_is_claimed_and_each_new_effect_says_that_nothing_judged_it(found: Extension) -> None:
    assert all(rung.step.held_out_chi2_per_n is None for rung in found.ladder)
    assert all(e.standing == "provisional" and e.doubts == (ALL_SHOW,) for e in found.effects)
    assert found.notes == (f"drive_lag: {ALL_SHOW}", NO_JUDGE)


def test_provenance_is_of_all_logs_and_the_old_remainder_is_measured_anew(found: Extension) -> None:
    assert {a.fitted_on for a in found.model.effects} == {("1.csv", "2.csv")}
    assert found.model.remainder.get("v", {}).get("cruise", 0.0) < 0.1  # the file said 0.5


def test_a_pedal_scale_that_an_effect_of_the_model_repeats_is_not_fitted_beside_it_and_nothing_found_is_said() -> None:
    logs = {}
    for k in (1, 2):
        columns = make_log({"drive_gain": {"g": 0.8}, "brake_gain": {"g": 0.8}}, "urban", k)
        wanted = columns.pop("accel_cmd")
        columns |= {"throttle_cmd": np.maximum(wanted, 0.0) / 4.0, "brake_cmd": np.maximum(-wanted, 0.0) / 8.0}
        logs[f"{k}.csv"] = Log(columns)
    gain = '[[effect]]\nname = "{}"\n[effect.parameters.g]\nvalue = 0.9\n'
    inputs = '[inputs]\nlongitudinal = "throttle_cmd + brake_cmd"\nfull_throttle = 4.0\nfull_brake = 8.0\n'
    twin = parse_model(inputs + CAR + gain.format("drive_gain") + gain.format("brake_gain"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(growth, "with_shape", lambda twin, *more: twin)
        grown_twin = grow(logs, twin)
    assert set(grown_twin.refitted) == {("drive_gain", "g"), ("brake_gain", "g"), ("brake_gain", "motor")}
    gains = [e.value for (_, key), e in grown_twin.refitted.items() if key == "g"]
    assert gains == pytest.approx([0.8, 0.8], rel=0.03)
    assert grown_twin.refitted["brake_gain", "motor"].value < 0.1  # m/s^2: no motor takes anything over
    assert grown_twin.notes == (NONE_SHOWN, NO_JUDGE)


def two_logs(monkeypatch: pytest.MonkeyPatch, left: dict[str, tuple[float, float]]) -> Any:
    """Two logs of which a set of effects, by its last name, leaves so much chi^2."""
    target = ExperimentSet(("one", "two"))  # type: ignore[arg-type]

    def whitened(self: ExperimentSet, values: Any) -> Any:
        return np.sqrt([left[values[""]][0 if one == "one" else 1] for one in self.experiments])

    monkeypatch.setattr(ExperimentSet, "whitened", whitened)
    monkeypatch.setattr(ExperimentSet, "settle", lambda self, values: None)
    return target


def a_trial(*names: str) -> Any:
    return SimpleNamespace(names=names, values={"": names[-1]}, chi2=0.0)


@pytest.mark.parametrize(
    ("left", "contradiction"),
    [
        ((60.0, 100.0), False),  # nothing is lost
        ((40.0, 100.0 + 60.0 * LOSES - 1.0), False),
        ((40.0, 100.0 + 60.0 * LOSES + 1.0), True),
        ((100.0 + 60.0 * LOSES + 1.0, 40.0), True),  # whichever log it is
        ((101.0, 101.0), True),
    ],
)
def test_logs_contradict_each_other_if_one_loses_a_third_of_what_the_other_gains(
    left: tuple[float, float], contradiction: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = two_logs(monkeypatch, {"kept": (100.0, 100.0), "new": left})
    assert contradicts(target, a_trial("kept"), a_trial("kept", "new")) is contradiction


def test_the_next_best_effect_comes_where_logs_contradict_each_other_and_what_they_do_is_barred(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    target = two_logs(
        monkeypatch, {"kept": (100.0, 100.0), "disputed": (10.0, 190.0), "agreed": (70.0, 80.0), "other": (1.0, 190.0)}
    )
    asked: list[tuple[str, ...]] = []

    def paying(now: Any, barred: Any, most: int) -> list[Any]:
        asked.append(tuple(barred))
        names = {1: ("disputed", "agreed"), 2: ("other",)}.get(len(now.names), ())
        return [a_trial(*now.names, name) for name in names if name not in barred]

    search: Any = SimpleNamespace(
        target=target, count=100, paying=paying, trial=lambda names, values, like=None: a_trial(*names)
    )
    monkeypatch.setattr(growth, "settled_fit", lambda search, now: now)
    assert grown(search, {}, ["kept"], lambda text: None).names == ("kept", "agreed")
    assert asked == [(), (), ("other",)]


def test_what_was_added_is_no_value_that_was_fitted_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the twin has and what differs from run to run is not tried."""
    few, search = growth.candidates, growth.Search
    tried: list[str] = []
    names = ("drive_lag", "steer_delay", *run_setups())

    def noted(target: Any, several: Any, **more: Any) -> Any:
        tried.extend(c.name for c in several)
        return search(target, several, **more)

    monkeypatch.setattr(growth, "Search", noted)
    monkeypatch.setattr(growth, "with_shape", lambda twin, *more: twin)
    monkeypatch.setattr(
        growth, "candidates", lambda model, effects, ay: few(model, [e for e in effects if e.name in names], ay=ay)
    )
    log = Log({name: column[:800] for name, column in make_log(HIDDEN, "urban", 1).items()})
    found = grow({"1.csv": log}, parse_model(CAR + LATE))
    assert [e.name for e in found.effects] == ["drive_lag"]
    assert set(found.refitted) == {("steer_delay", "T")}
    assert tried == ["steer_delay", "drive_lag"]
