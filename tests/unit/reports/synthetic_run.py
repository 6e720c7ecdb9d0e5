"""A run made by formulas, to develop and test the report without a simulator.

The ego drives 120 m along a straight street, brakes for a pedestrian and goes on; three lines of road, a crosswalk, one
parked car, two Petri nets.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def synthetic_run(status: str = "PASS", name: str = "pedestrian_crossing") -> dict[str, Any]:
    """Keyword arguments of write_run_report."""
    t = np.arange(0.0, 40.0, 0.01)
    v = 5.5 - 4.0 * np.exp(-(((t - 17.0) / 4.0) ** 2))
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * 0.01)])
    y = -1.75 + 0.3 * np.sin(x / 12.0)
    slope = 0.3 / 12.0 * np.cos(x / 12.0)
    yaw = np.arctan(slope)
    steer = 0.12 * np.sin(x / 9.0)
    ax = np.gradient(v, t)
    waits = (t > 14.0) & (t < 21.0)
    columns = {
        "t": t, "x": x, "y": y, "yaw": yaw, "v": v, "steer": steer, "ax": ax, "steer_cmd": steer * 1.05,
        "accel_cmd": ax * 1.1, "ads.target_speed": np.where(waits, 1.5, 5.5), "ads.x": x, "ads.y": y,
        "ads.net.crossing.clear": (~waits).astype(float), "ads.net.crossing.give_way": waits.astype(float),
        "ads.net.overtaking.follow": np.ones_like(t),
    }  # fmt: skip
    ticks = np.arange(0.0, 40.0, 0.05)
    walk = np.clip((ticks - 13.0) * 2.0, 0.0, 12.5)
    pedestrian = {
        "name": "Pedestrian", "kind": "pedestrian", "length": 0.6, "width": 0.5, "height": 1.8, "t": ticks,
        "x": np.full_like(ticks, 90.0), "y": 8.0 - walk, "z": np.full_like(ticks, 0.9),
        "yaw": np.full_like(ticks, -np.pi / 2), "vx": np.zeros_like(ticks), "vy": np.gradient(-walk, ticks),
    }  # fmt: skip
    parked = {
        "name": "Parked", "kind": "vehicle", "length": 4.3, "width": 1.8, "height": 1.5, "t": ticks,
        "x": np.full_like(ticks, 60.0), "y": np.full_like(ticks, 4.6), "z": np.full_like(ticks, 0.75),
        "yaw": np.full_like(ticks, np.pi), "vx": np.zeros_like(ticks), "vy": np.zeros_like(ticks),
    }  # fmt: skip
    seen = (ticks > 10.0) & (ticks < 22.0)
    rows = int(seen.sum())
    wobble = 0.15 * np.sin(7.0 * ticks[seen])
    detections = {
        "t": ticks[seen], "kind": ("pedestrian",) * rows, "x": 90.0 + wobble, "y": (8.0 - walk)[seen] + wobble,
        "yaw": np.full(rows, -np.pi / 2), "length": np.full(rows, 0.7), "width": np.full(rows, 0.6),
        "vx": np.zeros(rows), "vy": np.full(rows, -2.0),
    }  # fmt: skip
    along = np.linspace(0.0, 30.0, 40)
    paths = [
        (float(at), np.stack([x[int(at * 100)] + along, np.full(40, -1.75)], axis=1)) for at in np.arange(0, 39, 0.5)
    ]
    span = np.linspace(-10.0, 230.0, 30)
    road = [
        {"kind": kind, "points": np.stack([span, np.full(30, offset)], axis=1)}
        for kind, offset in (("edge", 3.5), ("centre", 0.0), ("edge", -3.5), ("lane", 5.5), ("lane", -5.5))
    ]
    zebra = np.array([[88.5, -3.5], [91.5, -3.5], [91.5, 3.5], [88.5, 3.5]])
    road.append({"kind": "crosswalk", "points": zebra})
    events = [
        {"t": 0.0, "kind": "story.event", "element": "Story/Act/StepOff", "text": "standbyState", "file": "",
         "line": None},
        {"t": 13.0, "kind": "story.event", "element": "Story/Act/StepOff", "text": "standbyState -> runningState",
         "file": f"{name}.xosc", "line": 96},
        {"t": 19.25, "kind": "story.event", "element": "Story/Act/StepOff", "text": "runningState -> completeState",
         "file": f"{name}.xosc", "line": 96},
        {"t": 38.0, "kind": "goal", "element": "Ego", "text": "goal reached", "file": "", "line": None},
    ]  # fmt: skip
    closing = np.where((ticks > 13.0) & (ticks < 18.0), 0.41 * np.exp(-((ticks - 15.4) ** 2)), 0.0)
    failed = status == "FAIL"
    peak = 1.31 if failed else 0.41
    series = {"t": ticks, "value": closing * peak / 0.41}

    def verdict(metric: str, sign: str, bound: float, value: float, unit: str, **more: Any) -> dict[str, Any]:
        ok = value <= bound if sign == "<=" else value >= bound
        return {
            "gate": f"{metric} {sign} {bound:g} {unit}", "metric": metric, "status": "PASS" if ok else "FAIL",
            "value": value, "unit": unit, "bound": bound, "margin": bound - value if sign == "<=" else value - bound,
            "t": None, "object": "", "message": f"{metric} {value:g} {sign} {bound:g} at {name}.gates.toml:9",
            "short": metric, "file": f"{name}.gates.toml", "line": 9, **more,
        }  # fmt: skip

    result = {
        "status": status, "scenario": f"{name}.xosc", "stage": "dt", "seed": 7,
        "verdicts": [
            verdict("collision", "<=", 0.0, 0.0, "-"),
            verdict("tet", "<=", 0.0, 0.0, "s"),
            verdict("max_ttc_inverse", "<=", 0.5, peak, "1/s", t=15.4, object="Pedestrian"),
            verdict("lateral_rmse_path", "<=", 0.4, 0.12, "m", t=31.0),
            verdict("max_jerk", "<=", 4.0, 2.74, "m/s^3", t=13.62),
            verdict("goal_reached", ">=", 1.0, 1.0, "-", t=38.0),
        ],
        "metrics": {
            "max_ttc_inverse": {"value": peak, "unit": "1/s", "t": 15.4, "object": "Pedestrian", "valid": True,
                                "reason": "", "series": series},
            "completion_time": {"value": 38.0, "unit": "s", "t": None, "object": None, "valid": True, "reason": "",
                                "series": None},
            "mncc": {"value": None, "unit": "-", "t": None, "object": None, "valid": False,
                     "reason": "needs two logs", "series": None},
        },
    }  # fmt: skip
    meta = {
        "scenario": f"{name}.xosc", "scenario_sha256": "5d0c" * 16, "stage": "dt", "seed": 7, "model": "tabby_evo",
        "parameters": {"ego_speed": 5.5, "pedestrian_speed": 2.0, "trigger_distance": 20.0},
        "P": {"LQR_q11": 30.0, "LQR_v_max": 5.5, "MPC_w": 2.75}, "S": {"EGO_mass": 8500.0},
        "versions": {"pytest_dvp": "0.1.0", "numpy": "2.4.6"},
        "ego": {"name": "Ego", "length": 3.03, "width": 1.488, "center_x": 1.18},
        "task": {"start": ["4", -1, 6.0], "goal": ["5", -1, 66.0]},
    }  # fmt: skip
    return {
        "result": result, "columns": columns, "objects": [pedestrian, parked], "detections": detections,
        "paths": paths, "events": events, "road": road, "meta": meta,
    }  # fmt: skip
