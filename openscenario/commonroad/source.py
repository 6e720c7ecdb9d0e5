"""What a CommonRoad file holds: lanelets, obstacles with their motion, and the first planning problem."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from openscenario.findings import Finding, ScenarioError
from openscenario.xml import Node

VERSIONS: Final = ("2018b", "2020a")
ROOT: Final = "commonRoad"
SPEED_SIGNS: Final = ("274", "R2-1", "R301")  # of Germany, the USA and Spain: a largest speed [m/s]
Point = tuple[float, float]
Neighbour = tuple[int, bool]  # id of the lanelet, whether it is driven the same way


@dataclass
class Lanelet:
    """A piece of a lane between two bounds [m], in driving direction."""

    id: int
    left: list[Point]
    right: list[Point]
    line: int
    before: list[int] = field(default_factory=list)
    after: list[int] = field(default_factory=list)
    at_left: Neighbour | None = None
    at_right: Neighbour | None = None
    kinds: frozenset[str] = frozenset()
    speed: float | None = None


@dataclass(frozen=True)
class State:
    """Place of the middle [m], orientation [rad] and speed [m/s] at a time step."""

    step: float
    x: float
    y: float
    h: float
    v: float


@dataclass(frozen=True)
class Obstacle:
    """Somebody or something beside the ego: its box [m], where it is at first and later."""

    name: str
    kind: str
    length: float
    width: float
    states: tuple[State, ...]
    line: int


@dataclass(frozen=True)
class Problem:
    """What the ego is asked to do: where it starts, the goal as lanelet or point [m], the last time step."""

    start: State
    lanelet: int | None
    point: Point | None
    last_step: float | None
    line: int


@dataclass(frozen=True)
class Source:
    """A file. dt: seconds of a time step. left_out: what was read over, by element, and how often."""

    name: str
    dt: float
    lanelets: dict[int, Lanelet]
    obstacles: tuple[Obstacle, ...]
    problem: Problem | None
    left_out: dict[str, int]


def read(root: Node, file: str) -> Source:
    """The content of a file with the root `commonRoad`.

    Raises:
        ScenarioError: another version, or something without which neither road nor motion can be had.
    """
    reader = _Reader(file)
    version = root.get("commonRoadVersion")
    if version not in VERSIONS:
        allowed = " or ".join(VERSIONS)
        raise reader.error(root, "version.unsupported", "unsupported version of CommonRoad", version, allowed)
    dt = reader.positive(root, "timeStepSize")
    signs = {node.get("id"): node for node in root.findall("trafficSign")}
    lanelets = {each.id: each for each in (reader.lanelet(node, signs) for node in root.findall("lanelet"))}
    if not lanelets:
        raise reader.error(root, "commonroad.no_lanelet", "the file has no lanelet", "", "at least one lanelet")
    tags = ("dynamicObstacle", "staticObstacle", "obstacle", "environmentObstacle")
    nodes = [node for node in root.children if node.tag in tags]
    obstacles = tuple(reader.obstacle(node) for node in nodes if node.tag != "environmentObstacle")
    problems = root.findall("planningProblem")
    left_out: dict[str, int] = {}
    for tag in ("trafficLight", "environmentObstacle", "phantomObstacle"):
        if count := len(root.findall(tag)):
            left_out[tag] = count
    if len(problems) > 1:
        left_out["planningProblem"] = len(problems) - 1
    sets = sum(node.find("occupancySet") is not None for node in nodes)
    if sets:
        left_out["occupancySet"] = sets
    problem = reader.problem(problems[0]) if problems else None
    return Source(root.get("benchmarkID") or "CommonRoad", dt, lanelets, obstacles, problem, left_out)


class _Reader:
    """Reads elements, and says where something is wrong."""

    def __init__(self, file: str) -> None:
        self._file = file

    def error(self, node: Node, code: str, text: str, found: str = "", allowed: str = "") -> ScenarioError:
        """An error at an element."""
        text = text if ROOT.casefold() in text.casefold() else f"CommonRoad: {text}"
        return ScenarioError([Finding(code, "error", self._file, node.line, node.path, found, allowed, "", text)])

    def number(self, node: Node, text: str, name: str = "") -> float:
        """A finite number, the text of an element or of its attribute `name`."""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            said = f"{name or node.tag} is no finite number"
            raise self.error(node, "value.not_a_number", said, text.strip() or "nothing", "a number")
        return value

    def positive(self, node: Node, name: str) -> float:
        """An attribute above 0."""
        value = self.number(node, node.get(name), name)
        if value <= 0.0:
            raise self.error(node, "value.out_of_range", f"{name} must be above 0", node.get(name), "more than 0")
        return value

    def whole(self, node: Node, name: str) -> int:
        """An id."""
        text = node.get(name).strip()
        if not text.lstrip("-").isdigit():
            raise self.error(node, "value.not_a_number", f"{name} is no id", text or "nothing", "a whole number")
        return int(text[:18])

    def child(self, node: Node, tag: str) -> Node:
        """A child that must be there."""
        found = node.find(tag)
        if found is None:
            raise self.error(node, "commonroad.missing", f"{tag} is missing", node.tag, tag)
        return found

    def value(self, node: Node | None, default: float | None = None) -> float:
        """The exact value of an element, or the middle of an interval."""
        if node is None:
            assert default is not None
            return default
        exact = node.find("exact")
        if exact is not None:
            return self.number(exact, exact.text)
        ends = [self.child(node, name) for name in ("intervalStart", "intervalEnd")]
        return 0.5 * sum(self.number(end, end.text) for end in ends)

    def point(self, node: Node) -> Point:
        """A point."""
        x, y = (self.child(node, name) for name in ("x", "y"))
        return self.number(x, x.text), self.number(y, y.text)

    def bound(self, node: Node, tag: str) -> list[Point]:
        """The points of a bound, without repetitions."""
        points: list[Point] = []
        for each in self.child(node, tag).findall("point"):
            point = self.point(each)
            if not points or math.dist(point, points[-1]) > 1e-3:
                points.append(point)
        if len(points) < 2:
            raise self.error(node, "commonroad.bound", f"{tag} needs two points", str(len(points)), "two or more")
        return points

    def lanelet(self, node: Node, signs: dict[str, Node]) -> Lanelet:
        """A lanelet."""
        found = Lanelet(
            self.whole(node, "id"), self.bound(node, "leftBound"), self.bound(node, "rightBound"), node.line
        )
        found.before = [self.whole(each, "ref") for each in node.findall("predecessor")]
        found.after = [self.whole(each, "ref") for each in node.findall("successor")]
        found.at_left, found.at_right = (self._beside(node, tag) for tag in ("adjacentLeft", "adjacentRight"))
        found.kinds = frozenset(each.text.strip() for each in node.findall("laneletType"))
        for reference in node.findall("trafficSignRef"):
            for each in self._limits(signs.get(reference.get("ref"))):
                found.speed = each if found.speed is None else min(found.speed, each)
        limit = node.find("speedLimit")
        if limit is not None:  # 2018b
            found.speed = self.number(limit, limit.text)
        return found

    def _beside(self, node: Node, tag: str) -> Neighbour | None:
        found = node.find(tag)
        return None if found is None else (self.whole(found, "ref"), found.get("drivingDir", "same") == "same")

    def _limits(self, sign: Node | None) -> Iterator[float]:
        for element in () if sign is None else sign.findall("trafficSignElement"):
            kind, value = element.find("trafficSignID"), element.find("additionalValue")
            if kind is not None and value is not None and kind.text.strip() in SPEED_SIGNS:
                yield self.number(value, value.text)

    def obstacle(self, node: Node) -> Obstacle:
        """An obstacle, static or with a trajectory; one with sets of occupied places only stays as it begins."""
        kind = node.find("type")
        length, width, h, middle = self.shape(self.child(node, "shape"))
        states = [self.state(self.child(node, "initialState"))]
        trajectory = node.find("trajectory")
        if trajectory is not None:
            states += [self.state(each) for each in trajectory.findall("state")]
        states = [state for n, state in enumerate(states) if n == 0 or state.step > states[n - 1].step]
        moved = [
            State(
                each.step,
                each.x + middle[0] * math.cos(each.h) - middle[1] * math.sin(each.h),
                each.y + middle[0] * math.sin(each.h) + middle[1] * math.cos(each.h),
                each.h + h,
                each.v,
            )
            for each in states
        ]
        static = node.tag == "staticObstacle" or (
            (role := node.find("role")) is not None and role.text.strip() == "static"
        )
        what = "unknown" if kind is None else kind.text.strip()
        name = f"{'static' if static else 'obstacle'}{self.whole(node, 'id')}"
        return Obstacle(name, f"static {what}" if static else what, length, width, tuple(moved), node.line)

    def shape(self, node: Node) -> tuple[float, float, float, Point]:
        """Length and width [m] of the box about a shape, its turn [rad] and middle [m] against the obstacle's own."""
        shape = next(iter(node.children), node)
        if shape.tag == "rectangle":
            length, width = (
                self.number(each, each.text) for each in (self.child(shape, n) for n in ("length", "width"))
            )
            turn, centre = shape.find("orientation"), shape.find("center")
            h = 0.0 if turn is None else self.number(turn, turn.text)
            return length, width, h, (0.0, 0.0) if centre is None else self.point(centre)
        if shape.tag == "circle":
            radius = self.child(shape, "radius")
            centre = shape.find("center")
            across = 2.0 * self.number(radius, radius.text)
            return across, across, 0.0, (0.0, 0.0) if centre is None else self.point(centre)
        points = [self.point(each) for each in shape.findall("point")]
        if shape.tag != "polygon" or len(points) < 3:
            allowed = "rectangle, circle or polygon"
            raise self.error(node, "commonroad.shape", "unknown shape", shape.tag, allowed)
        low, high = [min(each) for each in zip(*points, strict=True)], [max(each) for each in zip(*points, strict=True)]
        return high[0] - low[0], high[1] - low[1], 0.0, (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]))

    def state(self, node: Node) -> State:
        """A state; a place that is a shape counts by its middle."""
        position = self.child(node, "position")
        point = position.find("point")
        x, y = self.point(point) if point is not None else self.shape(position)[3]
        h, v = self.value(node.find("orientation"), 0.0), self.value(node.find("velocity"), 0.0)
        return State(self.value(node.find("time"), 0.0), x, y, h, v)

    def problem(self, node: Node) -> Problem:
        """A planning problem; of several goals the first."""
        goal = self.child(node, "goalState")
        position, time = goal.find("position"), goal.find("time")
        lanelet: int | None = None
        point: Point | None = None
        if position is not None:
            reference, exact = position.find("lanelet"), position.find("point")
            if reference is not None:
                lanelet = self.whole(reference, "ref")
            else:
                point = self.point(exact) if exact is not None else self.shape(position)[3]
        last: float | None = None
        if time is not None:
            end = time.find("intervalEnd")
            last = self.value(time) if end is None else self.number(end, end.text)
        return Problem(self.state(self.child(node, "initialState")), lanelet, point, last, node.line)
