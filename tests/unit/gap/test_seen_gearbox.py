"""Gearboxes that an acceleration shows, found in motion that this file makes by itself."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import seen_gearbox as module
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.gap.diagnose.seen_gearbox import FALLS, NAME, SHOWN, SeenGearbox, seen_gearbox, with_seen_gearbox
from pytest_dvp.gap.diagnose.usual_car import USUAL, usual_car, with_seen
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import DRIVE, MODEL, World, a_search, direction
from vehicle.model.effect_catalogue import catalogue, find_effect
from vehicle.model.model_file import parse_model

STEP, LATE = 0.02, 0.1  # s
PHASES = ((1.5, 9.0), (-1.2, 5.0), (2.4, 6.0), (0.0, 3.0), (-2.0, 9.0), (0.8, 12.0), (-1.5, 8.0))  # m/s^2, for s
PEDALS = parse_model(
    "[model]\nname = 'car'\n[inputs]\nsteer = 'steer_cmd'\nlongitudinal = 'throttle_cmd + brake_cmd'\n"
    "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"
)


def a_drive(
    cut: float, time: float = 0.5, v1: float = 3.5, step: float = 1.7, demand: float = 0.2, noise: float = 0.05,
    fall: float = 0.0, power: float = np.inf,
) -> dict[str, Any]:  # fmt: skip
    """Columns of a drive in a straight line, at 50 Hz, of a car that pulls less by `cut` while it changes gear, by the
    power `fall` of its ratios in longer gears, and with no more than so much power [W/kg]."""
    wish = np.concatenate([np.full(round(span / STEP), a) for a, span in PHASES])
    t = np.arange(len(wish)) * STEP
    v, a = np.zeros(len(t)), np.zeros(len(t))
    gear, left = 0, 0.0
    speeds = [v1]  # of the changes up; a gear's ratio is the first one over its own
    for k in range(5):
        speeds.append(speeds[-1] * step / 1.1**k)
    for k in range(1, len(t)):
        asked = wish[k - round(LATE / STEP)] if k >= round(LATE / STEP) else 0.0
        later = 1.0 + demand * (max(asked, 0.0) - 1.0)
        if gear < len(speeds) - 1 and v[k - 1] > speeds[gear] * later:
            gear, left = gear + 1, time
        elif gear and v[k - 1] < 0.65 * speeds[gear - 1] * later:
            gear, left = gear - 1, time
        a[k] = asked * (1.0 - cut) if asked > 0.0 and left > 0.0 else asked
        if asked > 0.0:
            a[k] = min(a[k] * (v1 / speeds[gear]) ** fall, power / max(v[k - 1], 0.1))
        left -= STEP
        v[k] = max(v[k - 1] + STEP * a[k], 0.0)
        a[k] = (v[k] - v[k - 1]) / STEP
    rng = np.random.default_rng(3)
    x = np.cumsum(v) * STEP
    nothing = np.zeros(len(t))
    return {
        "t": t, "x": x + rng.normal(0.0, 0.01, len(t)), "y": rng.normal(0.0, 0.01, len(t)),
        "yaw": rng.normal(0.0, 0.002, len(t)), "v": v + rng.normal(0.0, 0.01, len(t)),
        "yaw_rate": rng.normal(0.0, 0.002, len(t)), "ax": a + rng.normal(0.0, noise, len(t)),
        "accel_cmd": wish, "steer_cmd": nothing,
    }  # fmt: skip


def seen(columns: dict[str, Any], model: Any = MODEL) -> SeenGearbox:
    found = seen_gearbox(experiment_set({"drive": Log(columns)}, model))
    assert found is not None
    return found


def test_the_gearbox_is_found_whose_gaps_the_acceleration_has() -> None:
    found = seen(a_drive(cut=1.0))
    assert found.gaps > 2.0 * SHOWN
    assert found.values["T"] == 0.5
    assert found.values["v1"] == pytest.approx(3.5, rel=0.06)
    assert found.values["step"] == pytest.approx(1.7, abs=0.11)
    assert found.values["demand"] == pytest.approx(0.2, abs=0.11)
    assert found.values["cut"] > 0.6


def test_a_gearbox_that_only_lowers_the_torque_is_seen_and_its_share_told() -> None:
    found = seen(a_drive(cut=0.5, v1=5.0, step=1.6))
    assert found.gaps > SHOWN
    assert found.values["v1"] == pytest.approx(5.0, rel=0.06)
    assert found.values["cut"] == pytest.approx(0.5, abs=0.15)


def test_without_an_accelerometer_the_speed_shows_it() -> None:
    columns = a_drive(cut=1.0)
    del columns["ax"]
    found = seen(columns)
    assert found.gaps > SHOWN
    assert found.values["v1"] == pytest.approx(3.5, rel=0.1)


def test_of_pedals_the_throttle_is_what_is_asked_for() -> None:
    columns = a_drive(cut=1.0)
    wish = columns.pop("accel_cmd")
    columns["throttle_cmd"] = np.maximum(wish, 0.0) / PEDALS.inputs.full_throttle
    columns["brake_cmd"] = np.maximum(-wish, 0.0) / PEDALS.inputs.full_brake
    found, direct = seen(columns, PEDALS), seen(a_drive(cut=1.0))
    assert found.gaps == pytest.approx(direct.gaps, rel=1e-3)
    assert found.values == pytest.approx(direct.values, rel=1e-2)


def test_a_drive_without_gaps_shows_no_gearbox() -> None:
    assert seen(a_drive(cut=0.0)).gaps < 0.5 * SHOWN
    inputs = "[inputs]\nsteer = 'steer_cmd'\nlongitudinal = 'speed_cmd'\n"
    controlled = parse_model(f"[model]\nname = 'car'\n{inputs}[parameters]\nwheelbase = 2.5\n")
    columns = a_drive(cut=1.0)
    assert seen_gearbox(experiment_set({"drive": Log(columns | {"speed_cmd": columns["v"]})}, controlled)) is None


def test_a_force_that_falls_with_each_gear_shows_a_gearbox_that_leaves_no_gap() -> None:
    """A dual clutch changes gear without a gap; its force falls by the ratios, as that of an engine does."""
    found = seen(a_drive(cut=0.0, fall=1.0, v1=4.0, step=1.8, demand=0.1))
    assert found.gaps < SHOWN
    assert found.left < 0.4
    assert found.is_clear
    assert found.values["v1"] == pytest.approx(4.0, rel=0.06)
    assert found.values["step"] == pytest.approx(1.8, abs=0.11)
    assert found.values["fall"] == 1.0
    assert found.values["cut"] < 0.2


def test_of_a_force_that_falls_the_gaps_are_seen_too() -> None:
    found = seen(a_drive(cut=0.8, fall=0.5, v1=4.0, step=1.8))
    assert found.left < FALLS
    assert found.values["fall"] == pytest.approx(0.5, abs=0.26)
    assert found.values["cut"] == pytest.approx(0.8, abs=0.25)


@pytest.mark.parametrize("power", [3.0, 6.0, 12.0])
def test_a_power_that_ends_is_no_gearbox(power: float) -> None:
    """Its force falls with speed as well, but in one curve."""
    found = seen(a_drive(cut=0.0, power=power))
    assert found.left > FALLS
    assert not found.is_clear


@pytest.mark.parametrize(
    ("share", "left", "taken"), [(0.151, 1.0, True), (0.149, 1.0, False), (0.0, 0.64, True), (0.0, 0.66, False)]
)
def test_changes_of_gear_begin_where_the_logs_show_them(
    share: float, left: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = {"T": 0.5, "v1": 3.3, "step": 1.8, "demand": 0.2, "cut": 0.8, "fall": 0.0}
    monkeypatch.setattr(module, "seen_gearbox", lambda target: SeenGearbox(share, left, values))
    every = candidates(MODEL, catalogue().values())
    world: Any = World({})
    found = {c.name: c for c in with_seen_gearbox(every, world)}
    begin = {(NAME, key): value for key, value in values.items()}
    for one in every:
        if one.name == NAME and taken:
            assert found[NAME].seen == begin
            assert found[NAME].points == (begin, *one.points)
            assert found[NAME].coarse == (begin, *one.coarse)
        else:
            assert found[one.name] is one
    has = MODEL.with_effect(find_effect(NAME), {"T": 0.4})
    assert all(not c.seen for c in with_seen_gearbox(candidates(has, catalogue().values()), world))


def test_a_data_sheet_begins_with_what_the_logs_show() -> None:
    """The candidate is one that a search tries; `usual_car` fits it with all that nearly every car has."""
    world = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.9})
    search = a_search(world, "drive_gain", "brake_limit")
    assert "brake_limit" not in USUAL
    assert usual_car(search).names == ("drive_gain",)
    limit = search.tried["brake_limit"]
    search.tried["brake_limit"] = dataclasses.replace(limit, seen={("brake_limit", "limit"): 4.0})
    asked: list[tuple[str, ...]] = []
    trial = search.trial

    def watched(names: Any, values: Any, **options: Any) -> Any:
        asked.append(tuple(names))
        assert "brake_limit" not in names or values[("brake_limit", "limit")] == pytest.approx(4.0)
        return trial(names, values, **options)

    search.trial = watched  # type: ignore[method-assign]
    usual_car(search)
    assert asked[0] == ("drive_gain", "brake_limit")


def test_what_logs_show_is_kept_until_it_is_fitted() -> None:
    """A key that comes late stands at what the log shows, not at its neutral value, in every set before it is due."""
    world = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.9})
    search = a_search(world, "drive_gain", NAME)
    box = search.tried[NAME]
    gain = {DRIVE: 1.0}
    values = {"T": 0.5, "v1": 3.3, "step": 1.8, "demand": 0.2, "cut": 0.8, "fall": 0.6}
    begin = {(NAME, key): value for key, value in values.items()}
    search._late = False
    assert (NAME, "fall") not in search.trial(("drive_gain", NAME), gain | begin).values
    search.tried[NAME] = search.known[NAME] = dataclasses.replace(box, seen=begin)
    first = search.trial(("drive_gain", NAME), gain | begin)
    again = search.trial(first.names, first.values)
    alone = search.trial((NAME,), {(NAME, key): values[key] for key in ("T", "v1", "step", "demand")})
    assert [one.values[NAME, "fall"] for one in (first, again, alone)] == [0.6, 0.6, 0.6]


@pytest.mark.parametrize(
    ("left", "excused", "names"), [(1000.0, False, ("drive_gain",)), (4000.0, False, ()), (1000.0, True, ())]
)
def test_what_logs_show_comes_first_if_it_is_worth_it(left: float, excused: bool, names: tuple[str, ...]) -> None:
    """A twin that was learnt without it has it in its known remainder: it is nothing new."""
    search: Any = SimpleNamespace(
        target=SimpleNamespace(excused=excused),
        tried={
            "mass": SimpleNamespace(seen={}),
            "drive_gain": SimpleNamespace(seen={DRIVE: 0.8}),
        },
        tick=lambda text: None,
        trial=lambda names, values, like: SimpleNamespace(names=tuple(names), values=values, chi2=left),
        is_worth_adding=lambda without, more: more.chi2 < without.chi2,
    )
    now: Any = SimpleNamespace(names=(), values={}, chi2=2000.0)
    found = with_seen(search, now)
    assert found.names == names
    assert found.values == ({DRIVE: 0.8} if names else {})
    assert with_seen(search, found).names == names
