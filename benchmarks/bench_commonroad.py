"""The twin's kernel beside CommonRoad's vehicle models (PyPI `commonroad-vehicle-models`): same car, same manoeuvre.

Ours ends some metres behind after 20 s: in its equations steered tyres cost speed, in the peer's they do not.
The peer is installed into a temporary environment of its own and runs in a process of its own (commonroad_peer.py).
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Row, cpu_seconds
from vehicle.messages import VehicleState
from vehicle.model.car import make_car
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import Inputs, VehicleModel

PEER = Path(__file__).with_name("commonroad_peer.py")
PACKAGES = ("commonroad-vehicle-models==3.0.2", f"numpy=={np.__version__}", "scipy")
INSTALL_TIME, RUN_TIME = 120.0, 60.0  # s, after which the peer is given up
SECONDS, PERIOD, SPEED = 20.0, 0.05, 10.0  # s, s, m/s
STEPS = round(PERIOD / 1e-3)
NAME = "single-track BMW 320i at 1 kHz, slalom"
# the car of the peer's parameter file 2, for when it cannot be asked
CAR = {
    "wheelbase": 2.578913,
    "cg_to_front_axle": 1.156196,
    "mass": 1093.295,
    "yaw_inertia": 1791.6,
    "cornering_stiffness_front": 129_700.0,
    "cornering_stiffness_rear": 105_400.0,
}


def manoeuvre() -> dict[str, Any]:
    """A slalom of up to 5 m/s^2, speeding up and slowing down: commands of a 20 Hz stack."""
    ends = np.arange(round(SECONDS / PERIOD) + 1) * PERIOD
    middles = ends[:-1] + 0.5 * PERIOD
    return {
        "period": PERIOD,
        "speed": SPEED,
        "steer": (0.06 * np.sin(1.5 * ends)).tolist(),
        "accel": np.sin(0.4 * middles).tolist(),
    }


def ask_peer(asked: dict[str, Any]) -> dict[str, Any] | str:
    """The peer's figures, or one line that says why there are none."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            venv.create(folder, with_pip=True)
            python = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin") / "python"
            pip = [str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", *PACKAGES]
            subprocess.run(pip, check=True, capture_output=True, timeout=INSTALL_TIME)
        except (OSError, subprocess.SubprocessError) as error:
            return f"peer not measured: {PACKAGES[0]} could not be installed ({type(error).__name__})"
        try:
            run = [str(python), "-I", str(PEER)]
            done = subprocess.run(
                run, check=True, capture_output=True, text=True, input=json.dumps(asked), timeout=RUN_TIME
            )
            figures: dict[str, Any] = json.loads(done.stdout)
        except (OSError, subprocess.SubprocessError, ValueError) as error:
            return f"peer not measured: it failed ({type(error).__name__})"
        return figures


def drive(car: dict[str, float], asked: dict[str, Any]) -> tuple[float, float, float]:
    """Ours: simulated seconds per CPU second, and where the centre of gravity ends [m]."""
    plant = Plant(VehicleModel("dynamic_bicycle", Inputs(), make_car(car)))
    steer = asked["steer"]
    held = [(0.5 * (a + b), u) for a, b, u in zip(steer[:-1], steer[1:], asked["accel"], strict=True)]
    rear = car["wheelbase"] - car["cg_to_front_axle"]

    def once() -> None:
        plant.reset(VehicleState(t=0.0, x=-rear, y=0.0, yaw=0.0, v=SPEED))
        for angle, accel in held:
            plant.command(angle, accel)
            plant.advance(STEPS)

    spent = cpu_seconds(once)
    end = plant.state
    return SECONDS / spent, end.x + rear * math.cos(end.yaw), end.y + rear * math.sin(end.yaw)


def run() -> list[Row]:
    """Rows of the table."""
    asked = manoeuvre()
    found = ask_peer(asked)
    car = CAR if isinstance(found, str) else found["car"]
    speed, x, y = drive(car, asked)
    if isinstance(found, str):
        return [Row(NAME, speed, "s/s", ">= 3x", "CommonRoad single-track, odeint", None, found)]

    def row(way: str, peer: str, goal: str = "", note: str = "") -> Row:
        return Row(NAME, speed, "s/s", goal, f"CommonRoad {peer}", found[way]["speed"], note)

    def apart(way: str) -> str:
        return f"end {math.hypot(x - found[way]['x'], y - found[way]['y']):.2f} m apart after {SECONDS:g} s"

    return [
        row("odeint_once", "single-track, odeint", ">= 3x", f"peer: smooth commands, one call; {apart('odeint_once')}"),
        row("odeint", "single-track, odeint", ">= 3x", f"new command every 50 ms; {apart('odeint')}"),
        row("rk4", "single-track, RK4 10 ms", "", f"new command every 50 ms; {apart('rk4')}"),
        row("multi_body", "multi-body, RK4 1 ms", "", "29 states; its first 2 s"),
    ]
