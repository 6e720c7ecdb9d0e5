"""The reference stack on the roads of a folder, without a goal:  python -m scripts.town_drives FOLDER [--seconds 320]

From the start of the longest driving lane of each road file that is called Town*.xodr. Prints a table of the time to
read, the way, and how long a wheel was on no lane that a car may drive on: the one of docs/roads.md.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import pytest_dvp
from openscenario.road.network import RoadNetwork, load_network

SCENARIO = """<?xml version="1.0"?>
<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="{name}" author="tests"/>
<ParameterDeclarations/><CatalogLocations/><RoadNetwork><LogicFile filepath="{road}"/></RoadNetwork>
<Entities><ScenarioObject name="Ego"><Vehicle name="car" vehicleCategory="car"><ParameterDeclarations/>
<BoundingBox><Center x="0.9" y="0" z="0.75"/><Dimensions width="1.5" length="2.9" height="1.5"/></BoundingBox>
<Performance maxSpeed="30" maxAcceleration="4" maxDeceleration="8"/>
<Axles><FrontAxle maxSteering="0.6" wheelDiameter="0.55" trackWidth="1.3" positionX="1.8" positionZ="0.3"/>
<RearAxle maxSteering="0" wheelDiameter="0.55" trackWidth="1.3" positionX="0" positionZ="0.3"/></Axles><Properties/>
</Vehicle></ScenarioObject></Entities>
<Storyboard><Init><Actions><Private entityRef="Ego">
<PrivateAction><TeleportAction><Position><LanePosition roadId="{id}" laneId="{lane}" s="{s}"/></Position></TeleportAction></PrivateAction>
<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape="step" dynamicsDimension="time" value="0"/>
<SpeedActionTarget><AbsoluteTargetSpeed value="8"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>
</Private></Actions></Init><StopTrigger/></Storyboard></OpenSCENARIO>
"""  # noqa: E501
"""The car is the one that a run has by default, the TABBY EVO."""
NEAR = 6.0  # m from the end of the road, where the car starts
WIDE = 2.0  # m, least width of the lane there


def start_of(net: RoadNetwork) -> tuple[str, int, float]:
    """Road, lane and s [m] near the start of the longest driving lane. Raises ValueError if there is none."""
    found: list[tuple[float, str, int, float]] = []
    for road in net.file.roads:
        for lane in road.sections[0].lanes:
            near = min(NEAR, 0.2 * road.length)
            s = near if net.driving_sign(road.id, lane.id) > 0 else road.length - near
            if net.lane_type(road.id, lane.id, s) == "driving" and net.lane_width(road.id, lane.id, s) > WIDE:
                found.append((road.length, road.id, lane.id, s))
    return max(found)[1:]


def main() -> int:
    """Returns 0; the table is the result."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=320.0)
    options = parser.parse_args()
    print("| town | read [s] | way [m] | outside of the lanes [s] | error of the path, root mean square [m] |")
    print("|---|---|---|---|---|", flush=True)
    for road in sorted(options.folder.rglob("Town*.xodr")):
        load_network(road)  # so that what is timed is not the compiling
        begin = time.process_time()
        net = load_network(road)
        took = time.process_time() - begin
        name, lane, s = start_of(net)
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / road.name).write_bytes(road.read_bytes())
            file = Path(folder) / f"{road.stem}.xosc"
            file.write_text(SCENARIO.format(name=road.stem, road=road.name, id=name, lane=lane, s=s))
            result = pytest_dvp.run(file, duration=options.seconds)
            x, y = result.log["x"], result.log["y"]
            way = float(np.nansum(np.hypot(np.diff(x), np.diff(y))))
            outside, error = result.metrics["road_departure"], result.metrics["lateral_rmse_path"]
        told = "-" if error is None else f"{error:.2f}"
        print(f"| {road.stem} | {took:.1f} | {way:.0f} | {outside:g} | {told} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
