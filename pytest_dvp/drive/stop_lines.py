"""Stop lines of the map's traffic lights, as the log tells them to whoever judges a drive."""

from __future__ import annotations

import math
from typing import Any

from openscenario.road.network import RoadNetwork


def stop_lines(network: RoadNetwork) -> list[dict[str, Any]]:
    """Of each dynamic signal of the map: its id, and the line across the lanes that it is for.

    x, y [m] of the line's middle, heading [rad] of the traffic over it, width [m]. The line is where the signal stands
    (s of the OpenDRIVE file), over the drivable lanes of its orientation; a signal without such lanes has none.
    """
    found = []
    for signal in network.signals:
        if not signal.dynamic:
            continue
        for sign in (1, -1):
            if (signal.orientation, sign) in (("+", -1), ("-", 1)):
                continue
            edges = []
            for lane in network.section(signal.road, signal.s).lanes:
                width = network.lane_width(signal.road, lane.id, signal.s)
                if (
                    lane.id
                    and lane.type == "driving"
                    and width
                    and network.driving_sign(signal.road, lane.id, signal.s) == sign
                ):
                    middle = network.lane_t(signal.road, lane.id, signal.s)
                    edges += [middle - 0.5 * width, middle + 0.5 * width]
            if edges:
                pose = network.road_pose(signal.road, signal.s, 0.5 * (min(edges) + max(edges)))
                heading = pose.h if sign > 0 else pose.h + math.pi
                found.append(
                    {
                        "signal": signal.id,
                        "x": pose.x,
                        "y": pose.y,
                        "heading": heading,
                        "width": max(edges) - min(edges),
                    }
                )
    return found
