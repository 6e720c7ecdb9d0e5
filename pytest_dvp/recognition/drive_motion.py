"""Position, heading, turn rate and speed of a foreign log: which columns agree on one motion of one car."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping import EARTH, LONGITUDE, LONGITUDE_DDMM, QUATERNION, in_degrees
from pytest_dvp.logs.units import find_unit
from pytest_dvp.recognition.columns import Column, pairs_of
from pytest_dvp.recognition.grid import NOTHING, Grid, Match
from pytest_dvp.recognition.words import families, words_of

ALIKE = 0.8  # correlation from which two columns tell one motion: the doctor's figure for accelerations
SURE = 0.95  # the same for a column whose name says nothing: at constant speed ay and yaw rate are 0.9 alike
ONE_ANGLE = 0.9  # mean resultant length from which course minus heading is one angle: a spread of 0.46 rad
DEGREE = math.pi / 180.0
DERIVED = 0.004  # of the speed: positions that fit it so well were integrated from it; tyres and clocks differ by more
DERIVED_WAY = 0.01  # m in a window, and to this: fixes of 1 cm (RTK) miss by 0.016, positions written in cm by 0.005
COURSE_WINDOW = 0.8  # s: as the doctor's
MOST_UNNAMED = 14  # columns whose names say nothing, of which any two are tried as a position: 91 pairs


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Path:
    """A pair of positions. unit: "" if the file does not state it, "longitude" for a fix; speed (n,) [units/s], course
    (n,) [rad] and turn (n,) [rad/s] on the grid; moving (n,); derived: as if integrated from a speed column."""

    x: Column
    y: Column
    unit: str
    speed: FloatArray
    course: FloatArray
    turn: FloatArray
    moving: NDArray[np.bool_]
    agreement: float
    derived: bool = False

    @property
    def is_fix(self) -> bool:
        """Whether it is in longitude and latitude, so that its metres are known."""
        return self.unit in (LONGITUDE, LONGITUDE_DDMM)

    @property
    def absolute(self) -> bool:
        """Whether its axes are known: east and north."""
        said = set(words_of(self.x.name)) | set(words_of(self.y.name))
        return self.is_fix or bool(said & {"east", "easting", "north", "northing"})


@dataclasses.dataclass(frozen=True, slots=True)
class Heading:
    """A column of the heading. degrees: its unit; sign, offset [rad]: heading = sign * column + offset; spread: mean
    resultant length of course minus heading; match with the turn of the path."""

    column: Column
    degrees: bool
    sign: float
    offset: float
    spread: float
    match: Match


def paths(columns: Sequence[Column], grid: Grid) -> list[Path]:
    """Pairs that can be positions, the best first: others agree with their speed and turn."""
    means = {c.key: grid.mean(c) for c in columns if c.unit != QUATERNION}
    turns = [grid.change(c.t, np.unwrap(c.values)) for c in columns if c.unit == QUATERNION]
    angles = [c for c in columns if c.unit != QUATERNION and "angle" in families(c.name, c.unit)]
    turns += [grid.change(c.t, np.unwrap(c.values * k)) for c in angles for k in (1.0, DEGREE)]
    found = []
    rates = [means[c.key] for c in columns if "rate" in families(c.name, c.unit)]
    for x, y in pairs_of(columns):
        if x.is_command or not _position(x, y):
            continue
        others = [values for key, values in means.items() if key not in (x.key, y.key)]
        path = _path(x, y, grid, others, turns)
        if path is not None:
            off = _off_unit(path, columns, rates, grid)
            found.append(dataclasses.replace(path, agreement=path.agreement - off))
    if not found:
        found = _unnamed_paths(columns, grid, means, turns)
    return sorted(found, key=lambda p: (-round(p.agreement - 0.5 * _reckoned(p), 1), p.is_fix))


def _unnamed_paths(
    columns: Sequence[Column], grid: Grid, means: Mapping[tuple[str, str], FloatArray], turns: Sequence[FloatArray]
) -> list[Path]:
    """Positions whose names say nothing: any two columns that make the speed and the turn of others, with a heading.

    The heading also tells which of the two is x: in the other order it would turn against the path.
    """
    found = []
    for first, second in _making_a_speed(columns, grid, means):
        for x, y in ((first, second), (second, first)):
            others = [values for key, values in means.items() if key not in (x.key, y.key)]
            path = _path(x, y, grid, others, turns)
            if path is None or path.agreement < SURE + ALIKE:
                continue
            told = headings([c for c in columns if c not in (x, y)], path, None, grid)
            if told and told[0].sign > 0.0:
                found.append(path)
    return found


def _making_a_speed(
    columns: Sequence[Column], grid: Grid, means: Mapping[tuple[str, str], FloatArray]
) -> Iterator[tuple[Column, Column]]:
    """Two columns without telling names whose way over time is another column, in any unit."""
    plain = [c for c in columns if c.key in means and not families(c.name, c.unit) and not c.is_command]
    plain = plain[:MOST_UNNAMED]
    changes = {c.key: grid.change(c.t, c.values) for c in plain}
    speeds = {
        c.key: np.abs(means[c.key])
        for c in columns
        if c.key in means and (not (said := families(c.name, c.unit)) or said & {"speed", "wheel"})
    }
    for a, b in itertools.combinations(plain, 2):
        way = np.hypot(changes[a.key], changes[b.key])
        others = [values for key, values in speeds.items() if key not in (a.key, b.key)]
        if a.topic == b.topic and any(_together(way, values) > SURE for values in others):
            yield a, b


def _together(a: FloatArray, b: FloatArray) -> float:
    """Correlation of two (n,) where both are known, without any lag; 0 where they say nothing."""
    known = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(known) < 50 or not (np.ptp(a[known]) > 0.0 and np.ptp(b[known]) > 0.0):
        return 0.0
    return float(np.corrcoef(a[known], b[known])[0, 1])


def _off_unit(path: Path, columns: Sequence[Column], rates: Sequence[FloatArray], grid: Grid) -> float:
    """How far a gyro's size is from a unit by the heading of a path, in logarithms up to 0.5; 0 without such a gyro.

    A pose that was reckoned from wheels and steering turns by another amount than the car where this slides.
    """
    told = headings(columns, path, None, grid)
    turn = _turn_of(told[0], grid) if told else path.turn
    found = []
    for rate in rates:
        match = grid.match(rate, turn)
        if abs(match.alike) > ALIKE and math.isfinite(match.ratio):
            found.append(min(abs(math.log(match.ratio)), abs(math.log(match.ratio * DEGREE))))
    return min(0.5, *found) if found else 0.0


def _turn_of(heading: Heading, grid: Grid) -> FloatArray:
    angle = np.unwrap(heading.column.values * (DEGREE if heading.degrees else 1.0))
    return grid.change(heading.column.t, angle)


def _reckoned(path: Path) -> bool:
    """Whether a position was integrated from the speed: it says nothing about the car that the speed does not."""
    said = set(words_of(path.x.topic)) | set(words_of(path.x.field))
    return path.derived or any(word.startswith("odom") for word in said)


def _position(x: Column, y: Column) -> bool:
    return all(not (said := families(c.name, c.unit)) or "position" in said for c in (x, y))


def _path(
    x: Column, y: Column, grid: Grid, others: Sequence[FloatArray], turns: Sequence[FloatArray]
) -> Path | None:  # fmt: skip
    unit = x.unit if x.unit == y.unit else ""
    if fix := _fix(x, y):
        unit = fix
        latitude = in_degrees(y.values, fix)
        east, north = _metres(in_degrees(x.values, fix), float(np.median(latitude))), _metres(latitude, 0.0)
    else:
        east, north = x.values, y.values
    te, tn = x.t, y.t
    dx, dy = grid.change(te, east), grid.change(tn, north)
    speed = np.hypot(dx, dy)
    if np.count_nonzero(np.isfinite(speed)) < 50:
        return None
    fast = float(np.nanpercentile(speed, 80))
    moving = speed > 0.3 * fast
    course = np.arctan2(grid.change(tn, north, COURSE_WINDOW), grid.change(te, east, COURSE_WINDOW))
    turn = np.where(moving, _turn(course, grid), np.nan)
    by_speed = [(grid.match(values, speed), values) for values in others]
    best, like = max(by_speed, key=lambda one: one[0].alike, default=(NOTHING, speed))
    by_turn = max((abs(grid.match(values, turn).alike) for values in (*others, *turns)), default=0.0)
    agreement = max(best.alike, 0.0) + by_turn
    metre = 1.0 if fix or not unit else getattr(find_unit(unit), "scale", 1.0)
    derived = best.alike > 0.99 and _fits(like, speed, moving, DERIVED_WAY / (metre * grid.window))
    told = max(best.alike, by_turn) > ALIKE
    return Path(x, y, unit, speed, course, turn, moving, agreement, derived) if told else None


def _metres(angle: FloatArray, latitude: float) -> FloatArray:
    """Way [m] of degrees (n,) along a circle of latitude, or of longitude at 0: on a sphere, 0.5 % off at most."""
    return np.asarray(np.radians(angle - angle[0]) * EARTH * math.cos(math.radians(latitude)))


def _fix(x: Column, y: Column) -> str:
    """How two columns are longitude and latitude: in degrees, in degrees and minutes of NMEA; "" if they are not."""
    said = set(words_of(x.name)), set(words_of(y.name))
    if not (said[0] & {"lon", "lng", "long", "longitude"} and said[1] & {"lat", "latitude"}):
        return ""
    if find_unit(x.unit or "deg") != find_unit("deg"):
        return ""
    if np.abs(y.values).max() <= 90.0 and np.abs(x.values).max() <= 180.0:
        return LONGITUDE
    minutes = all(float(np.max(np.abs(c.values) % 100.0)) < 60.0 for c in (x, y))
    return LONGITUDE_DDMM if minutes and np.abs(y.values).max() < 9000.0 and np.abs(x.values).max() < 18000.0 else ""


def _turn(course: FloatArray, grid: Grid) -> FloatArray:
    """Turn rate (n,) [rad/s] of a course (n,) [rad], over a window of the course."""
    rows = max(1, round(0.5 * COURSE_WINDOW / grid.step))
    found = np.full(len(course), np.nan)
    if len(course) > 2 * rows:
        step = course[2 * rows :] - course[: -2 * rows]
        found[rows:-rows] = np.arctan2(np.sin(step), np.cos(step)) / (2 * rows * grid.step)
    return found


def _fits(v: FloatArray, speed: FloatArray, moving: NDArray[np.bool_], most: float) -> bool:
    """Whether three in four of `speed` (n,) are `v` (n,) times one number, to DERIVED of it and to `most`, in its
    unit. Of fast cars a share alone would tell nothing: 1 cm is 0.1 % of the way in a window at 25 m/s."""
    at = moving & np.isfinite(v) & np.isfinite(speed) & (v != 0.0)
    if np.count_nonzero(at) < 50:
        return False
    ratio = speed[at] / v[at]
    apart = np.abs(ratio / np.median(ratio) - 1.0)
    return bool(np.percentile(apart, 75) < DERIVED and np.percentile(apart * speed[at], 75) < most)


def headings(columns: Sequence[Column], path: Path | None, rate: FloatArray | None, grid: Grid) -> list[Heading]:
    """Columns that turn with the path (or with a turn rate (n,) [rad/s], where there is none), the best first.

    By the path a heading is known with its unit, sign and zero; by a turn rate with unit and sign only.
    """
    found = []
    for column in columns:
        said = families(column.name, column.unit)
        if (said and "angle" not in said) or column.is_command:
            continue
        stated = find_unit(column.unit) if column.unit not in ("", QUATERNION) else None
        choices = (
            [False] if column.unit == QUATERNION else [False, True] if path is not None else degrees_by_wraps(column)
        )
        for degrees in choices:
            if stated is not None and (stated.si != "rad" or (stated.scale == 1.0) == degrees):
                continue
            one = _heading(column, degrees, path, rate, grid)
            if one is not None and (said or one.match.alike**2 > SURE**2):
                found.append(one)
    near = path.x.field.rpartition(".")[0] if path is not None else ""
    return sorted(found, key=lambda h: -(abs(h.match.alike) + h.spread + (h.column.field.rpartition(".")[0] == near)
                                         - (abs(h.offset) > 0.2)))  # fmt: skip


def wraps(column: Column) -> bool:
    """Whether the jumps of a heading tell its unit."""
    return len(degrees_by_wraps(column)) == 1


def degrees_by_wraps(column: Column) -> list[bool]:
    """Whether a heading is in degrees, by the turn that it jumps where it wraps; both are possible if it does not."""
    jump, span = float(np.max(np.abs(np.diff(column.values)))), float(np.ptp(column.values))
    turns = ((True, 360.0), (False, 2.0 * math.pi))
    return [degrees for degrees, turn in turns if 0.84 * turn < jump <= span < 1.01 * turn] or [
        False,
        True,
    ]


def _heading(
    column: Column, degrees: bool, path: Path | None, rate: FloatArray | None, grid: Grid
) -> Heading | None:  # fmt: skip
    angle = np.unwrap(column.values * (DEGREE if degrees else 1.0))
    turn = grid.change(column.t, angle)
    if path is None:
        if rate is None:
            return None
        match = grid.match(turn, rate)
        if abs(match.alike) < ALIKE or not 0.5 < match.ratio < 2.0:
            return None
        return Heading(column, degrees, match.sign, 0.0, 0.0, match)
    turn = np.where(path.moving, turn, np.nan)
    match = grid.match(turn, path.turn)
    if abs(match.alike) < 0.7 or not 0.5 < match.ratio < 2.0:
        return None
    at = path.moving & np.isfinite(path.course)
    off = np.exp(1j * (path.course - match.sign * grid.at(column.t, angle)))[at]
    off = off[np.isfinite(off)]
    mean = complex(np.mean(off)) if len(off) else 0j
    if abs(mean) < ONE_ANGLE:
        return None
    return Heading(column, degrees, match.sign, math.atan2(mean.imag, mean.real), abs(mean), match)


def best_match(
    columns: Sequence[Column], family: str, signal: str, target: FloatArray, grid: Grid, *, signed: bool = True
) -> list[tuple[Column, Match]]:
    """Columns of a family, or without a telling name, that are alike to `target` (n,) in any unit, the best first.

    A column that has the signal's usual name goes before one that is as alike. signed: the size of the column counts
    with its sign.
    """
    found = []
    for column in columns:
        said = families(column.name, column.unit)
        if family == "rate" and "angle" in said and not column.unit:
            said = {"rate"}  # `ESP yaw` may be the rate
        if column.unit == QUATERNION or column.is_command or (said and family not in said):
            continue
        values = grid.mean(column)
        match = grid.match(values if signed else np.abs(values), target)
        if abs(match.alike) >= (ALIKE if said else SURE) and math.isfinite(match.ratio):
            usual = 0.1 * (canonical(column.name) == signal) + 0.05 * bool(said)
            found.append((abs(match.alike) + usual, column, match))
    return [(column, match) for _, column, match in sorted(found, key=lambda one: -one[0])]
