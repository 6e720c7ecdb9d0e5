"""Contact of the ego with what is around it: exact box overlap by pymunk's solver, with the impulse of the hit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import pymunk

from vehicle.messages import FloatArray


class Contact(NamedTuple):
    """First touch of an object at `t` [s]: impulse [N s] along the contact normal, point in the map frame [m]."""

    t: float
    name: str
    impulse: float
    x: float
    y: float


class ContactDetector:
    """Watches one ego box for overlaps. `masses` [kg] by object name; unlisted ones count as 1,000 kg.

    The impulse is that of a perfectly plastic central hit, m v with the reduced mass m and the closing speed v along
    the contact normal: nobody is moved by it, the run ends soon after.
    """

    def __init__(self, length: float, width: float, center_x: float, mass: float, masses: Mapping[str, float]) -> None:
        self._center = center_x
        self._radius = math.hypot(length, width) / 2
        self._mass = mass
        self._masses = dict(masses)
        self._ego_body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)  # kept: a shape refers to its body weakly
        self._ego = pymunk.Poly.create_box(self._ego_body, (length, width))
        self._others: dict[str, tuple[pymunk.Poly, pymunk.Space, float]] = {}
        self._touching: set[str] = set()

    def check(self, rows: FloatArray, names: Sequence[str], before: FloatArray, after: FloatArray) -> list[Contact]:
        """New contacts within a tick.

        rows    (n, 6) t, x, y, yaw in the map frame and vx, vy in the body frame of the ego, in time order; n >= 1
        before  (n, 9) boxes (see Surroundings) at the start of the tick, rows in the order of `names`; after: its end
        """
        found: list[Contact] = []
        first, last = rows[0].tolist(), rows[-1].tolist()
        x, y = last[1] + self._center * math.cos(last[3]), last[2] + self._center * math.sin(last[3])
        moved = math.hypot(last[1] - first[1], last[2] - first[2]) + self._radius * abs(last[3] - first[3])
        for index, name in enumerate(names):
            a, b = before[index].tolist(), after[index].tolist()
            reach = self._radius + 0.5 * math.hypot(b[4], b[5])
            slack = math.hypot(b[0] - a[0], b[1] - a[1]) + moved
            if (b[0] - x) ** 2 + (b[1] - y) ** 2 > (reach + slack) ** 2:
                self._touching.discard(name)
                continue
            contact = self._sweep(rows, name, a, b)
            if contact is None:
                self._touching.discard(name)
            elif name not in self._touching:
                self._touching.add(name)
                found.append(contact)
        return found

    def _sweep(self, rows: FloatArray, name: str, a: list[float], b: list[float]) -> Contact | None:
        shape, space, mass = self._shape(name, b[4], b[5])
        start, end = float(rows[0, 0]), float(rows[-1, 0])
        for t, x, y, yaw, forward, sideways in rows.tolist():
            share = (t - start) / (end - start) if end > start else 1.0
            cos, sin = math.cos(yaw), math.sin(yaw)
            ex, ey = x + self._center * cos, y + self._center * sin
            ox, oy = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
            # Relative to the ego: map coordinates may be millions of metres, and the solver's tolerance is absolute.
            _place(self._ego, 0.0, 0.0, yaw)
            _place(shape, ox - ex, oy - ey, b[3])
            space.reindex_shape(shape)
            # Not shape.shapes_collide: it asserts that there is a contact, where none is the usual case.
            hits = space.shape_query(self._ego)
            if not hits:
                continue
            overlap = hits[0].contact_point_set
            vx, vy = forward * cos - sideways * sin, forward * sin + sideways * cos
            closing = (vx - b[7]) * overlap.normal.x + (vy - b[8]) * overlap.normal.y
            reduced = self._mass * mass / (self._mass + mass)
            point = overlap.points[0].point_a
            return Contact(t, name, reduced * max(0.0, closing), ex + point.x, ey + point.y)
        return None

    def _shape(self, name: str, length: float, width: float) -> tuple[pymunk.Poly, pymunk.Space, float]:
        known = self._others.get(name)
        if known is None:
            body, space = pymunk.Body(body_type=pymunk.Body.KINEMATIC), pymunk.Space()
            shape = pymunk.Poly.create_box(body, (length, width))
            space.add(body, shape)
            known = self._others[name] = (shape, space, self._masses.get(name, 1000.0))
        return known


def _place(shape: pymunk.Poly, x: float, y: float, yaw: float) -> None:
    body = shape.body
    assert body is not None
    body.position = (x, y)
    body.angle = yaw
    shape.cache_bb()
