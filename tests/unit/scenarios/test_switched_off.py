"""Each scenario fails, by the gate made for it, when the net of its behaviour is switched off."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pytest

import scenarios
from ads.parameters import Parameters
from ads.planning.behaviour import Behaviour
from ads.planning.nets import NETS
from ads.planning.route import Map
from ads.stack import Stack
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from vehicle.messages import VehicleDescription


def without(*switched_off: str) -> Callable[[Parameters, Map, VehicleDescription], Stack]:
    """Maker of the reference stack whose nets of these names never fire."""
    nets = tuple(dataclasses.replace(net, transitions=()) if net.name in switched_off else net for net in NETS)

    def make(parameters: Parameters, network: Map, car: VehicleDescription) -> Stack:
        return Stack(parameters, network, car, planner=Behaviour(parameters, car, nets))

    return make


def failures(result: RunResult) -> list[str]:
    """Metrics of the gates that failed; the event's name where the gate is about one."""
    return [v.message.split("(")[1].split(")")[0] if v.metric == "event_started" else v.metric for v in result.verdicts
            if v.status != "PASS"]  # fmt: skip


@pytest.mark.parametrize("name", ["follow", "traffic_light", "junction"])
@pytest.mark.nightly
def test_the_reference_stack_passes(name: str) -> None:
    assert failures(run(scenarios.path(f"{name}.xosc"))) == []


def test_follow_fails_by_time_to_collision_when_nothing_is_followed() -> None:
    result = run(scenarios.path("follow.xosc"), ads=without("following"))
    assert {"max_ttc_inverse", "tet"} <= set(failures(result))


def test_traffic_light_fails_by_running_red_when_lights_are_ignored() -> None:
    result = run(scenarios.path("traffic_light.xosc"), ads=without("light"))
    assert {"RunsRed", "WaitsAtRed"} <= set(failures(result))


def test_junction_fails_by_cutting_in_when_nobody_is_let_pass() -> None:
    result = run(scenarios.path("junction.xosc"), ads=without("junction"))
    assert {"CutsIn", "max_ttc_inverse", "tet"} <= set(failures(result))


def test_on_a_slope_the_car_is_held_and_sets_off_without_rolling_back() -> None:
    """With this noise it once came to rest, rolled back and never stood."""
    result = run(scenarios.path("slope_stop.xosc"), seed=13)
    assert failures(result) == []
    assert result.metrics["creep"] < 0.35
    assert result.log["v"].min() > -0.3
