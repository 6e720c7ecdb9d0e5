"""The truth around the ego: storyboard actors and SUMO's cars as boxes, once a tick, and what the ego touches."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.drive.contact import Contact, ContactDetector
from vehicle.messages import OBJECT_KINDS, SEEING, FloatArray, Light, SignalState, Surroundings, VehicleDescription

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard
    from openscenario.storyboard.entity import Entity
    from pytest_dvp.drive.sumo_traffic import Car, Mirrored

ROUTINE_MASS = {"vehicle": 1500.0, "pedestrian": 75.0, "misc": 100.0}  # kg, where the file states none
_BICYCLES = ("bicycle", "motorbike")


class Traffic(Protocol):
    """Background traffic, stepped with the world's clock."""

    def step(self, t: float, mirrored: Callable[[], Sequence[Mirrored]]) -> list[Car]:
        """Step to `t` [s]; `mirrored` gives the world's own road users. Returns the cars of the traffic."""
        ...

    def close(self) -> None:
        """End the traffic."""
        ...


class World:
    """Everything but the ego; `look` once a tick in time order, `contacts` after the ego has moved.

    masses: [kg] by entity name, where the scenario states them.
    """

    def __init__(
        self,
        storyboard: Storyboard,
        ego: str,
        description: VehicleDescription,
        masses: Mapping[str, float],
        traffic: Traffic | None = None,
    ) -> None:
        self._storyboard = storyboard
        self._ego = storyboard.entities[ego]
        actors = [entity for name, entity in storyboard.entities.items() if name != ego]
        self._description = description
        self._traffic = traffic
        known = {actor.name: masses.get(actor.name, ROUTINE_MASS.get(actor.kind, 1500.0)) for actor in actors}
        d = description
        self._detector = ContactDetector(d.length, d.width, d.center_x, d.mass, known)
        self._names: tuple[str, ...] = ()
        self._kinds: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._seen: Surroundings | None = None
        self._looks: tuple[float | None, float | None] = (None, None)  # s, of the last two looks
        self._jumps: dict[str, int] = {}  # teleports of each entity until the last look for contacts

    def look(
        self, t: float, signals: tuple[SignalState, ...] = (), extinction: float = 0.0, light: Light | None = None
    ) -> Surroundings:
        """All boxes at time `t` [s], in air of that extinction [1/m] and that light."""
        self._looks = self._looks[1], t
        names: list[str] = []
        unseen: dict[str, set[str]] = {}
        rows: list[tuple[float, ...]] = []
        actors: list[Entity] = []
        traffic: list[str] = []
        for e in self._storyboard.entities.values():  # those of its traffic come and go
            if not e.active or e is self._ego:
                continue
            cos, sin = math.cos(e.h), math.sin(e.h)
            x = e.x + cos * e.center_x - sin * e.center_y
            y = e.y + sin * e.center_x + cos * e.center_y
            velocity = self._storyboard.velocity(e)
            rows.append((x, y, e.z + e.center_z, e.h, e.length, e.width, e.height, *velocity))
            names.append(e.name)
            actors.append(e)
            for sensor in SEEING:
                if not e.visible.to(sensor):
                    unseen.setdefault(sensor, set()).add(e.name)
        if self._traffic is not None:
            ground = self._ego.z
            mirrors, states = tuple(names), tuple(rows)

            def mirrored() -> list[Mirrored]:
                return self._mirrored(mirrors, states)

            for car in self._traffic.step(t, mirrored):
                z = ground + 0.5 * car.height
                rows.append((car.x, car.y, z, car.yaw, car.length, car.width, car.height, car.vx, car.vy))
                names.append(car.name)
                traffic.append(car.kind)
        if tuple(names) != self._names:
            self._names = tuple(names)
            kinds = [_kind_index(e.kind, e.category) for e in actors] + [OBJECT_KINDS.index(kind) for kind in traffic]
            self._kinds = np.array(kinds, dtype=np.int64)
        boxes = np.array(rows, dtype=np.float64) if rows else np.zeros((0, 9))
        hidden = {sensor: frozenset(each) for sensor, each in unseen.items()}
        self._seen = Surroundings(boxes, self._kinds, self._names, signals, hidden, extinction, light)
        return self._seen

    def contacts(self, rows: FloatArray, before: Surroundings, after: Surroundings) -> list[Contact]:
        """What the ego touched between the last two looks; rows (n, 12) as ContactDetector.check takes them.

        What was put elsewhere in between was at no place on the way.
        """
        jumps = {name: entity.teleports for name, entity in self._storyboard.entities.items()}
        jumped = {name for name, count in jumps.items() if count != self._jumps.get(name, count)}
        self._jumps = jumps
        if before.names == after.names and not jumped:
            return self._detector.check(rows, after.names, before.boxes, after.boxes, self._looks[0])
        last = {n: box for n, box in zip(before.names, before.boxes, strict=True) if n not in jumped}
        old: FloatArray = np.array([last.get(n, after.boxes[i]) for i, n in enumerate(after.names)]).reshape(-1, 9)
        return self._detector.check(rows, after.names, old, after.boxes, self._looks[0])

    def close(self) -> None:
        """End the background traffic, if there is any."""
        if self._traffic is not None:
            self._traffic.close()

    def _mirrored(self, names: Sequence[str], rows: Sequence[tuple[float, ...]]) -> list[Mirrored]:
        from pytest_dvp.drive.sumo_traffic import Mirrored

        ego, d = self._ego, self._description
        cos, sin = math.cos(ego.h), math.sin(ego.h)
        x, y = ego.x + d.center_x * cos, ego.y + d.center_x * sin
        boxes = [Mirrored(ego.name, x, y, ego.h, d.length, d.width, ego.speed)]
        boxes += [
            Mirrored(name, r[0], r[1], r[3], r[4], r[5], math.hypot(r[7], r[8]))
            for name, r in zip(names, rows, strict=True)
        ]
        entities = self._storyboard.entities
        return [box for box in boxes if entities[box.name].visible.traffic]


def _kind_index(kind: str, category: str) -> int:
    if kind == "vehicle" and category in _BICYCLES:
        return OBJECT_KINDS.index("bicycle")
    return OBJECT_KINDS.index(kind) if kind in OBJECT_KINDS else OBJECT_KINDS.index("misc")
