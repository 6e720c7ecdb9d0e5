"""A spoilt driving stack fails a gate that names the fault; the same scenario with the stack as it is passes it."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import pytest

from ads.control.pedals import PiPedals
from ads.parameters import Parameters
from ads.planning.route import Map
from ads.stack import Stack
from pytest_dvp.drive.run import run
from pytest_dvp.verdicts.judging import Verdict
from scenarios import path
from vehicle.messages import VehicleDescription


@dataclasses.dataclass
class InvertedBrake:
    """Pedals of which the brake drives."""

    sound: PiPedals

    def press(self, accel: float, v: float, standing: bool, dt: float) -> tuple[float, float]:
        throttle, brake = self.sound.press(accel, v, standing, dt)
        return max(throttle, brake), 0.0


def blind(parameters: Parameters, network: Map, vehicle: VehicleDescription) -> Stack:
    return Stack(parameters, network, vehicle, perception=None)


def brake_inverted(parameters: Parameters, network: Map, vehicle: VehicleDescription) -> Stack:
    return Stack(parameters, network, vehicle, pedals=InvertedBrake(PiPedals(vehicle)))


FAULTS: dict[str, dict[str, Any]] = {
    "none": {},
    "perception off": {"ads": blind},
    # At 2.0 m/s he comes to the car's side, 8.75 m off, 0.1 s after it has gone by: 17.6 m at crossing speed, 4.1 m/s.
    "perception off, pedestrian at 2.3 m/s": {"ads": blind, "parameters": {"pedestrian_speed": 2.3}},
    "brake inverted": {"ads": brake_inverted},
    "no distance kept to an occupied crossing": {"P": {"DECISION_PC_d_min": 0.0}},
    "LQR gain 0": {"P": {"LQR_q11": 0.0, "LQR_q22": 0.0}},  # no weight on any error: the gain is 0, feed-forward stays
}


@functools.cache
def verdicts(scenario: str, fault: str, seed: int = 7) -> dict[str, Verdict]:
    """Verdicts by metric of one drive."""
    result = run(path(scenario), seed=seed, rootdir=path(scenario).parent, **FAULTS[fault])
    assert result.error is None
    return {verdict.metric: verdict for verdict in result.verdicts}


def statuses(scenario: str, fault: str) -> dict[str, str]:
    return {metric: verdict.status for metric, verdict in verdicts(scenario, fault).items()}


@pytest.mark.parametrize("scenario", ["pedestrian_crossing.xosc", "overtaking.xosc"])
@pytest.mark.nightly
def test_the_sound_stack_passes_every_gate(scenario: str) -> None:
    assert {metric for metric, status in statuses(scenario, "none").items() if status != "PASS"} == set()


@pytest.mark.parametrize(
    ("scenario", "fault", "hit"),
    [
        ("pedestrian_crossing.xosc", "perception off, pedestrian at 2.3 m/s", "Pedestrian"),
        ("overtaking.xosc", "perception off", "Target"),
    ],
)
def test_without_perception_the_ego_hits_what_it_does_not_see(scenario: str, fault: str, hit: str) -> None:
    collision = verdicts(scenario, fault)["collision"]
    assert (collision.status, collision.object) == ("FAIL", hit)


def test_with_an_inverted_brake_the_ego_does_not_stop_for_the_standing_vehicle() -> None:
    collision = verdicts("overtaking.xosc", "brake inverted")["collision"]
    assert (collision.status, collision.object) == ("FAIL", "Target")


def test_without_a_stopping_distance_the_ego_comes_too_close_to_the_pedestrian() -> None:
    # The emergency net still prevents the collision; what it cannot keep is the time to collision of 2 s and the jerk.
    found = statuses("pedestrian_crossing.xosc", "no distance kept to an occupied crossing")
    assert found["collision"] == "PASS"
    assert (found["tet"], found["max_ttc_inverse"], found["max_jerk"]) == ("FAIL", "FAIL", "FAIL")


@pytest.mark.nightly
def test_with_a_steering_gain_of_zero_the_ego_leaves_the_planned_path() -> None:
    # Feed-forward alone follows a bend, but nothing takes back what sensor noise adds up to: five drives, five drifts.
    sound, spoilt = (
        [verdicts("overtaking.xosc", fault, seed)["lateral_rmse_path"].status for seed in range(5)]
        for fault in ("none", "LQR gain 0")
    )
    assert sound == ["PASS"] * 5
    assert "FAIL" in spoilt
