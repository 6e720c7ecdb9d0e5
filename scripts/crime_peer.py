"""Metrics beside CommonRoad-CriMe (Lin and Althoff, IEEE IV 2023; commonroad-crime on PyPI), on random pairs of boxes.

    python -m scripts.crime_peer draw 10000 > cases.jsonl
    crime/bin/python scripts/crime_peer.py ask < cases.jsonl > theirs.jsonl     # in an environment of its own
    python -m scripts.crime_peer compare cases.jsonl theirs.jsonl

A case is two boxes that keep their velocities for 3 s: half of the cases follow one another in a lane, half cross at
any angle, of which only the distance is compared.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

STEP, STEPS = 0.1, 30  # s; instants after the first
TURN = 0.001  # rad of the lane: CriMe 0.4.5 takes a lane along x for one without a direction
EGO, OTHER, LANE = 1, 2, 100


def draw(count: int) -> None:
    """One case a line: boxes of the ego and the other one, x, y [m], yaw [rad], length, width [m], speed [m/s]."""
    rng = np.random.default_rng(23)
    for k in range(count):
        ego = [0.0, 0.0, 0.0, rng.uniform(3.0, 6.0), rng.uniform(1.4, 2.2), rng.uniform(1.0, 20.0)]
        size = rng.uniform(0.5, 8.0), rng.uniform(0.4, 2.4)
        if k % 2:
            place = [rng.uniform(-10.0, 60.0), rng.uniform(-12.0, 12.0), rng.uniform(-math.pi, math.pi)]
        else:
            place = [rng.uniform(8.0, 80.0), rng.uniform(-0.5, 0.5), 0.0]
        print(json.dumps({"crossing": bool(k % 2), "ego": ego, "other": [*place, *size, rng.uniform(0.0, 15.0)]}))


def at(box: list[float], k: int) -> tuple[float, float]:
    """Where a box is after k steps, in the map whose lane is turned by TURN."""
    far = box[5] * k * STEP
    x, y = box[0] + far * math.cos(box[2]), box[1] + far * math.sin(box[2])
    return math.cos(TURN) * x - math.sin(TURN) * y, math.sin(TURN) * x + math.cos(TURN) * y


def ask() -> None:
    """What CriMe says of each case of stdin, a line each: DCE [m], and HW [m], THW, TTC [s], ALongReq [m/s^2]."""
    from commonroad.geometry.shape import Rectangle
    from commonroad.prediction.prediction import TrajectoryPrediction
    from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
    from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType
    from commonroad.scenario.scenario import Scenario
    from commonroad.scenario.state import CustomState, InitialState
    from commonroad.scenario.trajectory import Trajectory
    from commonroad_crime.data_structure.configuration import CriMeConfiguration
    from commonroad_crime.measure import DCE, HW, THW, TTC, ALongReq

    def lane() -> LaneletNetwork:
        s = np.arange(-100.0, 400.0, 20.0)
        axis, left = np.array([math.cos(TURN), math.sin(TURN)]), np.array([-math.sin(TURN), math.cos(TURN)])
        lines = [s[:, None] * axis + side * left for side in (60.0, 0.0, -60.0)]
        return LaneletNetwork.create_from_lanelet_list([Lanelet(*lines, lanelet_id=LANE)])

    def obstacle(number: int, box: list[float]) -> Any:
        shape, yaw = Rectangle(box[3], box[4]), box[2] + TURN
        state = {"orientation": yaw, "velocity": box[5]}
        first = InitialState(
            time_step=0, position=np.array(at(box, 0)), acceleration=0.0, yaw_rate=0.0, slip_angle=0.0, **state
        )
        rest = [CustomState(time_step=k, position=np.array(at(box, k)), **state) for k in range(1, STEPS + 1)]
        lanes = {k: {LANE} for k in range(STEPS + 1)}
        prediction = TrajectoryPrediction(Trajectory(1, rest), shape, lanes, lanes)
        return DynamicObstacle(number, ObstacleType.CAR, shape, first, prediction, {LANE}, {LANE})

    config = CriMeConfiguration()
    for line in sys.stdin:
        case, said = json.loads(line), {}
        for measure in (DCE,) if case["crossing"] else (DCE, HW, THW, TTC, ALongReq):
            scenario = Scenario(STEP)
            scenario.add_objects(lane())
            scenario.add_objects([obstacle(EGO, case["ego"]), obstacle(OTHER, case["other"])])
            config.update(ego_id=EGO, sce=scenario)
            value = measure(config).compute(OTHER, 0, verbose=False)
            said[measure.__name__] = float(value) if math.isfinite(value) else None
        print(json.dumps(said), flush=True)


def ours(case: dict[str, Any]) -> dict[str, float | None]:
    """Our metrics of a case by the names of CriMe, at its first instant; DCE: over all but the last, as CriMe does."""
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.log_contents import ObjectTrack
    from pytest_dvp.metrics import compute

    t = np.arange(STEPS) * STEP
    ego, other = ([np.array([at(box, k) for k in range(STEPS)]).T, box] for box in (case["ego"], case["other"]))
    still = dict.fromkeys(("vy", "yaw_rate"), np.zeros(len(t)))
    speed = np.full(len(t), ego[1][5])
    columns = {"t": t, "x": ego[0][0], "y": ego[0][1], "yaw": np.full(len(t), TURN), "v": speed, "vx": speed, **still}
    (x, y), box = other
    yaw = box[2] + TURN
    v = [np.full(len(t), box[5] * part) for part in (math.cos(yaw), math.sin(yaw))]
    track = ObjectTrack("vehicle", box[3], box[4], 1.5, t, x, y, np.zeros(len(t)), np.full(len(t), yaw), *v)
    meta = {"ego": {"length": ego[1][3], "width": ego[1][4], "height": 1.5, "center_x": 0.0}}
    log = Log(columns, {"other": track}, meta=meta)

    def first(name: str) -> float | None:
        found = compute(name, log)
        if not found.valid or found.series is None or found.series.t[0] > 0.0:
            return None
        return float(found.series.value[0])

    rate = first("max_ttc_inverse")
    return {
        "DCE": compute("min_distance", log).value, "HW": first("min_distance_longitudinal"),
        "THW": first("time_headway"), "TTC": 1.0 / rate if rate else None, "ALongReq": first("required_deceleration"),
    }  # fmt: skip


def compare(cases: Path, theirs: Path) -> None:
    """One line a measure: how many both define, and how far they are apart at most."""
    off: dict[str, list[tuple[float, int]]] = {}
    alone: dict[str, list[int]] = {}
    for k, (case, said) in enumerate(zip(cases.open(), theirs.open(), strict=False)):
        mine = ours(json.loads(case))
        for name, value in json.loads(said).items():
            own = mine[name]
            if (own is None) != (value is None):
                alone.setdefault(name, []).append(k)
            elif own is not None and not (name == "ALongReq" and own == 0.0):  # CriMe brakes for what drives away, too
                off.setdefault(name, []).append((abs(own - (-value if name == "ALongReq" else value)), k))
    for name, found in off.items():
        values = np.array([one[0] for one in found])
        print(
            f"{name}: {len(found)} in both, median {np.median(values):.3g}, 99 % {np.quantile(values, 0.99):.3g}, "
            f"at most {max(found)}; defined in one alone: {len(alone.get(name, []))} {alone.get(name, [])[:5]}"
        )


if __name__ == "__main__":
    if sys.argv[1] == "draw":
        draw(int(sys.argv[2]))
    elif sys.argv[1] == "ask":
        ask()
    else:
        compare(Path(sys.argv[2]), Path(sys.argv[3]))
