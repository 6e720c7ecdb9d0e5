"""Positions whose attributes exclude each other."""

from __future__ import annotations

from openscenario.model.actions import AbsoluteTargetLane, TeleportAction
from openscenario.model.conditions import TrafficSignalCondition, TrafficSignalControllerCondition
from openscenario.model.global_actions import (
    AddEntityAction,
    TrafficSignalControllerAction,
    TrafficSignalStateAction,
)
from openscenario.model.positions import GeoPosition, LanePosition, RelativeLanePosition, RoadPosition
from openscenario.read.checks.registry import at_most_one, check, exactly_one
from openscenario.read.context import Context, OfPhase, OnRoad


@check(LanePosition, RoadPosition, TrafficSignalStateAction, TrafficSignalCondition, AbsoluteTargetLane)
def on_road(element: OnRoad, context: Context) -> None:
    """Compared with the road once its file is known."""
    context.on_road.append(element)


@check(TrafficSignalControllerAction, TrafficSignalControllerCondition)
def of_phase(element: OfPhase, context: Context) -> None:
    """Compared with the phases of the controller once the road network is known."""
    context.of_phases.append(element)


@check(TeleportAction, AddEntityAction)
def start(action: TeleportAction | AddEntityAction, context: Context) -> None:
    """A position that an entity is put on, not only measured from or driven to."""
    context.starts.add(action.position.at)


@check(RelativeLanePosition)
def one_distance(position: RelativeLanePosition, context: Context) -> None:
    """Both are optional in the schema since 1.1: without them the position is beside the other entity."""
    at_most_one(position, context, "", ds=position.ds, dsLane=position.ds_lane)


@check(GeoPosition)
def one_notation(position: GeoPosition, context: Context) -> None:
    """Degrees since 1.2, radians before; not a bit of both."""
    exactly_one(position, context, "", latitudeDeg=position.latitude_deg, latitude=position.latitude)
    exactly_one(position, context, "", longitudeDeg=position.longitude_deg, longitude=position.longitude)
