"""Small rules of metrics and bounds, each of which one number or one word decides."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from results_logs import drive_straight, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable
from pytest_dvp.metrics import command_response, compute
from pytest_dvp.verdicts.clean_gates import read_clean

TICKS = np.arange(0.0, 5.01, 0.05)


def test_the_rate_of_steering_at_the_cutoff_of_5_hz_counts_by_half() -> None:
    """A Butterworth filter of order 2 leaves 1 / sqrt(2) at its cut-off; zero phase means that it is applied twice."""
    t = np.arange(0.0, 4.0, 0.001)
    swelling = np.sin(0.25 * np.pi * t) ** 2  # so that the filter has nothing to do at the ends
    steer = 0.1 * swelling * np.sin(2.0 * np.pi * 5.0 * t)
    found = compute("max_steer_rate", Log({"t": t, "steer": steer}))
    assert found.value == pytest.approx(0.5 * 0.1 * 2.0 * np.pi * 5.0, rel=0.01)
    assert found.t == pytest.approx(2.0, abs=0.11)


def test_a_response_is_looked_at_up_to_the_last_stamp_and_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(command_response, "likeness", lambda *given: asked.append(given))
    t = 0.1 * np.arange(11.0)
    command_response._compare(Log({"t": t, "steer_cmd": 0.1 * t, "steer": 0.2 * t}), "steer_cmd", "steer")
    ((command, signal, step, _),) = asked
    assert step == pytest.approx(0.1)
    assert command == pytest.approx(0.1 * t)
    assert signal == pytest.approx(0.2 * t)


@pytest.mark.parametrize(("speed", "valid"), [(1.0, False), (1.125, True)])
def test_a_road_user_moves_above_one_metre_a_second_not_at_it(speed: float, valid: bool) -> None:
    x, y = 12.0 + speed * TICKS, np.full(len(TICKS), 1.0)
    more = {name: np.zeros(len(TICKS)) for name in ("yaw", "length", "width", "vx", "vy")}
    detections = DetectionTable(t=TICKS, kind=("vehicle",) * len(TICKS), x=x, y=y, **more)
    log = drive_straight(1.0, objects={"car": track(TICKS, x, 1.0, vx=speed)}, detections=detections)
    found = compute("track_latency", log)
    assert found.valid is valid
    if not valid:
        assert found.reason == "no detected road user ahead was faster than 1 m/s"


def test_the_first_instant_at_which_a_road_user_is_not_measured_is_named() -> None:
    car = track(TICKS, 62.0, 0.0)
    car.x[[40, 60]] = np.nan
    assert compute("max_ttc_inverse", drive_straight(5.0, objects={"car": car})).reason == (
        "position or speed of car is not measured at t=2.00 s"
    )


def test_of_a_long_bound_eighty_letters_are_said() -> None:
    said: list[Any] = []
    table = {"only_if_logged": "ads.position_sigma", "max": {"localization_error": 100 * "x"}}
    read_clean(table, "[clean]\n", "a.gates.toml", lambda *told, **more: said.append((told[0], more)))
    assert said == [("bound", {"found": 80 * "x"})]
