"""CommonRoad's vehicle models on one manoeuvre: runs inside the temporary environment of bench_commonroad, on its own.

    python commonroad_peer.py < manoeuvre.json > figures.json

Reads {"period" [s], "steer" [rad], "accel" [m/s^2], "speed" [m/s]}: commands at the ends of every period (n + 1) and
the mean acceleration over each (n). Writes the car's parameters, and for each way of integrating it the simulated
seconds per CPU second and where the car ends.
Source: M. Althoff, G. Wuersching, "CommonRoad: Vehicle Models", TU Muenchen, 2020.
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import odeint
from vehiclemodels.init_mb import init_mb  # type: ignore[import-not-found]
from vehiclemodels.init_st import init_st  # type: ignore[import-not-found]
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2  # type: ignore[import-not-found]
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb  # type: ignore[import-not-found]
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st  # type: ignore[import-not-found]

Rhs = Callable[[Any, list[float], Any], list[float]]
COARSE, FINE = 0.01, 0.001  # s


def rk4(rhs: Rhs, x: Any, u: list[float], p: Any, h: float) -> Any:
    """One step of the classic Runge-Kutta method."""
    k1 = np.array(rhs(x, u, p))
    k2 = np.array(rhs(x + 0.5 * h * k1, u, p))
    k3 = np.array(rhs(x + 0.5 * h * k2, u, p))
    k4 = np.array(rhs(x + h * k3, u, p))
    return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def by_rk4(rhs: Rhs, x: Any, inputs: list[list[float]], p: Any, period: float, h: float) -> Any:
    """State after all inputs, each held for a period."""
    for u in inputs:
        for _ in range(round(period / h)):
            x = rk4(rhs, x, u, p, h)
    return x


def by_odeint(x: Any, inputs: list[list[float]], p: Any, period: float) -> Any:
    """The same by scipy's variable-step solver, started anew at every command, as a closed loop has to."""
    for u in inputs:
        x = odeint(lambda y, _t, u=u: vehicle_dynamics_st(y, u, p), x, (0.0, period))[-1]
    return x


def in_one_go(x: Any, inputs: list[list[float]], p: Any, period: float) -> Any:
    """One call of the solver, commands running straight from one to the next: its step is as long as it likes."""
    table = np.array(inputs)
    middles = (np.arange(len(inputs)) + 0.5) * period

    def slope(y: Any, t: float) -> list[float]:
        place = min(max(t / period - 0.5, 0.0), len(middles) - 1.0)
        k = min(int(place), len(middles) - 2)
        a, b = table[k].tolist(), table[k + 1].tolist()
        part = place - k
        u = [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
        f: list[float] = vehicle_dynamics_st(y, u, p)
        return f

    return odeint(slope, x, np.arange(len(inputs) + 1) * period)[-1]


def measured(run: Callable[[], Any], seconds: float, repeats: int) -> dict[str, float]:
    """Median simulated seconds per CPU second, and the end of the run."""
    spent = []
    for _ in range(repeats):
        begin = time.process_time()
        end = run()
        spent.append(time.process_time() - begin)
    return {"speed": seconds / statistics.median(spent), "x": float(end[0]), "y": float(end[1])}


def main() -> int:
    asked = json.load(sys.stdin)
    period, steer, accel = asked["period"], asked["steer"], asked["accel"]
    inputs = [[(b - a) / period, u] for a, b, u in zip(steer[:-1], steer[1:], accel, strict=True)]
    p = parameters_vehicle2()
    start = [0.0, 0.0, steer[0], asked["speed"], 0.0, 0.0, 0.0]
    single, multi = np.array(init_st(start)), np.array(init_mb(start, p))
    seconds = len(inputs) * period
    short = max(1, len(inputs) // 10)  # the multi-body model is some 1000 times slower
    stiffness = -p.tire.p_ky1 * p.m * 9.81 / (p.a + p.b)  # N/rad per metre of lever: mu C_S F_z of an axle
    figures = {
        "car": {
            "wheelbase": p.a + p.b,
            "cg_to_front_axle": p.a,
            "mass": p.m,
            "yaw_inertia": p.I_z,
            "cornering_stiffness_front": stiffness * p.b,
            "cornering_stiffness_rear": stiffness * p.a,
        },
        "rk4": measured(lambda: by_rk4(vehicle_dynamics_st, single, inputs, p, period, COARSE), seconds, 3),
        "odeint": measured(lambda: by_odeint(single, inputs, p, period), seconds, 3),
        "odeint_once": measured(lambda: in_one_go(single, inputs, p, period), seconds, 3),
        "multi_body": measured(
            lambda: by_rk4(vehicle_dynamics_mb, multi, inputs[:short], p, period, FINE), short * period, 3
        ),
    }
    assert all(math.isfinite(v) for way in figures.values() for v in way.values())
    json.dump(figures, sys.stdout)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
