"""Motion that no vehicle and no pedestrian could make: beyond the own Performance, or a jump without a teleport.

It is looked for after each step in whatever the storyboard moves, whoever asked for it, so that errors of a file show
(a trajectory faster than the car) and errors of the interpreter as well.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard
    from openscenario.storyboard.entity import Entity

CODE: Final = "dvp.implausible_motion"
SHARE: Final = 0.05  # of a limit: what the sampling of a polyline or a spline may exceed it by
SPEED: Final = 0.1  # m/s, above maxSpeed or beyond what the acceleration allows in a step: rounding of times in a file
JUMP: Final = 0.5  # m, beyond what the speed explains: more than a lane change moves sideways in a step
TURN: Final = 0.2  # rad in a step, besides turning on a circle
TIGHTEST: Final = 2.0  # m, radius of the tightest circle that a vehicle drives, about its rear axle


@dataclasses.dataclass
class _Seen:
    """An entity after the step before."""

    x: float
    y: float
    h: float
    speed: float
    teleports: int


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
        self._found: dict[tuple[str, str], _Found] = {}
        self.look(0.0)

    def look(self, dt: float) -> None:
        """Compare each entity with what it was before the last step of `dt` [s]."""
        for name, entity in self._board.entities.items():
            if entity.external or not entity.active or entity.drawn_by is not None:
                self._seen.pop(name, None)
                continue
            before = self._seen.get(name)
            if before is not None and dt > 0.0 and before.teleports == entity.teleports:
                self._compare(entity, before, dt)
            self._seen[name] = _Seen(entity.x, entity.y, entity.h, entity.speed, entity.teleports)

    def _compare(self, entity: Entity, before: _Seen, dt: float) -> None:
        v0, v1 = abs(before.speed), abs(entity.speed)
        self._note(entity, "speed", v1, entity.max_speed * (1.0 + SHARE) + SPEED, entity.max_speed)
        faster = entity.speed * before.speed >= 0.0 and v1 > v0
        limit = entity.max_acceleration if faster else entity.max_deceleration
        change = abs(entity.speed - before.speed)
        what = "acceleration" if faster else "deceleration"
        self._note(entity, what, change / dt, limit * (1.0 + SHARE) + SPEED / dt, limit)
        way = math.hypot(entity.x - before.x, entity.y - before.y)
        explained = max(v0, v1) * dt
        self._note(entity, "position", way, explained + JUMP, explained)
        if entity.kind == "vehicle":
            turn = abs(math.remainder(entity.h - before.h, 2.0 * math.pi))
            self._note(entity, "heading", turn, way / TIGHTEST + TURN, way / TIGHTEST)

    def _note(self, entity: Entity, what: str, found: float, most: float, allowed: float) -> None:
        if not found > most:
            return
        known = self._found.get((entity.name, what))
        if known is None:
            ended = ["the end of its road"] if entity.end_of_road else []
            event = ", ".join(dict.fromkeys(self._board.events_of(entity) or ended))
            self._found[(entity.name, what)] = _Found(self._board.time, event, found, found, allowed)
        else:
            known.count += 1
            known.worst = max(known.worst, found)

    def findings(self) -> tuple[dict[str, Any], ...]:
        """One for each entity and kind of motion.

        Keys: code, field (NAME and one of `speed acceleration deceleration position heading`, with a dot), t [s] and
        `found` of the first time, what is `allowed`, the `worst`, in how many steps (`count`), `entity`, and `event`:
        those that act on it then, by name, or the end of its road.
        """
        return tuple(
            {
                "code": CODE,
                "field": f"{name}.{what}",
                "t": found.t,
                "found": found.found,
                "allowed": f"up to {found.allowed:.4g}{UNITS[what]}",
                "worst": found.worst,
                "count": found.count,
                "entity": name,
                "event": found.event,
            }
            for (name, what), found in self._found.items()
        )


UNITS: Final = {
    "speed": " m/s",
    "acceleration": " m/s^2",
    "deceleration": " m/s^2",
    "position": " m in a step",
    "heading": " rad in a step",
}


def said_of(finding: Mapping[str, Any]) -> str:
    """A finding in one line."""
    what = finding["field"].rpartition(".")[2]
    unit, times = UNITS[what], f"{finding['count']} step{'' if finding['count'] == 1 else 's'}"
    event = f" ({finding['event']})" if finding["event"] else ""
    worst = "" if finding["worst"] == finding["found"] else f", {finding['worst']:.4g}{unit} at worst"
    return (
        f"implausible motion: {what} of {finding['entity']} {finding['found']:.4g}{unit} at t={finding['t']:.2f} s"
        f"{event}, allowed {finding['allowed']}, in {times}{worst}"
    )
