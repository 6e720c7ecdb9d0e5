"""The rungs of a ladder, and the model that has what was fitted, with every part given."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.extend import ladder as ladder_module
from pytest_dvp.gap.extend.fitted_model import fitted_model
from pytest_dvp.gap.extend.ladder import ladder_of
from tests.unit.gap.linear_world import BRAKE, DRIVE, World, a_search, a_trial
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

MODEL = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n")
HAS = MODEL.with_effect("drive_gain", {"g": 0.9}).with_effect("detection_yaw", {"b": 0.1})


def one(value: float, unit: str = "-") -> Estimate:
    return Estimate(value, value - 0.1, value + 0.1, unit)


# --- the ladder


def test_a_ladder_goes_from_the_model_as_given_to_the_final_one(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[tuple[str, ...], dict[Any, float], str | None]] = []

    def step(search: Any, trial: Any, judges: Any, added: str | None = None) -> Any:
        told.append((trial.names, dict(search.fixed), added))
        return trial.names

    monkeypatch.setattr(ladder_module, "step", step)
    monkeypatch.setattr(Search, "trial", lambda self, names, start, **more: SimpleNamespace(names=tuple(names)))
    search = a_search(World({}), "steer_ratio", "brake_gain", "steer_offset")
    search.fixed = {DRIVE: 1.0, BRAKE: 1.0}
    final: Any = SimpleNamespace(names=("steer_ratio", "brake_gain", "steer_offset"), values={})
    rungs = list(ladder_of(search, final, 1, ["drive_gain", "brake_gain"], (), {"brake_gain"}))
    assert [rung.change for rung in rungs] == [
        "", "- drive_gain", "- brake_gain", "~ fitted again", "~ brake_gain", "+ steer_offset",
    ]  # fmt: skip
    both = {DRIVE: 1.0, BRAKE: 1.0}
    assert told == [
        ((), {}, None), ((), {DRIVE: 1.0}, "drive_gain"), ((), both, "brake_gain"), (("steer_ratio",), both, None),
        (("steer_ratio", "brake_gain"), both, "brake_gain"), (final.names, both, "steer_offset"),
    ]  # fmt: skip
    short = list(ladder_of(search, dataclasses.replace(a_trial(1.0), names=("steer_ratio",)), 0, [], (), set()))
    assert [rung.change for rung in short] == ["", "+ steer_ratio"]
    search.nuisance = (None,)  # type: ignore[assignment]
    again = list(ladder_of(search, dataclasses.replace(a_trial(1.0), names=()), 0, [], (), set()))
    assert [rung.change for rung in again] == ["", "~ fitted again"]


# --- the new model


def test_the_new_model_has_what_was_fitted_with_its_intervals_and_lacks_what_was_removed() -> None:
    two = HAS.with_effect("steer_offset", {"offset": 0.01})
    final: Any = SimpleNamespace(values={("parameters", "ay_x"): 0.31234, DRIVE: 0.8})
    sure = {DRIVE: one(0.8), ("inputs", "steer_scale"): one(0.45), ("mass", "ratio"): one(1.1),
            ("detection_latency", "T"): one(0.2, "s")}  # fmt: skip
    added = [find_effect("mass"), find_effect("steer_lag"), find_effect("detection_latency")]
    found = fitted_model(two, final, sure, ["steer_offset"], added, ("a.csv",))
    assert [a.name for a in found.effects] == ["drive_gain", "detection_yaw", "mass", "detection_latency"]
    gain, yaw, mass, _ = found.effects
    assert (gain.values["g"], mass.values["ratio"]) == (0.8, 1.1)
    assert (gain.intervals["g"].low, gain.intervals["g"].high) == pytest.approx((0.7, 0.9))
    assert (gain.fitted_on, yaw.fitted_on, mass.fitted_on) == (("a.csv",), (), ("a.csv",))
    assert yaw.values == {"b": 0.1}
    assert found.inputs.steer_scale == 0.45
    assert found.car.ay_x == pytest.approx(0.31234, rel=1e-3)
    assert found.car.mass == 1200.0


def test_keys_that_were_not_fitted_stay_as_they_were() -> None:
    fading = MODEL.with_effect("brake_fade", {"k": 0.01, "tau": 90.0})
    final: Any = SimpleNamespace(values={})
    (found,) = fitted_model(fading, final, {("brake_fade", "k"): one(0.02)}, [], [], ()).effects
    assert (found.values["k"], found.values["tau"]) == (0.02, 90.0)
