"""Reads a CommonRoad file with commonroad-io and prints what it found as JSON; runs in an environment of its own."""

import json
import sys

from commonroad.common.file_reader import CommonRoadFileReader

scenario, problems = CommonRoadFileReader(sys.argv[1]).open()
first = next(iter(problems.planning_problem_dict.values())).initial_state
lanelets = {
    each.lanelet_id: {
        "length": float(each.distance[-1]),
        "centre": each.center_vertices.tolist(),
        "successors": each.successor,
    }
    for each in scenario.lanelet_network.lanelets
}
obstacles = {}
for each in scenario.obstacles:
    states = [each.state_at_time(step) for step in range(400)]
    obstacles[each.obstacle_id] = [
        [state.time_step, *map(float, state.position), float(state.orientation)]
        for state in states
        if state is not None
    ]
print(
    json.dumps(
        {
            "dt": scenario.dt,
            "lanelets": lanelets,
            "obstacles": obstacles,
            "ego": [*map(float, first.position), float(first.orientation), float(first.velocity)],
        }
    )
)
