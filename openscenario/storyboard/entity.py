"""One object of the scenario while it runs: its size, its pose, and who moves it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario.model.declarations import NO_PROPERTIES, Properties
from openscenario.road.route import RouteLane
from openscenario.storyboard.places import Place, wrap

if TYPE_CHECKING:
    from openscenario import model
    from openscenario.storyboard.controls import Controls
    from openscenario.storyboard.driver import Driver
    from openscenario.storyboard.runner import Runner


GRAVITY = 9.80665  # m/s^2, CGPM 1901
MAX_STEER = 0.6  # rad, of a vehicle without a front axle in the file; chosen
USUAL_MASS = 1500.0  # kg, where the file states none
STILL = 1e-3  # m/s: slower is standing; chosen
STILL_MEASURED = 0.1  # m/s, of one that is moved from outside: its speed may be measured, and no standing car's is 0;
# an INS has 0.014 m/s (1 sigma) and wheel speeds steps of 0.017. The same on all stages, so that they fire alike


class Visible:
    """For whom an entity is there to see: `sensors` in general, those `named` (in lower case) by themselves, traffic
    that drives by itself."""

    __slots__ = ("named", "sensors", "traffic")

    def __init__(self) -> None:
        self.sensors = self.traffic = True
        self.named: dict[str, bool] = {}

    def to(self, sensor: str) -> bool:
        """Whether a sensor of that name sees the entity where it looks at it."""
        return self.named.get(sensor, self.sensors)


class Entity:
    """Name, kind, size [m] and mutable state (SI, world frame, reference point).

    `external`: moved from outside by `Storyboard.place`; actions never move it once Init is over. The road state
    (road, lane, s, offset, sense) holds while `tracked`: the lane the entity keeps, which during a lane change is
    already the target lane. `sense` is +1 where the entity faces increasing s. `drift` is the heading it takes from
    moving sideways, `twist` the heading that its last placing left it with, both against its lane.
    """

    __slots__ = (
        "able",
        "active",
        "along",
        "ax",
        "blocked",
        "category",
        "center_x",
        "center_y",
        "center_z",
        "controls",
        "coupler",
        "drawn_by",
        "drift",
        "driver",
        "end_of_road",
        "end_since",
        "external",
        "h",
        "height",
        "hitch",
        "kind",
        "lane",
        "late",
        "lateral",
        "lateral_order",
        "leads",
        "length",
        "lights",
        "longitudinal",
        "longitudinal_order",
        "mass",
        "max_acceleration",
        "max_acceleration_rate",
        "max_deceleration",
        "max_deceleration_rate",
        "max_speed",
        "max_steer",
        "moved",
        "name",
        "off_since",
        "offset",
        "pitch",
        "placed",
        "properties",
        "road",
        "roll",
        "route",
        "route_lanes",
        "s",
        "sense",
        "set_speed",
        "shifted",
        "speed",
        "speed_before",
        "still_since",
        "teleports",
        "tracked",
        "trailer",
        "travelled",
        "twist",
        "visible",
        "vx",
        "vy",
        "wheelbase",
        "width",
        "x",
        "y",
        "z",
    )

    def __init__(self, scenario_object: model.ScenarioObject, *, external: bool) -> None:
        self.name = scenario_object.name
        self.kind: str = scenario_object.kind
        self.category = scenario_object.category
        self.properties: Properties = getattr(scenario_object.entity, "properties", NO_PROPERTIES)
        # a property of esmini's: the reference point lies so far ahead [m] of a point that is drawn along
        self.leads = _number(self.properties.get("refpoint_x_offset"))
        box = scenario_object.bounding_box
        self.length = box.dimensions.length if box else 0.0
        self.width = box.dimensions.width if box else 0.0
        self.height = box.dimensions.height if box else 0.0
        self.center_x = box.center.x if box else 0.0
        self.center_y = box.center.y if box else 0.0
        self.center_z = box.center.z if box else 0.0
        performance = getattr(scenario_object.entity, "performance", None)
        self.max_speed: float = performance.max_speed if performance else math.inf
        self.max_acceleration: float = performance.max_acceleration if performance else math.inf
        self.max_deceleration: float = performance.max_deceleration if performance else math.inf
        self.able = self.max_acceleration, self.max_deceleration  # on a road that holds
        rates = (performance.max_acceleration_rate, performance.max_deceleration_rate) if performance else (None, None)
        self.max_acceleration_rate, self.max_deceleration_rate = (math.inf if rate is None else rate for rate in rates)
        front = axles.front_axle if (axles := getattr(scenario_object.entity, "axles", None)) else None
        self.wheelbase: float = front.position_x if front else 0.0
        self.max_steer: float = front.max_steering if front else MAX_STEER
        self.mass: float = getattr(scenario_object.entity, "mass", None) or USUAL_MASS
        hitch = getattr(scenario_object.entity, "trailer_hitch", None)
        coupler = getattr(scenario_object.entity, "trailer_coupler", None)
        self.hitch: float = hitch.dx if hitch else 0.0  # where a trailer hangs [m]
        self.coupler: float = coupler.dx if coupler else 0.0  # where a trailer is hung up [m]
        self.trailer: Entity | None = None
        self.drawn_by: Entity | None = None
        self.external = external
        self.active = True
        self.x = self.y = self.z = self.h = self.pitch = self.roll = 0.0
        self.speed = self.vx = self.vy = self.ax = 0.0
        self.speed_before = 0.0
        self.tracked = False
        self.road = ""
        self.lane = 0
        self.s = self.offset = 0.0
        self.sense = 1.0
        self.twist = self.drift = 0.0
        self.along = 1.0  # part of this step's way that is along the lane; the rest is sideways
        self.shifted = False  # an action changed its offset in this step
        self.end_of_road = self.blocked = False
        self.travelled = 0.0
        self.still_since = math.inf  # time [s] since when it has been standing
        self.end_since = math.inf  # ... or at the end of its road
        self.off_since = math.inf  # ... or off the road, if a condition asks for it
        self.moved = False  # its pose was set in this step by an action
        self.placed = False  # ... or by a teleport at the beginning of this step
        self.teleports = 0  # how many there were
        self.set_speed: float | None = None  # what the last speed action wants
        self.route: tuple[Place, ...] = ()
        self.route_lanes: tuple[RouteLane, ...] = ()  # the way along the route, in driving order
        self.longitudinal: Runner | None = None
        self.lateral: Runner | None = None
        # places in the file of the actions that hold them, or held them last
        self.longitudinal_order = self.lateral_order = 0
        self.late = False  # what moves it in this step comes before what changes its speed
        self.visible = Visible()
        self.controls: Controls | None = None  # what of it the scenario holds
        self.driver: Driver | None = None  # who drives it instead of the default controller
        self.lights: dict[str, Runner] = {}  # kind of light -> the action that has it

    def holder(self, domain: str) -> Runner | None:
        """The action that has hold of a domain: longitudinal, lateral, or a kind of light."""
        if domain == "longitudinal":
            return self.longitudinal
        return self.lateral if domain == "lateral" else self.lights.get(domain)

    def hold(self, domain: str, runner: Runner | None, order: int = 0) -> None:
        """Give a domain to an action, or to none; `order`: its place in the file."""
        if domain == "longitudinal":
            self.longitudinal = runner
            self.longitudinal_order = order if runner is not None else self.longitudinal_order
        elif domain == "lateral":
            self.lateral = runner
            self.lateral_order = order if runner is not None else self.lateral_order
        elif runner is not None:
            self.lights[domain] = runner
        else:
            self.lights.pop(domain, None)

    def limit_friction(self, friction: float) -> None:
        """Accelerate and brake with no more than the friction coefficient [-] of the road times the weight."""
        most = friction * GRAVITY
        self.max_acceleration, self.max_deceleration = min(self.able[0], most), min(self.able[1], most)

    def note_rest(self, time: float) -> None:
        """Keep since when [s] it has been standing, and at the end of its road; `time` is now."""
        still = STILL_MEASURED if self.external else STILL
        standing = -still < self.speed < still
        self.still_since = min(self.still_since, time) if standing else math.inf
        self.end_since = min(self.end_since, time) if self.end_of_road else math.inf

    def jump_to_speed(self, speed: float) -> None:
        """A step in speed: holds from the beginning of the step on."""
        self.speed = speed
        self.speed_before = speed

    def put(self, x: float, y: float, z: float, h: float) -> None:
        """Set the pose; the road state is found again when it is needed."""
        self.x = x
        self.y = y
        self.z = z
        self.h = wrap(h)
        self.tracked = False
        self.drift = 0.0

    def draw_behind(self, x: float, y: float, h: float) -> None:
        """Turn so that the point behind the reference point, which was at x, y [m], h [rad], is drawn along."""
        back_x = x - self.leads * math.cos(h)
        back_y = y - self.leads * math.sin(h)
        self.h = math.atan2(self.y - back_y, self.x - back_x)

    def corners(self) -> tuple[tuple[float, float], ...]:
        """The four corners of the bounding box on the ground [m], world frame, counter-clockwise from front left."""
        c, s = math.cos(self.h), math.sin(self.h)
        front, rear = self.center_x + 0.5 * self.length, self.center_x - 0.5 * self.length
        left, right = self.center_y + 0.5 * self.width, self.center_y - 0.5 * self.width
        x, y = self.x, self.y
        return (
            (x + c * front - s * left, y + s * front + c * left),
            (x + c * rear - s * left, y + s * rear + c * left),
            (x + c * rear - s * right, y + s * rear + c * right),
            (x + c * front - s * right, y + s * front + c * right),
        )

    def extent(self, axis: float) -> tuple[float, float]:
        """How far the box reaches back and ahead of the reference point along `axis` [rad]: low, high [m]."""
        turn = self.h - axis
        c, s = math.cos(turn), math.sin(turn)
        middle = c * self.center_x - s * self.center_y
        half = 0.5 * (abs(c) * self.length + abs(s) * self.width)
        return middle - half, middle + half


def _number(text: str | None) -> float:
    """A property as a number >= 0; 0 if it is none."""
    try:
        value = float(text or 0.0)
    except ValueError:
        return 0.0
    return value if 0.0 < value < math.inf else 0.0
