"""Trajectories as tables over their arc length: polyline, clothoid, clothoid spline, NURBS; timed or not.

A `Course` answers where one is after s metres and how far one has come after t seconds. Curves are sampled at 0.1 m
or finer once, when the action starts; a step costs two bisections.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise

from openscenario import model
from openscenario.storyboard.places import Place, wrap

Resolve = Callable[[model.Position], Place]

SAMPLING = 0.1  # m: a chord of a 5 m radius is then 0.25 mm off the arc
MOST_SAMPLES = 200_000  # of one curve; chosen, not measured: it bounds memory
FINE = 10  # samples a metre of a NURBS
CORNER = 2.0  # m: how far before and after a vertex a vehicle turns into the next straight


class Course:
    """Points along a curve. s, x, y, z: columns [m]; h: headings [rad], unwrapped; t: time stamps [s] or None.

    `smooth` tells for each point whether the heading turns evenly from it to the next one; else it is kept and turned
    only near the points. `speed` [m/s] is what a vehicle has at the first point that goes on between time stamps with
    constant acceleration, None for one with constant speed. `explicit`: the headings were given, they need not be those
    of the curve.
    """

    __slots__ = ("_corner", "_pace", "_smooth", "explicit", "h", "length", "s", "t", "x", "y", "z")

    def __init__(
        self,
        points: Sequence[tuple[float, float, float, float]],
        times: Sequence[float] | None = None,
        *,
        smooth: Sequence[bool] | None = None,
        corner: float = CORNER,
        speed: float | None = None,
        explicit: bool = False,
    ) -> None:
        self.explicit = explicit
        self.x: list[float] = []
        self.y: list[float] = []
        self.z: list[float] = []
        self.h: list[float] = []
        self.s: list[float] = []
        self.t: list[float] | None = None if times is None else list(times)
        self._smooth = smooth
        self._corner = corner
        length = 0.0
        for x, y, z, h in points:
            if self.x:
                length += math.hypot(x - self.x[-1], y - self.y[-1])
                h = self.h[-1] + wrap(h - self.h[-1])
            self.x.append(x)
            self.y.append(y)
            self.z.append(z)
            self.h.append(h)
            self.s.append(length)
        self.length = length
        self._pace = None if speed is None or times is None else _pace(self.s, times, speed)

    def at(self, s: float) -> tuple[float, float, float, float]:
        """x, y, z, heading after `s` metres; beyond an end the curve stands still there."""
        where = self.s
        last = len(where) - 1
        if last == 0:
            return self.x[0], self.y[0], self.z[0], self.h[0]
        if s <= 0.0:
            s = 0.0
        elif s >= self.length:
            s = self.length
        i = min(max(bisect_right(where, s) - 1, 0), last - 1)
        step = where[i + 1] - where[i]
        u = (s - where[i]) / step if step > 0.0 else 1.0
        if self._smooth is not None and not self._smooth[i]:
            h = self._turning(i, s)
        else:
            h = self.h[i] + u * (self.h[i + 1] - self.h[i])
        x = self.x[i] + u * (self.x[i + 1] - self.x[i])
        y = self.y[i] + u * (self.y[i + 1] - self.y[i])
        z = self.z[i] + u * (self.z[i + 1] - self.z[i])
        return x, y, z, h

    def _turning(self, i: int, s: float) -> float:
        """Heading along straight pieces: their own, blended linearly within a few metres of a vertex."""
        here = self.h[i]
        into, left = s - self.s[i], self.s[i + 1] - s
        radius = min(self._corner, 0.5 * (self.s[i + 1] - self.s[i]))
        if radius <= 0.0:
            return here
        if into < radius and i > 0:
            return here - 0.5 * (1.0 - into / radius) * (here - self.h[i - 1])
        if left < radius:
            return here + 0.5 * (1.0 - left / radius) * (self.h[i + 1] - here)
        return here

    def tangent(self, s: float) -> float:
        """Direction [rad] of the curve after `s` metres, whatever headings its points ask for."""
        last = len(self.s) - 1
        i = min(max(bisect_right(self.s, s) - 1, 0), last - 1)
        while i >= 0 and self.s[i + 1] - self.s[i] <= 0.0:
            i -= 1
        return self.h[0] if i < 0 else math.atan2(self.y[i + 1] - self.y[i], self.x[i + 1] - self.x[i])

    def pitch(self, s: float) -> float:
        """Pitch [rad] of the curve after `s` metres: uphill is negative."""
        last = len(self.s) - 1
        i = min(max(bisect_right(self.s, s) - 1, 0), last - 1)
        step = self.s[i + 1] - self.s[i] if last > 0 else 0.0
        return -math.atan2(self.z[i + 1] - self.z[i], step) if step > 0.0 else 0.0

    def nearest(self, x: float, y: float) -> float:
        """Arc length [m] of the point of the curve that lies nearest to a place."""
        best, where = math.inf, 0.0
        for i in range(len(self.s) - 1):
            dx, dy = self.x[i + 1] - self.x[i], self.y[i + 1] - self.y[i]
            square = dx * dx + dy * dy
            u = min(max(((x - self.x[i]) * dx + (y - self.y[i]) * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
            apart = math.hypot(self.x[i] + u * dx - x, self.y[i] + u * dy - y)
            if apart < best - 1e-12:
                best, where = apart, self.s[i] + u * (self.s[i + 1] - self.s[i])
        return where

    def s_at(self, t: float) -> float:
        """Arc length [m] reached at trajectory time `t` [s]; stands at its ends outside the time stamps."""
        times = self.t
        if times is None:
            return 0.0
        if t <= times[0]:
            return self.s[0]
        if t >= times[-1]:
            return self.length
        i = bisect_right(times, t) - 1
        if self._pace is not None:
            speed, acceleration = self._pace[i]
            after = t - times[i]
            if acceleration < 0.0:
                after = min(after, -speed / acceleration)  # there before its time: it waits
            return self.s[i] + (speed + 0.5 * acceleration * after) * after
        u = (t - times[i]) / (times[i + 1] - times[i])  # t is before the later one, and not before the other
        return self.s[i] + u * (self.s[i + 1] - self.s[i])

    def time_at(self, s: float) -> float:
        """Trajectory time [s] at which the way has come to `s` [m]; 0 without time stamps."""
        early, late = self.start_time, self.end_time
        if s <= 0.0:
            return early
        for _ in range(60):
            middle = 0.5 * (early + late)
            if self.s_at(middle) < s:
                early = middle
            else:
                late = middle
        return late

    @property
    def start_time(self) -> float:
        """Time stamp [s] of the first vertex; 0 without time stamps."""
        return self.t[0] if self.t else 0.0

    @property
    def end_time(self) -> float:
        """Time stamp [s] of the last vertex; 0 without time stamps."""
        return self.t[-1] if self.t else 0.0


def _pace(s: Sequence[float], times: Sequence[float], speed: float) -> list[tuple[float, float]]:
    """Speed [m/s] at each time stamp and acceleration [m/s^2] from there on that meet the next one in time.

    If that would need a way back the vehicle brakes to a stand at the next point, before its time.
    """
    pace = []
    for i in range(len(s) - 1):
        way, time = s[i + 1] - s[i], times[i + 1] - times[i]
        if way < 1e-6 or time <= 0.0:
            speed = 0.0 if way < 1e-6 else speed
            pace.append((speed, 0.0))
            continue
        acceleration = 2.0 * (way - speed * time) / (time * time)
        after = speed + acceleration * time
        if after < 0.0:
            acceleration, after = -speed * speed / (2.0 * way), 0.0
        pace.append((speed, acceleration))
        speed = after
    return pace


def course(
    trajectory: model.Trajectory,
    resolve: Resolve,
    start: Place | None = None,
    *,
    follow: float | None = None,
    turning: str | None = None,
) -> Course:
    """The course of a trajectory; `resolve` makes places of positions, `start` is where one without any begins.

    `follow` is the speed [m/s] of a vehicle that follows it (mode `follow`): between the vertices of a polyline it
    turns and accelerates evenly. None (mode `position`): it is where the vertices say, with constant speed between.
    The standard leaves that to the tool. `turning` says how headings change whatever the mode: "segment" evenly,
    "corner" at the vertices, "none" not before the next vertex.

    Raises nothing for what the reader lets through: a single point is a course of length 0.
    """
    shape = trajectory.shape
    if isinstance(shape, model.Polyline):
        return _polyline(shape, trajectory.closed, resolve, follow, turning)
    if isinstance(shape, model.Clothoid):
        return _clothoid(shape, resolve)
    if isinstance(shape, model.ClothoidSpline):
        return _clothoid_spline(shape, resolve, start)
    return _nurbs(shape, resolve)


def _polyline(
    shape: model.Polyline, closed: bool, resolve: Resolve, follow: float | None, turning: str | None
) -> Course:
    vertices = list(shape.vertices)
    places = [resolve(vertex.position) for vertex in vertices]
    times = [vertex.time for vertex in vertices]
    if closed and len(places) > 1 and math.hypot(places[0].x - places[-1].x, places[0].y - places[-1].y) > 1e-6:
        places.append(places[0])
        times.append(_time_of_return(places, times))
    stamps = None if any(time is None for time in times) else [float(time or 0.0) for time in times]
    tangents = _tangents([(place.x, place.y) for place in places], places[0].h)
    headings = [p.h if p.has_heading else tangents[i] for i, p in enumerate(places)]
    points = [(p.x, p.y, p.z, h) for p, h in zip(places, headings, strict=True)]
    smooth = [turning == "segment" or (turning is None and follow is not None and p.has_heading) for p in places]
    corner = 0.0 if turning == "none" else CORNER
    return Course(points, stamps, smooth=smooth, corner=corner, speed=follow, explicit=places[0].has_heading)


def _time_of_return(places: Sequence[Place], times: Sequence[float | None]) -> float | None:
    """Time stamp [s] of the first vertex where a closed polyline comes back to it: at the speed of the leg before, or
    the mean speed where that one stands. The standard names none. `places` has the first one at its end already."""
    ways = [math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(places)]
    if any(time is None for time in times):
        return None
    stamps = [time or 0.0 for time in times]
    for way, taken in ((ways[-2], stamps[-1] - stamps[-2]), (sum(ways[:-1]), stamps[-1] - stamps[0])):
        if way > 0.0 and taken > 0.0:
            return stamps[-1] + ways[-1] * taken / way
    return stamps[-1]


def _tangents(points: Sequence[tuple[float, float]], first: float) -> list[float]:
    """Heading of the piece that starts at each point; the last one keeps the heading it arrives with."""
    headings: list[float] = []
    for i, (x, y) in enumerate(points):
        heading = headings[-1] if headings else first
        if i + 1 < len(points):
            dx, dy = points[i + 1][0] - x, points[i + 1][1] - y
            if dx * dx + dy * dy > 1e-18:
                heading = math.atan2(dy, dx)
        headings.append(heading)
    return headings


def _arc(
    x: float, y: float, z: float, h: float, curvature: float, change: float, length: float
) -> list[tuple[float, float, float, float]]:
    """A clothoid piece; the heading is exact, the position by the midpoint rule on short steps."""
    count = min(max(math.ceil(length / SAMPLING), 1), MOST_SAMPLES)
    step = length / count
    points = [(x, y, z, h)]
    for i in range(count):
        middle = (i + 0.5) * step
        along = h + curvature * middle + 0.5 * change * middle * middle
        # the chord of an arc is shorter than the arc
        half = 0.5 * step * (curvature + change * middle)
        chord = step * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        x += chord * math.cos(along)
        y += chord * math.sin(along)
        end = (i + 1) * step
        points.append((x, y, z, h + curvature * end + 0.5 * change * end * end))
    return points


def _stamped(points: list[tuple[float, float, float, float]], start: float | None, stop: float | None) -> Course:
    if start is None or stop is None:
        return Course(points)
    last = max(len(points) - 1, 1)
    return Course(points, [start + (stop - start) * i / last for i in range(len(points))])


def _clothoid(shape: model.Clothoid, resolve: Resolve) -> Course:
    place = resolve(shape.position)
    points = _arc(place.x, place.y, place.z, place.h, shape.curvature, shape.curvature_prime, shape.length)
    return _stamped(points, shape.start_time, shape.stop_time)


def _clothoid_spline(shape: model.ClothoidSpline, resolve: Resolve, start: Place | None) -> Course:
    points: list[tuple[float, float, float, float]] = []
    times: list[float] = []
    x, y, z, h = (start.x, start.y, start.z, start.h) if start is not None else (0.0, 0.0, 0.0, 0.0)
    segments = shape.segments
    for i, segment in enumerate(segments):
        if segment.position_start is not None:
            place = resolve(segment.position_start)
            x, y, z, h = place.x, place.y, place.z, place.h
        change = (segment.curvature_end - segment.curvature_start) / segment.length if segment.length > 0.0 else 0.0
        piece = _arc(x, y, z, h + segment.h_offset, segment.curvature_start, change, segment.length)
        begin = segment.time_start
        end = segments[i + 1].time_start if i + 1 < len(segments) else shape.time_end
        if begin is not None and end is not None:
            last = len(piece) - 1
            times.extend(begin + (end - begin) * k / last for k in range(len(piece)))
        points.extend(piece)
        x, y, z, h = piece[-1]
    return Course(points, times if len(times) == len(points) else None)


def _nurbs(shape: model.Nurbs, resolve: Resolve) -> Course:
    """Rational B-spline by de Boor's algorithm; tangent headings.

    The time of a control point is that of the place where its influence is greatest, or of the last whole metre of the
    control polygon before; time changes evenly over each metre. (The standard does not say where on the curve the time
    stamps belong; this is how the field's tools drive it.)
    """
    places = [resolve(point.position) for point in shape.control_points]
    knots = [knot.value for knot in shape.knots]
    degree = shape.order - 1
    timed = all(point.time is not None for point in shape.control_points)
    control = [
        (
            place.x * point.weight,
            place.y * point.weight,
            place.z * point.weight,
            point.weight,
        )
        for place, point in zip(places, shape.control_points, strict=True)
    ]
    low, high = knots[degree], knots[len(control)]
    rough = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(places))
    metres = min(1 + int(rough), MOST_SAMPLES // FINE)
    parameters = [low + (high - low) * i / (metres * FINE) for i in range(metres * FINE + 1)]
    samples = [_de_boor(control, knots, degree, u) for u in parameters]
    pieces = _tangents([(x, y) for x, y, _ in samples], places[0].h)
    # tangent at a sample: mean of the chords before and after it
    headings = [pieces[0]]
    for before, after in pairwise(pieces):
        headings.append(before + 0.5 * wrap(after - before))
    points = [(x, y, z, h) for (x, y, z), h in zip(samples, headings, strict=True)]
    if not timed:
        return Course(points)
    stamps = [point.time or 0.0 for point in shape.control_points]
    peaks = _peaks(knots, degree, len(control), parameters[::FINE])
    reached = Course(points).s[::FINE]
    times = [_between(peaks, stamps, u) for u in parameters[::FINE]]
    return Course(points, [_between(reached, times, s) for s in Course(points).s])


def _peaks(knots: Sequence[float], degree: int, count: int, places: Sequence[float]) -> list[float]:
    """Of each control point: of some places, the last one before its influence on the curve is greatest, or there."""
    where = []
    for i in range(count):
        control = [(1.0 if j == i else 0.0, 0.0, 0.0, 1.0) for j in range(count)]
        influence = [_de_boor(control, knots, degree, u)[0] for u in places]
        k = max(range(len(places)), key=influence.__getitem__)
        if k > 0:
            shortly = places[k] - 1e-3 * (places[k] - places[k - 1])
            if _de_boor(control, knots, degree, shortly)[0] > influence[k]:
                k -= 1  # it has been greater
        where.append(places[k])
    return where


def _between(places: Sequence[float], values: Sequence[float], u: float) -> float:
    """Linear interpolation in places that do not fall."""
    i = min(max(bisect_right(places, u) - 1, 0), len(places) - 2)
    step = places[i + 1] - places[i]
    share = min(max((u - places[i]) / step, 0.0), 1.0) if step > 0.0 else 1.0
    return values[i] + share * (values[i + 1] - values[i])


def _de_boor(
    control: Sequence[tuple[float, float, float, float]], knots: Sequence[float], degree: int, u: float
) -> tuple[float, float, float]:
    k = min(max(bisect_right(knots, u) - 1, degree), len(control) - 1)
    d = [list(control[j + k - degree]) for j in range(degree + 1)]
    for r in range(1, degree + 1):
        for j in range(degree, r - 1, -1):
            left = knots[j + k - degree]
            width = knots[j + 1 + k - r] - left
            a = (u - left) / width if width > 0.0 else 0.0
            d[j] = [(1.0 - a) * p + a * q for p, q in zip(d[j - 1], d[j], strict=True)]
    x, y, z, weight = d[degree]
    return x / weight, y / weight, z / weight
