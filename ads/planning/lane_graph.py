"""Lane graph planner: the quickest way along lanes, around lanes that are blocked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ads.planning.route import Leg, Map
from openscenario.road.route import RouteError, find_place, stretches
from vehicle.messages import RoadPoint

BoolArray: TypeAlias = NDArray[np.bool_]

CHANGE_TIME = 5.0  # s that a lane change is worth
FASTEST = 40.0  # m/s on a lane without a limit
NOTHING = 1e-9  # s on a lane without length: in a sparse matrix an edge that costs 0 is none
ROOM_TO_CHANGE = 12.0  # m before a blocked place that the car must be in the other lane

Router: TypeAlias = Callable[[RoadPoint, RoadPoint, Sequence[RoadPoint]], Sequence[Any]]


class LaneGraphPlanner:
    """Routes by travel time at the speed limits, plus CHANGE_TIME a lane change; made once a map."""

    def __init__(self, network: Any, set_speed: float = FASTEST) -> None:
        self._network = network
        self._ids = tuple(network.roads)
        self._numbers = {road: number for number, road in enumerate(self._ids)}
        graph = network.lane_graph()
        spans, n = network.tables[4], len(graph.nodes)
        seconds = np.empty(n)
        for i, (road, section, lane) in enumerate(graph.nodes.tolist()):
            low, high = float(spans[section, 0]), float(spans[section, 1])
            limit = min(float(network.lane_speed(self._ids[road], lane, 0.5 * (low + high))), set_speed, FASTEST)
            seconds[i] = max(high - low, 0.0) / max(limit, 0.1)
        self._graph = graph
        self._cost = np.where(graph.changes, CHANGE_TIME, seconds[graph.edges[:, 0]])

    def route(self, start: RoadPoint, goal: RoadPoint, blocked: Sequence[RoadPoint] = ()) -> tuple[Leg, ...]:
        """Legs from start to goal over no blocked place.

        Raises: RouteError where a place is on no drivable lane or no way is left.
        """
        (here, node), (there, end) = self._place(start), self._place(goal)
        graph, n = self._graph, len(self._graph.nodes)
        sign = 1.0 if self._network.driving_sign(start.road, start.lane, start.s) > 0 else -1.0
        ahead = there.section == here.section and sign * (there.s - here.s) >= 0.0
        closed, closed_ahead = np.zeros(n, bool), np.zeros(n, bool)  # ahead: in the start's section, before the car
        limit = None  # where the car must have left its lane [m]
        for point in blocked:
            place, number = self._place(point)
            beyond = ahead and number == end and sign * (place.s - there.s) > 0.0
            closed[number] |= number != end or ahead
            if place.section == here.section and sign * (place.s - here.s) > 0.0 and not beyond:
                closed_ahead[number] = True
                if number == node:
                    limit = place.s - sign * ROOM_TO_CHANGE
        path = self._quickest(here.section, node, end, ahead, closed, closed_ahead)
        if path is None:
            raise RouteError(f"no way leads from road {start.road} to road {goal.road}" + " around it" * bool(blocked))
        pieces = stretches(self._network.tables, graph, path, here.s, there.s)
        legs = tuple(Leg(self._ids[road], lane, a, b) for road, lane, a, b in pieces)
        return legs if limit is None else _changed_before(legs, limit, sign)

    def _quickest(
        self, section: int, node: int, end: int, ahead: bool, closed: BoolArray, closed_ahead: BoolArray
    ) -> list[int] | None:
        """Nodes from `node` to `end`, None without a way.

        The nodes of the start's section are there twice: as the places ahead of the start, and as where a loop comes
        back. `ahead`: the goal is one of the former.
        """
        graph, edges, changes = self._graph, self._graph.edges, self._graph.changes
        n = len(graph.nodes)
        twins = np.flatnonzero(graph.nodes[:, 1] == section)
        twin = np.full(n, -1, np.int64)
        twin[twins] = n + np.arange(len(twins))
        if ahead and node == end and closed_ahead[node]:
            return None  # there and back again within a section: that is overtaking
        far_open = ~closed[edges[:, 0]] & ~closed[edges[:, 1]]
        near = twin[edges[:, 0]] >= 0
        beside = changes[near]
        begin, to = edges[near, 0], edges[near, 1]
        near_open = np.where(beside, ~closed_ahead[to], ~closed_ahead[begin] & ~closed[to])
        copied = np.column_stack((twin[begin], np.where(beside, twin[to], to)))
        pairs = np.concatenate([edges[far_open], copied[near_open]])
        costs = np.concatenate([self._cost[far_open], self._cost[near][near_open]])
        order = np.argsort(pairs[:, 0], kind="stable")
        total = n + len(twins)
        first = np.searchsorted(pairs[order, 0], np.arange(total + 1))
        source, target = int(twin[node]), int(twin[end]) if ahead else end
        some = costs[order] + NOTHING
        matrix = csr_matrix((some, pairs[order, 1], first), shape=(total, total))
        costs_to, nodes_before = dijkstra(matrix, indices=[source], return_predecessors=True)
        far, before = costs_to[0], nodes_before[0]
        if not np.isfinite(far[target]):
            return None
        path = [target]
        while path[-1] != source:
            path.append(int(before[path[-1]]))
        return [int(twins[i - n]) if i >= n else i for i in reversed(path)]

    def _place(self, point: RoadPoint) -> Any:
        if point.road not in self._numbers:
            raise RouteError(f"there is no road {point.road}")
        number = self._numbers[point.road]
        return find_place(self._network.tables, self._graph, number, point.lane, float(point.s), point.road)


def _changed_before(legs: tuple[Leg, ...], limit: float, sign: float) -> tuple[Leg, ...]:
    """The legs with their first lane change done before `limit` [m]."""
    if len(legs) < 2 or legs[0].road != legs[1].road or sign * (legs[0].s_to - limit) <= 0.0:
        return legs
    at = max(limit * sign, legs[0].s_from * sign) * sign
    return (legs[0]._replace(s_to=at), legs[1]._replace(s_from=at), *legs[2:])


def router_of(network: Map) -> Router:
    """How routes are found on a map: by the lane graph if it has one, else by the map itself.

    What it returns raises RouteError if there is no route; without a lane graph also if a lane is blocked.
    """
    if hasattr(network, "lane_graph"):
        return LaneGraphPlanner(network).route

    def by_the_map(start: RoadPoint, goal: RoadPoint, blocked: Sequence[RoadPoint]) -> Sequence[Any]:
        if blocked:
            raise RouteError("this map knows no way around")
        found: Sequence[Any] = network.route(tuple(start), tuple(goal))
        return found

    return by_the_map
