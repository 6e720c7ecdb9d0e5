"""Contact of the ego with what is around it: exact box overlap by pymunk's solver, with the impulse of the hit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray

from machine_code import compiled
from vehicle.messages import FloatArray


class Contact(NamedTuple):
    """First touch of an object at `t` [s]: impulse [N s] along the contact normal, point in the map frame [m]."""

    t: float
    name: str
    impulse: float
    x: float
    y: float


@compiled
def _near(
    first: FloatArray,
    last: FloatArray,
    before: FloatArray,
    after: FloatArray,
    half_length: float,
    half_width: float,
    center: float,
) -> NDArray[np.int64]:
    """Indices of the boxes that could touch the ego at some time within the tick; the others need no solver.

    The widest gap along the axes of either box is a lower bound of their distance at the end of the tick, and neither
    can have come nearer than that less the ways both went.
    """
    yaw = last[4]
    ahead, left = math.cos(yaw), math.sin(yaw)
    x, y = last[1] + center * ahead, last[2] + center * left
    reach = math.hypot(half_length, half_width) + abs(center)
    moved = math.hypot(last[1] - first[1], last[2] - first[2]) + reach * abs(yaw - first[4])
    found = np.empty(len(after), dtype=np.int64)
    count = 0
    for i in range(len(after)):
        box = after[i]
        a, b = 0.5 * box[4], 0.5 * box[5]
        dx, dy = box[0] - x, box[1] - y
        c, s = abs(math.cos(box[3] - yaw)), abs(math.sin(box[3] - yaw))
        gap = abs(dx * ahead + dy * left) - half_length - c * a - s * b
        gap = max(gap, abs(dy * ahead - dx * left) - half_width - s * a - c * b)
        u, v = math.cos(box[3]), math.sin(box[3])
        gap = max(gap, abs(dx * u + dy * v) - a - c * half_length - s * half_width)
        gap = max(gap, abs(dy * u - dx * v) - b - s * half_length - c * half_width)
        turned = math.hypot(a, b) * abs(box[3] - before[i, 3])
        if gap <= moved + turned + math.hypot(box[0] - before[i, 0], box[1] - before[i, 1]):
            found[count] = i
            count += 1
    return found[:count]


class ContactDetector:
    """Watches one ego box for overlaps. `masses` [kg] by object name; unlisted ones count as 1,000 kg.

    The impulse is that of a perfectly plastic central hit, m v with the reduced mass m and the closing speed v along
    the contact normal: nobody is moved by it, the run ends soon after.
    """

    def __init__(self, length: float, width: float, center_x: float, mass: float, masses: Mapping[str, float]) -> None:
        self._center = center_x
        self._size = (0.5 * length, 0.5 * width, center_x)
        self._mass = mass
        self._masses = dict(masses)
        self._ego_body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)  # kept: a shape refers to its body weakly
        self._ego = pymunk.Poly.create_box(self._ego_body, (length, width))
        self._others: dict[str, tuple[pymunk.Poly, pymunk.Space, float]] = {}
        self._touching: set[str] = set()

    def check(
        self, rows: FloatArray, names: Sequence[str], before: FloatArray, after: FloatArray, since: float | None = None
    ) -> list[Contact]:
        """New contacts within a tick.

        rows    (n, 12) motion of the ego, columns TRACE_COLUMNS, in time order; n >= 1
        before  (n, 9) boxes (see Surroundings) at the start of the tick, rows in the order of `names`; after: its end
        since   [s] time of `before`; None: that of the first of `rows`. Those of a tick begin one period after it
        """
        start = float(rows[0, 0]) if since is None else since
        found: list[Contact] = []
        near = _near(rows[0], rows[-1], before, after, *self._size)
        for index in near.tolist():
            name = names[index]
            contact = self._sweep(rows, start, name, before[index].tolist(), after[index].tolist())
            if contact is None:
                self._touching.discard(name)
            elif name not in self._touching:
                self._touching.add(name)
                found.append(contact)
        if self._touching and len(near) < len(names):
            self._touching.intersection_update(names[index] for index in near.tolist())
        return found

    def _sweep(self, rows: FloatArray, start: float, name: str, a: list[float], b: list[float]) -> Contact | None:
        shape, space, mass = self._shape(name, b[4], b[5])
        end, turned = float(rows[-1, 0]), math.remainder(b[3] - a[3], 2.0 * math.pi)
        for t, x, y, _, yaw, _, forward, sideways, *_ in rows.tolist():
            share = min(max((t - start) / (end - start), 0.0), 1.0) if end > start else 1.0
            cos, sin = math.cos(yaw), math.sin(yaw)
            ex, ey = x + self._center * cos, y + self._center * sin
            ox, oy = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
            # Relative to the ego: map coordinates may be millions of metres, and the solver's tolerance is absolute.
            _place(self._ego, 0.0, 0.0, yaw)
            _place(shape, ox - ex, oy - ey, a[3] + share * turned)
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
