"""Noise of detections beside the run of a twin: whether it differs, what the model needs, and what waits for it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception import diagnose_perception as module
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perception
from pytest_dvp.gap.perception.noise_levels import noise_differs, noise_needed
from pytest_dvp.gap.perception.on_top import _variance
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.gap.perception.position_fit import Positions
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

MODEL = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n")


def bands(near: float, far: float, unsure: float = 0.01) -> FloatArray:
    return np.array([[near, unsure], [far, unsure]])


def rule(value: float, shown: float, base: float) -> float:
    return _variance(value, shown, base, find_effect("detection_noise").key("sigma0"))


def test_noise_differs_where_one_band_is_off_beyond_chance() -> None:
    assert noise_differs(bands(0.20, 0.10), bands(0.10, 0.10), has_noise=False)
    assert not noise_differs(bands(0.12, 0.10), bands(0.10, 0.10), has_noise=False)  # 1.4 standard deviations
    assert not noise_differs(bands(0.115, 0.1, 0.001), bands(0.1, 0.1, 0.001), has_noise=False)  # less than 0.02 m


def test_a_noise_that_the_model_has_is_moved_on_until_it_is_settled() -> None:
    """13 % off by 1.4 standard deviations: no sure difference, but more likely than not; 7 % is settled."""
    assert noise_differs(bands(0.30, 0.30, 0.02), bands(0.26, 0.30, 0.02), has_noise=True)
    assert not noise_differs(bands(0.30, 0.30, 0.02), bands(0.26, 0.30, 0.02), has_noise=False)
    assert not noise_differs(bands(0.30, 0.30, 0.02), bands(0.28, 0.30, 0.02), has_noise=True)
    assert not noise_differs(bands(0.30, 0.30, 0.10), bands(0.26, 0.30, 0.10), has_noise=True)  # by chance


def test_values_are_the_line_through_what_the_bands_need() -> None:
    """Bands around 10 m and 30 m: 0.3 m and 0.5 m are 0.2 m and 0.01 of the distance."""
    sigma0, slope = noise_needed(bands(0.5, math.hypot(0.5, 0.1)), bands(0.4, 0.1), (0.0, 0.0), rule)
    assert (sigma0, slope) == pytest.approx((0.2, 0.01))  # 0.5^2 - 0.4^2 = 0.3^2
    assert noise_needed(bands(0.5, 0.3), bands(0.3, 0.0), (0.0, 0.0), rule) == pytest.approx((0.35, 0.0))  # falls
    assert noise_needed(bands(0.0, 0.3), bands(0.0, 0.0), (0.0, 0.0), rule) == pytest.approx((0.0, 0.009))  # 9 / 1000
    # what the tracker dampens: with 0.2 m the twin shows 0.1 of the car's 0.2, so it needs twice as much
    assert noise_needed(bands(0.2, 0.2), bands(0.1, 0.1), (0.2, 0.0), rule) == pytest.approx((0.4, 0.0))


def positions(sigma: float, turned: int = 0) -> Positions:
    """40 objects at rest between 5 m and 35 m, each seen 50 times; of `turned` all boxes are 5 m off to a side."""
    rng = np.random.default_rng(3)
    at = np.tile(np.linspace(5.0, 35.0, 40), (50, 1))
    dx, dy = rng.normal(0.0, sigma, (2, *at.shape))
    dy[:, :turned] += np.where(np.arange(turned) % 2 == 0, 5.0, -5.0)
    frames: Any = SimpleNamespace(t=np.arange(50) * 0.1)
    still = np.zeros_like(at)
    pairs: Any = SimpleNamespace(
        seen=np.ones_like(at, dtype=bool), dx=dx, dy=dy, vx=still, vy=still, yaw=np.zeros(50), distance=at
    )
    return Positions(frames, pairs, np.array([sigma, 0.0]))


@pytest.mark.parametrize("sigma", [0.1, 0.4])
def test_levels_are_those_of_the_boxes_whatever_single_objects_are_taken_for(sigma: float) -> None:
    levels, wild = positions(sigma).levels(), positions(sigma, turned=2).levels()
    assert levels is not None
    assert wild is not None
    assert levels[:, 0] == pytest.approx(sigma, rel=0.05)
    assert wild[:, 0] == pytest.approx(sigma, rel=0.3)  # by all squares the near band would have 1.1 m
    assert np.all((levels[:, 1] > 0.0) & (levels[:, 1] < 0.05 * sigma))


def named(monkeypatch: pytest.MonkeyPatch, car: Perceived, twin: Perceived) -> dict[str, Any]:
    log, run = (SimpleNamespace(meta={"stage": ""}), SimpleNamespace(meta={"stage": "dt"}))
    monkeypatch.setattr(module, "perceived_in", lambda one: car if one is log else twin)
    return {e.name: e for e in diagnose_perception(log, MODEL, twin=run)}  # type: ignore[arg-type]


def test_misses_wait_for_noise_that_makes_a_tracker_lose_what_it_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = {("detection_noise", "sigma0"): (0.1, 0.0, 0.4), ("detection_noise", "slope"): (0.01, 0.0, 0.03)}
    misses = {("detection_misses", "rate"): (0.3, 0.25, 0.35)}
    without = {("detection_misses", "rate"): (0.1, 0.08, 0.12)}
    worth = {"detection_noise": 5.0, "detection_misses": 5.0}
    car = Perceived({**noise, **misses}, worth, {}, bands(0.3, 0.3))
    found = named(monkeypatch, car, Perceived({**noise, **without}, worth, {}, bands(0.1, 0.1)))
    assert found["detection_noise"].standing == "confirmed"
    assert found["detection_misses"].rivals == ("detection_noise",)
    alike = named(monkeypatch, car, Perceived({**noise, **without}, worth, {}, bands(0.3, 0.3)))
    assert set(alike) == {"detection_misses"}
    assert alike["detection_misses"].standing == "confirmed"


@pytest.mark.parametrize(
    ("given", "shown", "changes"),
    [
        (True, (0.30, 0.15, 0.52), True),  # 8 of 16 counted: by chance in one of ten, and dampened before
        (True, (0.56, 0.38, 0.80), False),  # 7 % off: settled
        (False, (0.30, 0.15, 0.52), False),
    ],
)
def test_what_a_tracker_dampens_is_moved_on_until_it_is_settled(
    given: bool, shown: tuple[float, float, float], changes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, worth = ("detection_false", "rate"), {"detection_false": 5.0}
    model = MODEL.with_effect("detection_false", {"rate": 0.6}) if given else MODEL
    log, run = SimpleNamespace(meta={"stage": ""}), SimpleNamespace(meta={"stage": "dt"})
    found = {id(log): (0.60, 0.39, 0.90), id(run): shown}
    monkeypatch.setattr(module, "perceived_in", lambda one: Perceived({key: found[id(one)]}, worth, {}))
    told = diagnose_perception(log, model, twin=run)  # type: ignore[arg-type]
    assert [e.name for e in told] == (["detection_false"] if changes else [])


def test_false_objects_wait_for_what_moves_boxes_and_not_for_borders(monkeypatch: pytest.MonkeyPatch) -> None:
    worth = {"detection_false": 5.0, "detection_occlusion": 5.0, "detection_latency": 5.0}
    false, share, late = (("detection_false", "rate"), ("detection_occlusion", "share"), ("detection_latency", "T"))
    car = {false: (2.0, 1.5, 2.6), share: (0.4, 0.3, 0.5)}
    twin = {false: (0.1, 0.0, 0.3), share: (0.9, 0.8, 1.0)}
    assert named(monkeypatch, Perceived(car, worth, {}), Perceived(twin, worth, {}))["detection_false"].rivals == ()
    car, twin = {**car, late: (0.4, 0.35, 0.45)}, {**twin, late: (0.1, 0.05, 0.15)}
    found = named(monkeypatch, Perceived(car, worth, {}), Perceived(twin, worth, {}))
    assert found["detection_false"].rivals == ("detection_latency",)
