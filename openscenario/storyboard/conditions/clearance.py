"""RelativeClearanceCondition: nobody in the lanes around an entity.

Source: ASAM OpenSCENARIO XML 1.3, class RelativeClearanceCondition. Lanes count from the entity's own (0), positive to
its left; distances run along the road, ahead and behind.
"""

from __future__ import annotations

import math

from openscenario import model
from openscenario.road.network import RoadNetwork
from openscenario.road.positions import RoadPosition
from openscenario.storyboard.distances import Measure, measure
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.positions import shifted_lane
from openscenario.storyboard.registry import Scope, condition, entity_called
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.unsupported import Unsupported


@condition(model.RelativeClearanceCondition)
def relative_clearance(element: model.RelativeClearanceCondition, entity: Entity, scope: Scope) -> Test:
    """True while none of the given entities (all, if none is given) is in one of the lanes within the distances.

    A range of lanes of which the road has none in the entity's direction (or any, if opposite lanes count) is not free.
    Raises Unsupported in a scenario without a road network.
    """
    board = scope.board
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network")
    named = [reference.entity_ref for reference in element.entity_refs]
    for name in named:
        entity_called(name, board)
    distances: dict[str, Measure] = {}

    def distance_to(other: Entity) -> Measure:
        found = distances.get(other.name)
        if found is None:
            found = measure(board, entity, other, kind="longitudinal", system="road", free=element.free_space)
            distances[other.name] = found
        return found

    ranges = [
        (each.from_ if each.from_ is not None else -math.inf, each.to if each.to is not None else math.inf)
        for each in element.relative_lane_ranges
    ] or [(-math.inf, math.inf)]
    low, high = -element.distance_backward, element.distance_forward

    def test() -> bool:
        here = board.ground.position(entity)
        if not any(_exists(network, here, entity.sense, first, last, element.opposite_lanes) for first, last in ranges):
            return False
        way = network.driving_sign(here.road, here.lane, here.s)
        for name in named or tuple(board.entities):  # traffic comes and goes
            other = board.entities[name]
            if not other.active or other is entity:
                continue
            there = board.ground.position(other)
            # traffic of another road that runs the other way counts the other way round
            same = board.ground.turned(here, there) > 0.0
            if not element.opposite_lanes:
                along = network.driving_sign(there.road, there.lane, there.s)
                if (along if same else -along) != way:
                    continue
            gap = distance_to(other)()
            if gap is None or not low <= gap <= high:
                continue
            lane, linked = board.ground.lane_onwards(there, here)
            apart = (_number(lane) - _number(here.lane)) * entity.sense
            if any(first <= apart <= last for first, last in ranges):
                if not linked:
                    text = f"no lane links lead from the lane of {name} to {entity.name} on road {here.road}"
                    board.warn(element, "no-lane-link", f"{text}; its lane is taken for the one of its id")
                return False
        return True

    return test


def _exists(network: RoadNetwork, here: RoadPosition, sense: float, first: float, last: float, opposite: bool) -> bool:
    """Whether the road has any of the lanes of a range here, of those that count; one without an end always has."""
    if math.isinf(first) or math.isinf(last):
        return True
    way = network.driving_sign(here.road, here.lane, here.s)
    for by in range(int(first), int(last) + 1):
        lane = shifted_lane(here.lane, by if sense > 0.0 else -by)
        try:
            there = network.lane_type(here.road, lane, here.s) != "none"
        except KeyError:
            continue
        if there and (opposite or network.driving_sign(here.road, lane, here.s) == way):
            return True
    return False


def _number(lane: int) -> int:
    """Lanes numbered from right to left without a gap at the lane 0 that nobody drives on."""
    return lane if lane < 0 else lane - 1
