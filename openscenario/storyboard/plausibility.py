"""Motion that no vehicle and no pedestrian could make, or that an action forbids.

Looked for after each step in whatever the storyboard moves, whoever asked for it, so that errors of a file show (a
trajectory faster than the car) and errors of the interpreter as well:

- beyond the entity's own Performance;
- beyond the DynamicConstraints of an action that moves it (SpeedProfileAction, LongitudinalDistanceAction along its
  way; LateralDistanceAction across its lane);
- a jump of position, speed or heading without a teleport;
- motion to the side: the default controller keeps an entity on its lane, so one that faces across the lane slides.

The first step is left out: what acts at once at t = 0 says where and how a scenario begins.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from openscenario import model
from openscenario.storyboard.limits import Limits, first, given, performance

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard
    from openscenario.storyboard.entity import Entity

CODE: Final = "dvp.implausible_motion"
SHARE: Final = 0.05  # of a limit: what the sampling of a polyline or a spline may exceed it by
SPEED: Final = 0.1  # m/s, above maxSpeed or beyond what the acceleration allows in a step: rounding of times in a file
SUDDEN: Final = 0.1  # m/s^2, beyond what a limit of jerk allows in a step; chosen
ASIDE: Final = 0.02  # m/s across the lane, beyond what a limit allows: what a curve turns the lane in a step
JUMP: Final = 0.5  # m, beyond what the speed explains: more than a lane change moves sideways in a step
START: Final = 3.0  # m/s in a step, of who has no Performance: children of Euro NCAP run at once, with 10 km/h
TURN: Final = 0.2  # rad in a step, besides turning on a circle
TIGHTEST: Final = 2.0  # m, radius of the tightest circle that a vehicle drives, about its rear axle
ASKEW: Final = 0.25 * math.pi  # rad between its way and where it faces: half of what is straight to the side; chosen
CREEP: Final = 0.1  # m/s; who is slower hardly goes anywhere; chosen
NOBODY: Final = Limits()


@dataclasses.dataclass(slots=True)
class _Seen:
    """An entity after the step before; `lane`: the direction of its lane [rad], `ax`, `aside`: what it did in that
    step along its way [m/s^2] and across its lane [m/s], None before it has done a step."""

    x: float
    y: float
    h: float
    lane: float
    speed: float
    teleports: int
    ax: float | None = None
    aside: float | None = None


class _Constraint(NamedTuple):
    """DynamicConstraints that hold for an entity in a step: of which event's action."""

    event: str
    limits: Limits
    lateral: bool


@dataclasses.dataclass
class _Found:
    """The first time that an entity moved in one of the impossible ways, and the worst."""

    t: float
    event: str
    found: float
    worst: float
    allowed: float
    count: int = 1


class Plausibility:
    """Watches the entities of one storyboard; `look` after each step."""

    def __init__(self, board: Storyboard) -> None:
        self._board = board
        self._seen: dict[str, _Seen] = {}
        self._found: dict[tuple[str, str, str], _Found] = {}
        self.look(0.0)

    def look(self, dt: float) -> None:
        """Compare each entity with what it was before the last step of `dt` [s]; one that ended it all moved nobody."""
        if self._board.done:
            return
        constraints = self._constraints() if dt > 0.0 and self._board.acted else {}
        for name, entity in self._board.entities.items():
            if entity.external or not entity.active or entity.drawn_by is not None:
                self._seen.pop(name, None)
                continue
            lane = entity.h - entity.twist - entity.drift
            now = _Seen(entity.x, entity.y, entity.h, lane, entity.speed, entity.teleports)
            before = self._seen.get(name)
            if before is not None and dt > 0.0 and before.teleports == entity.teleports and self._board.steps > 1:
                self._compare(entity, before, now, dt, constraints.get(name, ()))
            self._seen[name] = now

    def _constraints(self) -> dict[str, tuple[_Constraint, ...]]:
        """What the actions of the last step allowed, by entity."""
        found: dict[str, tuple[_Constraint, ...]] = {}
        for node, held in self._board.acted:
            constraints = getattr(node.element, "dynamic_constraints", None)
            if constraints is None:
                continue
            event = "Init" if node.parent is None or node.parent.kind != "event" else node.parent.name
            one = _Constraint(event, given(constraints), isinstance(node.element, model.LateralDistanceAction))
            if isinstance(node.element, model.SpeedProfileAction) and node.element.following_mode == "position":
                one = one._replace(limits=one.limits._replace(rise=math.inf, fall=math.inf))  # strictly linear
            for each in held:
                if each.entity is not None:
                    found[each.entity.name] = (*found.get(each.entity.name, ()), one)
        return found

    def _compare(
        self, entity: Entity, before: _Seen, now: _Seen, dt: float, constraints: tuple[_Constraint, ...]
    ) -> None:
        own = able = performance(entity)
        along = [each for each in constraints if not each.lateral] if constraints else []
        if self._board.reading == "standard":  # class SpeedProfileAction (1.3): they have precedence over Performance
            for each in along:
                own = first(each.limits, own)
        self._along(entity, before, now, dt, own)
        for each in along:
            self._along(entity, before, now, dt, each.limits, each.event)
        if able.up == able.down == math.inf:
            change = abs(now.speed - before.speed)
            self._note(entity, "speed_jump", change, START, START)
        if constraints:
            self._aside(entity, before, now, dt, [each for each in constraints if each.lateral])
        way = math.hypot(now.x - before.x, now.y - before.y)
        explained = max(abs(before.speed), abs(now.speed)) * dt
        self._note(entity, "position", way, explained + JUMP, explained)
        if not entity.moved and way > CREEP * dt:  # kept on its lane, whichever way it faces
            self._note(entity, "direction_of_motion", abs(math.asin(math.sin(entity.twist))), ASKEW, ASKEW)
        if entity.kind == "vehicle":
            turn = abs(math.remainder(now.h - before.h, 2.0 * math.pi))
            self._note(entity, "heading", turn, way / TIGHTEST + TURN, way / TIGHTEST)

    def _along(
        self, entity: Entity, before: _Seen, now: _Seen, dt: float, limits: Limits, event: str | None = None
    ) -> None:
        """Speed, acceleration and jerk along the way, against limits: of an event's action, or the entity's own."""
        if limits == NOBODY:
            return
        now.ax = (now.speed - before.speed) / dt
        self._note(entity, "speed", abs(now.speed), limits.speed * (1.0 + SHARE) + SPEED, limits.speed, event)
        faster = now.speed * before.speed >= 0.0 and abs(now.speed) > abs(before.speed)
        what, limit = ("acceleration", limits.up) if faster else ("deceleration", limits.down)
        self._note(entity, what, abs(now.ax), limit * (1.0 + SHARE) + SPEED / dt, limit, event)
        if before.ax is None or entity.moved or not limits.smooth:  # times in a file are too rough for jerks
            return
        # letting go of pedal or brake is free, as in `Limits.eased`
        harder = (now.ax > max(before.ax, 0.0)) or (now.ax < min(before.ax, 0.0))
        if harder:
            what, limit = ("acceleration_rate", limits.rise) if now.ax > 0.0 else ("deceleration_rate", limits.fall)
            sudden = abs(now.ax - before.ax) / dt
            self._note(entity, what, sudden, limit * (1.0 + SHARE) + SUDDEN / dt, limit, event)

    def _aside(self, entity: Entity, before: _Seen, now: _Seen, dt: float, constraints: list[_Constraint]) -> None:
        """Speed and acceleration across the lane, against the DynamicConstraints of a LateralDistanceAction."""
        if not constraints:
            return
        lane = before.lane + 0.5 * math.remainder(now.lane - before.lane, 2.0 * math.pi)
        rate = now.aside = ((now.y - before.y) * math.cos(lane) - (now.x - before.x) * math.sin(lane)) / dt
        for each in constraints:
            limits = each.limits
            most = limits.speed * (1.0 + SHARE) + ASIDE
            self._note(entity, "lateral_speed", abs(rate), most, limits.speed, each.event)
            if before.aside is None:
                continue
            limit = limits.up if abs(rate) > abs(before.aside) else limits.down
            hard = abs(rate - before.aside) / dt
            self._note(entity, "lateral_acceleration", hard, limit * (1.0 + SHARE) + ASIDE / dt, limit, each.event)

    def _note(
        self, entity: Entity, what: str, found: float, most: float, allowed: float, event: str | None = None
    ) -> None:
        """Keep it if it is beyond what is tolerated; `event`: whose action limits it, None: no action."""
        if not found > most:
            return
        limit = JUMPED.get(what, "Performance") if event is None else "DynamicConstraints"
        known = self._found.get((entity.name, what, limit))
        if known is None:
            ended = ["the end of its road"] if entity.end_of_road else []
            acting = ", ".join(dict.fromkeys(self._board.events_of(entity) or ended))
            self._found[(entity.name, what, limit)] = _Found(
                self._board.time, acting if event is None else event, found, found, allowed
            )
        else:
            known.count += 1
            known.worst = max(known.worst, found)

    def findings(self) -> tuple[dict[str, Any], ...]:
        """One for each entity, kind of motion and limit.

        Keys: code, field (NAME and a key of `UNITS`, with a dot), t [s] and `found` of the first time, what is
        `allowed`, the `worst`, in how many steps (`count`), `entity`, `limit` (Performance, DynamicConstraints, or
        `continuity` for a jump), and `event`: those that acted on it then, by name (that of the DynamicConstraints,
        if it is these that do not allow it), or the end of its road.
        """
        return tuple(
            {
                "code": CODE,
                "field": f"{name}.{what}",
                "t": found.t,
                "found": found.found,
                "allowed": f"up to {found.allowed:.4g}{UNITS[what]}"
                + (f" by DynamicConstraints of {found.event}" if limit == "DynamicConstraints" else ""),
                "worst": found.worst,
                "count": found.count,
                "entity": name,
                "limit": limit,
                "event": found.event,
            }
            for (name, what, limit), found in self._found.items()
        )


UNITS: Final = {
    "speed": " m/s",
    "acceleration": " m/s^2",
    "deceleration": " m/s^2",
    "acceleration_rate": " m/s^3",
    "deceleration_rate": " m/s^3",
    "lateral_speed": " m/s",
    "lateral_acceleration": " m/s^2",
    "speed_jump": " m/s in a step",
    "position": " m in a step",
    "heading": " rad in a step",
    "direction_of_motion": " rad off its heading",
}
JUMPED: Final = dict.fromkeys(("speed_jump", "position", "heading", "direction_of_motion"), "continuity")


def said_of(finding: Mapping[str, Any]) -> str:
    """A finding in one line."""
    what = finding["field"].rpartition(".")[2]
    unit, times = UNITS[what], f"{finding['count']} step{'' if finding['count'] == 1 else 's'}"
    event = f" ({finding['event']})" if finding["event"] else ""
    worst = "" if finding["worst"] == finding["found"] else f", {finding['worst']:.4g}{unit} at worst"
    return (
        f"implausible motion: {what.replace('_', ' ')} of {finding['entity']} {finding['found']:.4g}{unit} "
        f"at t={finding['t']:.2f} s{event}, allowed {finding['allowed']}, in {times}{worst}"
    )
