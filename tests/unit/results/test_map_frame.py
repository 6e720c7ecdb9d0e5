"""No figure of a drive depends on where the map has its origin, which way its axes point, which side is left, and when
the clock began."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from results_logs import log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, LogEvent
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._box_gaps import distances, extents, overlap
from pytest_dvp.metrics._objects_ahead import is_ahead

RSS = {"response_time": 0.5, "max_acceleration": 2.0, "max_braking": 8.0, "min_braking": 4.0}
RSS |= {"lateral_acceleration": 0.5, "lateral_braking": 1.0, "lateral_margin": 0.2}
TICKS = np.arange(0.0, 10.01, 0.05)
SHIFT = (120.0, -35.0)  # m
DRIVE = ("max_ttc_inverse", "min_distance", "min_distance_lateral", "min_distance_longitudinal", "time_headway",
         "required_deceleration", "rss_violation", "pet", "passing_clearance", "lane_time_outside", "lateral_rmse",
         "stop_line", "red_light")  # fmt: skip
TRACKS = ("detection_recall", "false_tracks", "track_position_error", "track_yaw_error", "track_latency", "nees",
          "identity_switches")  # fmt: skip

OPTIONS = {"rss_violation": RSS, "lane_time_outside": {"width": 3.0}, **{name: {"reach": 60.0} for name in TRACKS}}


@cache
def scene(turn: float, left: float = 1.0) -> Log:
    """An ego that sways and slides a little behind a slower car, one that comes along, one who crosses, and what a
    stack saw of it; all of it turned by an angle and moved, with `left` of -1 as a mirror shows it."""
    c, s = math.cos(turn), math.sin(turn)

    def placed(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        return c * x - s * left * y + SHIFT[0], s * x + c * left * y + SHIFT[1]

    def moving(vx: FloatArray, vy: FloatArray) -> tuple[FloatArray, FloatArray]:
        return c * vx - s * left * vy, s * vx + c * left * vy

    t, k, one = times(), TICKS, np.ones(len(TICKS))
    x, y = placed(6.0 * t, 0.9 * np.sin(0.8 * t))
    yaw, vy, yaw_rate = 0.1 * np.cos(0.8 * t), 0.3 * np.sin(t), -0.08 * np.sin(0.8 * t)
    sway = {"yaw": turn + left * yaw, "vy": left * vy, "yaw_rate": left * yaw_rate}
    columns = {"x": x, "y": y, "v": 6.0, "vx": 6.0, **sway}
    users = {
        "lead": (38.0 + 3.0 * k, 0.4 * one, 0.05, 3.0 * one, 0.15 * one, "vehicle"),
        "oncoming": (90.0 - 5.0 * k, 3.0 * one, math.pi - 0.03, -5.0 * one, 0.0 * one, "vehicle"),
        "walker": (30.0 * one, -4.0 + 1.8 * k, 0.5 * math.pi, 0.0 * one, 1.8 * one, "pedestrian"),
    }
    objects = {}
    for name, (ox, oy, yaw, vx, vy, kind) in users.items():
        (px, py), (wx, wy) = placed(ox, oy), moving(vx, vy)
        objects[name] = track(k, px, py, yaw=left * yaw + turn, vx=wx, vy=wy, kind=kind)  # type: ignore[arg-type]
    late = 3.0 * 0.2
    px, py = placed(38.0 + 3.0 * k - late, 0.4 - 0.3 * np.sin(3.0 * k))
    far = k > 6.0
    px[far], py[far] = placed(38.0 + 3.0 * k[far] - 9.0, 2.0 * one[far])
    xx, xy, yy = 0.5, left * 0.1, 0.2
    p = np.array([[c, -s], [s, c]]) @ np.array([[xx, xy], [xy, yy]]) @ np.array([[c, s], [-s, c]])
    wx, wy = moving(3.0 * one, 0.15 * one)
    kinds = ("vehicle",) * len(k)
    seen = DetectionTable(
        t=k, kind=kinds, x=px, y=py, yaw=turn + left * 0.15 * one, length=4.0 * one, width=2.0 * one, vx=wx, vy=wy,
        track=np.where(k < 3.0, 1.0, 2.0), cov_xx=p[0, 0] * one, cov_xy=p[0, 1] * one, cov_yy=p[1, 1] * one,
    )  # fmt: skip
    lx, ly = placed(np.array([-5.0, 20.0, 80.0]), np.array([0.0, 0.5, 0.0]))
    (qx,), (qy,) = placed(np.array([35.0]), np.array([0.0]))
    meta = {"stop_lines": [{"signal": "1", "x": float(qx), "y": float(qy), "heading": turn, "width": 3.5}]}
    return log_of(columns=columns, objects=objects, detections=seen, reference=np.column_stack((lx, ly)), meta=meta,
                  events=(LogEvent(1.0, "signal", "1", "red"),))  # fmt: skip


@pytest.mark.parametrize(("turn", "left"), [(0.7, 1.0), (0.5 * math.pi, 1.0), (-2.2, 1.0), (0.0, -1.0)])
@pytest.mark.parametrize("name", [*DRIVE, *TRACKS])
def test_a_figure_is_the_same_on_a_turned_map_and_in_a_mirror(name: str, turn: float, left: float) -> None:
    here, there = (compute(name, log, **OPTIONS.get(name, {})) for log in (scene(0.0), scene(turn, left)))
    assert here.valid
    assert here.value is not None
    assert there.value == pytest.approx(here.value, rel=1e-6, abs=1e-9)
    assert there.object == here.object
    assert name in TRACKS or there.t == here.t  # tracks: errors that are the same at several times
    signed = {key for key in here.extra if left < 0.0 and key == "left"}
    assert {k: v for k, v in there.extra.items() if k not in signed} == pytest.approx(
        {k: v for k, v in here.extra.items() if k not in signed}, rel=1e-6, abs=1e-9
    )


def test_the_scene_has_something_to_tell() -> None:
    """Else a figure could be the same because it is nought."""
    found = {name: compute(name, scene(0.0), **OPTIONS.get(name, {})).value for name in (*DRIVE, *TRACKS)}
    assert all(value is not None and value > 0.0 for name, value in found.items()), found


COMFORT = ("max_jerk", "max_acceleration", "max_deceleration", "accel_roughness", "steer_roughness", "max_steer_rate",
           "max_lateral_acceleration", "max_lateral_jerk", "max_yaw_rate", "repeated_commands", "response_lag",
           "response_gain", "creep")  # fmt: skip


@cache
def restless() -> Log:
    """A car that speeds up and down, stops and steers, with commands from 1 s on, of steps of 0.05 s."""
    t = times()
    v = np.maximum(4.0 + 3.0 * np.sin(t) - 0.4 * t, 0.0) + 0.001 * np.sin(40.0 * t)
    asked = np.where(t < 1.0, np.nan, 0.1 * np.sin(np.floor(t / 0.05 + 1e-6) * 0.1))
    steer, rate = 0.1 * np.sin(2.0 * t - 0.4), 0.2 * np.sin(2.0 * t)
    return log_of(columns={"v": v, "vx": v, "x": np.cumsum(v) * 0.01, "steer": steer, "yaw_rate": rate,
                           "vy": 0.1 * np.cos(t), "steer_cmd": asked, "accel_cmd": 8.0 * asked})  # fmt: skip


def later(log: Log, by: float) -> Log:
    """The same drive on a clock that began earlier by some time [s]."""
    objects = {name: dataclasses.replace(one, t=one.t + by) for name, one in log.objects.items()}
    return dataclasses.replace(
        log, columns={**log.columns, "t": log.t + by}, objects=objects,
        detections=dataclasses.replace(log.detections, t=log.detections.t + by),
        events=tuple(dataclasses.replace(event, t=event.t + by) for event in log.events),
    )  # fmt: skip


@pytest.mark.parametrize("name", [*DRIVE, *TRACKS, *COMFORT])
def test_a_figure_is_the_same_whenever_the_clock_began(name: str) -> None:
    log = restless() if name in COMFORT else scene(0.0)
    here, there = (compute(name, one, **OPTIONS.get(name, {})) for one in (log, later(log, 64.0)))
    assert here.valid, here.reason
    assert here.value is not None
    assert there.value == pytest.approx(here.value, rel=1e-5, abs=1e-9)
    assert there.object == here.object
    assert there.extra == pytest.approx(here.extra, rel=1e-5, abs=1e-9)
    if here.t is not None and name not in TRACKS:  # tracks: errors that are the same at several times
        assert there.t == pytest.approx(here.t + 64.0, abs=1e-6)


def turned(boxes: FloatArray, turn: float) -> FloatArray:
    c, s = math.cos(turn), math.sin(turn)
    out = boxes.copy()
    out[:, 0], out[:, 1] = c * boxes[:, 0] - s * boxes[:, 1] + 3.0, s * boxes[:, 0] + c * boxes[:, 1] - 7.0
    out[:, 2] += turn
    return out


def test_distances_of_boxes_are_the_same_on_a_turned_map() -> None:
    rng = np.random.default_rng(5)
    low, high = (-5.0, -5.0, -3.0, 0.5, 0.3), (5.0, 5.0, 3.0, 6.0, 2.5)
    one, other = rng.uniform(low, high, (2, 60, 5))
    for turn in (0.6, 2.5):
        a, b = turned(one, turn), turned(other, turn)
        assert distances(a, b) == pytest.approx(distances(one, other), abs=1e-9)
        assert (overlap(a, b) == overlap(one, other)).all()
        for axis in (0, 1):
            for there, here in zip(extents(a, b, axis), extents(one, other, axis), strict=True):
                assert there == pytest.approx(here, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    ("along", "across", "ahead"),
    [(0.01, 0.0, True), (-0.01, 0.0, False), (19.99, 0.0, True), (20.01, 0.0, False), (10.0, 1.99, True),
     (10.0, 2.01, False), (10.0, -1.99, True), (10.0, -2.01, False)],
)  # fmt: skip
@pytest.mark.parametrize("yaw", [0.0, 0.9, 2.6])
def test_ahead_is_a_corridor_from_the_bumper_on(along: float, across: float, yaw: float, ahead: bool) -> None:
    """20 m long and 2 m to each side; the bumper is 2.7 m ahead of the reference point."""
    c, s = math.cos(yaw), math.sin(yaw)
    u = along + 2.7
    log = log_of(1.0, columns={"x": 5.0, "y": 6.0, "yaw": yaw})
    x, y = np.array([5.0 + u * c - across * s]), np.array([6.0 + u * s + across * c])
    assert is_ahead(log, np.array([0.5]), x, y, 20.0, 2.0).tolist() == [ahead]
