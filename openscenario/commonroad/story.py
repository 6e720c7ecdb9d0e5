"""Obstacles and planning problem as OpenSCENARIO: trajectories with time stamps, and a goal for the ego.

The place of an obstacle is the middle of its box, and so is that of the ego's start. An obstacle is there from its
first state to its last one. The ego, called `Ego`, has the size of the BMW 320i that CommonRoad calls vehicle 2.
"""

from __future__ import annotations

import math
from typing import Final

from openscenario.commonroad.nodes import element
from openscenario.commonroad.roads import Map
from openscenario.commonroad.source import Obstacle, Problem, Source, State
from openscenario.xml import Node

LENGTH, WIDTH, WHEELBASE = 4.508, 1.610, 2.579  # m; CommonRoad, Vehicle Models, 2020a, table of vehicle 2
PEDESTRIANS: Final = ("pedestrian",)
THINGS: Final = ("constructionZone", "roadBoundary", "building", "pillar", "median_strip", "static unknown")
CATEGORIES: Final = {"truck": "truck", "bus": "bus", "motorcycle": "motorbike", "bicycle": "bicycle", "train": "train"}
SLOW: Final = 1.0  # m/s: a start slower than this says nothing of how fast the ego shall drive


def openscenario(source: Source, file_name: str) -> Node:
    """The file as the root of a scenario whose road is that file again."""
    problem = source.problem
    objects = [element("ScenarioObject", each.line, _body(each), name=each.name) for each in source.obstacles]
    if problem is not None:
        objects.insert(0, element("ScenarioObject", problem.line, _ego(problem.line), name="Ego"))
    privates = [] if problem is None else [_start(problem, Map(source))]
    privates += [_placed(each) for each in source.obstacles if each.states[0].step <= 0]
    stories = [each for each in (_story(obstacle, source.dt) for obstacle in source.obstacles) if each is not None]
    stop = element("StopTrigger", 1)
    last = None if problem is None else problem.last_step
    if last is not None:
        stop = element("StopTrigger", 1, element("ConditionGroup", 1, _at_time(last * source.dt, "end of the task")))
    init = element("Init", 1, element("Actions", 1, *privates))
    return element(
        "OpenSCENARIO", 1,
        element("FileHeader", 1, revMajor="1", revMinor="3", date="1970-01-01T00:00:00", author="", description=""),
        element("CatalogLocations", 1),
        element("RoadNetwork", 1, element("LogicFile", 1, filepath=file_name)),
        element("Entities", 1, *objects),
        element("Storyboard", 1, init, *stories, stop),
    )  # fmt: skip


def _box(line: int, length: float, width: float, centre: float, height: float = 1.5) -> Node:
    middle = element("Center", line, x=centre, y=0.0, z=0.5 * height)
    return element("BoundingBox", line, middle, element("Dimensions", line, length=length, width=width, height=height))


def _vehicle(line: int, category: str, box: Node, wheelbase: float) -> Node:
    limits = element("Performance", line, maxSpeed=50.8, maxAcceleration=11.5, maxDeceleration=11.5)
    axles = [
        element(tag, line, maxSteering=steering, wheelDiameter=0.6, trackWidth=1.4, positionX=x, positionZ=0.3)
        for tag, steering, x in (("FrontAxle", 1.066, wheelbase), ("RearAxle", 0.0, 0.0))
    ]
    return element(
        "Vehicle", line, box, limits, element("Axles", line, *axles), name=category, vehicleCategory=category
    )


def _ego(line: int) -> Node:
    return _vehicle(line, "car", _box(line, LENGTH, WIDTH, 0.5 * WHEELBASE), WHEELBASE)


def _body(obstacle: Obstacle) -> Node:
    """An obstacle as a vehicle, pedestrian or thing, with its reference point in the middle."""
    line, kind = obstacle.line, obstacle.kind
    length, width = max(obstacle.length, 0.01), max(obstacle.width, 0.01)
    if kind in PEDESTRIANS:
        box = _box(line, length, width, 0.0, 1.8)
        return element("Pedestrian", line, box, name=kind, pedestrianCategory="pedestrian", mass=75.0)
    if kind in THINGS or kind.removeprefix("static ") in THINGS:
        box = _box(line, length, width, 0.0)
        return element("MiscObject", line, box, name=kind, miscObjectCategory="obstacle", mass=100.0)
    category = CATEGORIES.get(kind.removeprefix("static "), "car")
    return _vehicle(line, category, _box(line, length, width, 0.0), 0.6 * length)


def _world(state: State, line: int, back: float = 0.0) -> Node:
    x, y = state.x - back * math.cos(state.h), state.y - back * math.sin(state.h)
    return element("Position", line, element("WorldPosition", line, x=x, y=y, z=0.0, h=state.h, p=0.0, r=0.0))


def _teleport(position: Node) -> Node:
    return element("PrivateAction", position.line, element("TeleportAction", position.line, position))


def _speed(value: float, line: int) -> Node:
    dynamics = element("SpeedActionDynamics", line, dynamicsShape="step", dynamicsDimension="time", value=0.0)
    target = element("SpeedActionTarget", line, element("AbsoluteTargetSpeed", line, value=value))
    action = element("LongitudinalAction", line, element("SpeedAction", line, dynamics, target))
    return element("PrivateAction", line, action)


def _start(problem: Problem, net: Map) -> Node:
    """Where the ego is, how fast, and where it is asked to go."""
    line = problem.line
    actions = [_teleport(_world(problem.start, line, 0.5 * WHEELBASE))]
    if problem.start.v >= SLOW:
        actions.append(_speed(problem.start.v, line))
    goal: Node | None = None
    if problem.lanelet in net.places:
        road, lane = net.places[problem.lanelet]
        s = 0.5 * net.length(road)
        goal = element("LanePosition", line, roadId=road, laneId=str(lane), s=s)
    elif problem.point is not None:
        x, y = problem.point
        goal = element("WorldPosition", line, x=x, y=y)
    if goal is not None:
        action = element("AcquirePositionAction", line, element("Position", line, goal))
        actions.append(element("PrivateAction", line, element("RoutingAction", line, action)))
    return element("Private", line, *actions, entityRef="Ego")


def _placed(obstacle: Obstacle) -> Node:
    first, line = obstacle.states[0], obstacle.line
    return element(
        "Private", line, _teleport(_world(first, line)), _speed(first.v if len(obstacle.states) > 1 else 0.0, line),
        entityRef=obstacle.name,
    )  # fmt: skip


def _at_time(seconds: float, name: str) -> Node:
    test = element("SimulationTimeCondition", 1, value=seconds, rule="greaterOrEqual")
    return element("Condition", 1, element("ByValueCondition", 1, test), name=name, delay=0.0, conditionEdge="none")


def _event(name: str, seconds: float, action: Node, line: int) -> Node:
    trigger = element("StartTrigger", line, element("ConditionGroup", line, _at_time(seconds, name)))
    what = element("Action", line, action, name=name)
    return element("Event", line, what, trigger, name=name, priority="parallel", maximumExecutionCount="1")


def _entity(obstacle: Obstacle, action: Node) -> Node:
    return element("GlobalAction", action.line, element("EntityAction", action.line, action, entityRef=obstacle.name))


def _story(obstacle: Obstacle, dt: float) -> Node | None:
    """What an obstacle does: it comes, follows its trajectory, and goes; None for one that is there all the time."""
    states, line = obstacle.states, obstacle.line
    begin, end = states[0].step * dt, states[-1].step * dt
    events = []
    if begin > 0.0:
        add = element("AddEntityAction", line, _world(states[0], line))
        events.append(_event(f"{obstacle.name} comes", begin, _entity(obstacle, add), line))
    if len(states) > 1:
        vertices = [element("Vertex", line, _world(each, line), time=each.step * dt) for each in states]
        shape = element("Shape", line, element("Polyline", line, *vertices))
        trajectory = element("Trajectory", line, shape, name=obstacle.name, closed="false")
        timing = element("Timing", line, domainAbsoluteRelative="absolute", scale=1.0, offset=0.0)
        follow = element(
            "FollowTrajectoryAction", line, element("TrajectoryRef", line, trajectory),
            element("TimeReference", line, timing), element("TrajectoryFollowingMode", line, followingMode="position"),
        )  # fmt: skip
        action = element("PrivateAction", line, element("RoutingAction", line, follow))
        events.append(_event(f"{obstacle.name} moves", begin, action, line))
        gone = _entity(obstacle, element("DeleteEntityAction", line))
        events.append(_event(f"{obstacle.name} goes", end, gone, line))
    if not events:
        return None
    actors = element(
        "Actors", line, element("EntityRef", line, entityRef=obstacle.name), selectTriggeringEntities="false"
    )
    group = element(
        "ManeuverGroup", line, actors, element("Maneuver", line, *events, name=obstacle.name),
        name=obstacle.name, maximumExecutionCount="1",
    )  # fmt: skip
    start = element("StartTrigger", line, element("ConditionGroup", line, _at_time(0.0, f"{obstacle.name} begins")))
    return element("Story", line, element("Act", line, group, start, name=obstacle.name), name=obstacle.name)
