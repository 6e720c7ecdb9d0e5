"""What each column of a foreign log is: role by role, each held against what is known already.

Position and heading first, then turn rate and speed, accelerations, steering and pedals. Units are chosen for all of
them at once. The wheelbase tells the unit of the steering and, if nothing else does, that of the speed.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection, Sequence

import numpy as np

from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping import LATITUDE, LONGITUDE, QUATERNION
from pytest_dvp.logs.units import find_unit
from pytest_dvp.recognition.by_products import speed_and_turn
from pytest_dvp.recognition.columns import Column, pairs_of, together
from pytest_dvp.recognition.commands import Motion, pedals, steering, wishes
from pytest_dvp.recognition.drive_motion import (
    DEGREE,
    SURE,
    Heading,
    Path,
    best_match,
    degrees_by_wraps,
    headings,
    paths,
    wraps,
)
from pytest_dvp.recognition.grid import Grid, Match, grid_of
from pytest_dvp.recognition.recognised import Recognised, Recognition, otherwise_named
from pytest_dvp.recognition.unit_choice import UNITS, Choice, Relation, choose
from pytest_dvp.recognition.who_drives import Mode, driver_of
from pytest_dvp.recognition.words import Family, families, words_of

G = 9.80665  # m/s^2, CGPM 1901
FASTEST = 80.0  # m/s, and
WIDEST = 0.6  # rad at the road wheel: hardly a car goes further, but its sensors may be noisy
HAND_WHEEL = 2.5
"""The most that the steering's relation costs: below CLEAR, for a hand wheel of unknown ratio breaks the relation."""
FIRM = 0.95  # correlation from which a column without a telling name can be decided, and
APART = 0.02  # by which every other column must be less alike: turn rate and steering are 0.995 alike on a smooth drive
NEAR_UNIT = 0.25  # of the logarithm of its size: accelerometers stand elsewhere in the car and feel its roll
OFFSET = 0.15  # rad between course and heading, from which it is told: the doctor's
_FAMILY: dict[str, set[Family]] = {
    "yaw": {"angle"}, "v": {"speed", "wheel"}, "yaw_rate": {"rate", "angle"},
    "ax": {"accel"}, "ay": {"accel"}, "steer": {"steer"}, "steer_cmd": {"steer"}, "steer_cmd_norm": {"steer"},
}  # fmt: skip
"""What the name of a column must be able to mean for a signal; positions are known by their names or by a heading."""
_SPEED, _FORCE, _TURN, _STEER = 0.07, 0.2, 0.15, 0.4
"""Sigmas of logarithms: wheels and clocks are off by some percent; accelerometers stand elsewhere in the car and feel
its roll; a steering ratio or understeer changes the curvature by as much as the last."""


def recognise(columns: Sequence[Column], wheelbase: float | None = None, modes: Sequence[Mode] = ()) -> Recognition:
    """The signals of a log by its own redundancy. wheelbase [m]; None: the steering's scale stays open. modes: fields
    that may tell who drives: commands are held against the motion where the car obeyed them."""
    grid = grid_of(columns)
    if grid is None:
        return Recognition((), ("the drive is too short to tell anything",))
    return _Search(columns, grid, wheelbase, modes).run()


class _Search:
    def __init__(
        self, columns: Sequence[Column], grid: Grid, wheelbase: float | None, modes: Sequence[Mode]
    ) -> None:  # fmt: skip
        self.columns, self.grid, self.wheelbase, self.modes = list(columns), grid, wheelbase, modes
        self.free = list(columns)
        self.taken: dict[str, tuple[Column, Match | None]] = {}
        self.relations: list[Relation] = []
        self.evidence: dict[str, list[str]] = {}
        self.remarks: list[str] = []
        self.path: Path | None = None
        self.heading: Heading | None = None
        self.turn: FloatArray | None = None  # [rad/s], or as a column gives it
        self.turn_name = ""
        self.speed: FloatArray | None = None  # as column v gives it, else [units of position/s]
        self.speed_name = ""
        self.unit_of_way = "m"

    def run(self) -> Recognition:
        self._positions()
        self._turning()
        self._speed()
        if self.path is None:
            self._by_products()
        self._forces()
        found: list[Recognised] = []
        choices = self._units()
        self.unit_of_way = choices["x"].unit if "x" in choices else "m"
        found += self._motion(choices)
        found += self._controls(choices)
        used = {one.column.key for one in found}
        remarks = (*self.remarks, *otherwise_named(found))
        return Recognition(tuple(self._as_firm_as_known(one, used) for one in found), remarks)

    def _as_firm_as_known(self, one: Recognised, used: Collection[tuple[str, str]]) -> Recognised:
        """What a column's name does not say is decided by geometry: a path that a heading goes with, and for what is
        nearly proportional to its turning (turn rate, lateral acceleration, steering) if it stands out from the rest.

        used: keys of all columns that are a signal.
        """
        family = _FAMILY.get(one.name)
        if family is None or one.column.way or family & families(one.column.name, one.column.unit):
            return one
        geometry = self.path is not None and self.heading is not None
        if geometry and (one.name in ("yaw", "v") or self._stands_out(one, used)):
            return one
        rival = " or ".join(filter(None, [one.rival, "something else: its name does not say what it is"]))
        return dataclasses.replace(one, decided=False, rival=rival)

    def _stands_out(self, one: Recognised, used: Collection[tuple[str, str]]) -> bool:
        """Whether no column that is not yet a signal could be this one as well."""
        own = self._likeness(one.name, one.column)
        rest = [c for c in self.columns if c.key not in used and c.unit != QUATERNION]
        return own > FIRM and all(self._likeness(one.name, c) < own - APART for c in rest)

    def _likeness(self, name: str, column: Column) -> float:
        """How alike a column is to what a signal has to be by the path; 0 if its size is that of no unit."""
        assert self.path is not None
        v, turn = self.path.speed, self.turn
        if turn is None:
            return 0.0
        values = self.grid.mean(column)
        if name.startswith("steer"):
            return abs(self.grid.match(values * v, turn).alike)
        metres = _scale(self.unit_of_way)
        kind, target = {
            "yaw_rate": ("rad/s", turn),
            "ax": ("m/s^2", metres * self.grid.slope(v)),
            "ay": ("m/s^2", metres * v * turn),
        }[name]
        match = self.grid.match(values, target)
        sizes = [abs(math.log(match.ratio * _scale(unit))) for unit, _ in UNITS[kind] if math.isfinite(match.ratio)]
        return abs(match.alike) if min(sizes, default=math.inf) < NEAR_UNIT else 0.0

    def take(self, name: str, column: Column, match: Match | None = None) -> None:
        self.taken[name] = (column, match)
        self.free = [c for c in self.free if c is not column]

    def tell(self, name: str, text: str) -> None:
        self.evidence.setdefault(name, []).append(text)

    def _positions(self) -> None:
        found = paths(self.free, self.grid)
        if not found:
            return
        self.path = found[0]
        near = next((p for p in found if p.is_fix and p is not self.path), None)
        if near is not None:  # degrees tell the metres of the other pair
            match = self.grid.match(self.path.speed, near.speed)
            if match.alike > 0.9:
                text = "{ratio:.3g} times the way by longitude and latitude"
                self.relations.append(Relation(text, match.ratio, 0.03, {"x": -1.0}))
        self.take("x", self.path.x)
        self.take("y", self.path.y)
        for other in found[1:]:
            self.free = [c for c in self.free if c is not other.x and c is not other.y]
            self.remarks.append(f"{other.x.field}, {other.y.field} are a position, too; the other pair was taken")
        if self.path.derived:
            self.remarks.append(
                f"{self.path.x.field}, {self.path.y.field} fit the speed so well that they were integrated from it, or "
                "that one filter made both: they say little of the car that the speed does not"
            )
        self.speed, self.speed_name = self.path.speed, "x"

    def _turning(self) -> None:
        """The heading by the path, and the turn rate by the heading or the path."""
        grid = self.grid
        if self.path is not None:
            told = headings(self.free, self.path, None, grid)
            if told:
                self.heading = told[0]
                self.take("yaw", self.heading.column)
            self.turn, self.turn_name = self.path.turn, "the turn of the path"
            if self.heading is not None and self.heading.match.sign > 0.0:
                angle = np.unwrap(self.heading.column.values * (DEGREE if self.heading.degrees else 1.0))
                self.turn, self.turn_name = grid.change(self.heading.column.t, angle), "d(yaw)/dt"
        if self.turn is not None:
            matches = [one for one in best_match(self.free, "rate", "yaw_rate", self.turn, grid) if _is_rate(*one)]
            if matches:
                self.take("yaw_rate", *matches[0])
                match = matches[0][1]
                self.relations.append(_relation(self.turn_name, match, _TURN, {"yaw_rate": -1.0}))
            return
        named = [c for c in self.free if "yaw_rate" in _usual(c)]
        if named:
            self._heading_by_rate(named[0])
        else:
            self._turning_by_heading()

    def _turning_by_heading(self) -> None:
        """Without positions and turn rate: a column that is called a heading, if its jumps tell its unit."""
        for column in (c for c in self.free if "angle" in families(c.name, c.unit) and wraps(c)):
            degrees = degrees_by_wraps(column)[0]
            angle = np.unwrap(column.values * (DEGREE if degrees else 1.0))
            self.heading = Heading(column, degrees, 1.0, 0.0, 0.0, Match(1.0, 0.0, 1.0))
            self.take("yaw", column)
            self.turn, self.turn_name = self.grid.change(column.t, angle), "d(yaw)/dt"
            return

    def _heading_by_rate(self, column: Column) -> None:
        """Without positions: a heading that wraps tells the unit of the turn rate."""
        rate = self.grid.mean(column)
        for unit, scale in (("deg/s", DEGREE), ("rad/s", 1.0)):
            if column.unit and find_unit(column.unit) != find_unit(unit):
                continue
            told = [h for h in headings(self.free, None, rate * scale, self.grid) if column.unit or wraps(h.column)]
            if told:
                self.heading = told[0]
                self.take("yaw", self.heading.column)
                self.turn, self.turn_name = rate * scale * told[0].match.sign, "yaw rate"
                match = dataclasses.replace(told[0].match, ratio=1.0 / (scale * told[0].match.ratio))
                self.take("yaw_rate", column, match)
                self.relations.append(_relation("d(yaw)/dt", match, _TURN, {"yaw_rate": -1.0}))
                return

    def _speed(self) -> None:
        grid = self.grid
        if self.path is not None:
            matches = best_match(self.free, "speed", "v", self.path.speed, grid)
            plain = [one for one in matches if not _wanted(one[0], one[1])] or matches
            alike = plain[0][1].alike if plain else 0.0
            plain = self._speed_of_several(alike + 0.03) or plain
            if not plain and not self.path.is_fix:
                rate = together("rate of", (self.path.x, self.path.y))
                plain = [(rate, Match(1.0, 0.0, 1.0))] if rate is not None else []
            if plain:
                column, match = plain[0]
                self.take("v", column, match)
                self.speed, self.speed_name = grid.mean(column), "x" if column.way == "rate of" else "v"
                if column.way == "rate of":
                    self.remarks.append("v is the rate of the position: no column measures the speed")
                    return
                powers = {"v": -1.0} if self.path.is_fix else {"v": -1.0, "x": 1.0}
                self.relations.append(_relation("the way between positions over time", match, _SPEED, powers))
            return

    def _speed_of_several(self, least: float) -> list[tuple[Column, Match]]:
        """A speed that two columns make, wheels of an axle or parts of a velocity, if it is more alike than `least`."""
        assert self.path is not None
        wheels = [c for c in self.free if families(c.name, c.unit) == {"wheel"}]
        sides = [(a, b) for a in wheels for b in wheels if _other_side(a.field) == b.field]
        rear = sorted(sides, key=lambda pair: not set(words_of(pair[0].field)) & {"rear", "rl", "r", "back"})
        parts = [pair for pair in pairs_of(self.free) if not pair[0].is_command]
        tried = [together("mean of", pair) for pair in rear] + [together("norm of", pair) for pair in parts]
        for column in tried:
            if column is not None:
                match = self.grid.match(self.grid.mean(column), self.path.speed)
                if match.alike > max(SURE, least) and math.isfinite(match.ratio):
                    return [(column, match)]
        return []

    def _by_products(self) -> None:
        """Without positions: the speed and turn rate whose products and changes other columns are."""
        speed, rate = speed_and_turn(self.free, self.grid, with_rate=self.turn is None)
        if speed is not None:
            self.take("v", speed)
            self.speed, self.speed_name = self.grid.mean(speed), "v"
        if rate is not None:
            self.take("yaw_rate", rate)
            self.turn, self.turn_name = self.grid.mean(rate), "yaw_rate"

    def _forces(self) -> None:
        """Accelerations: what goes with dv/dt, and what goes with speed times turn rate, whatever they are called."""
        if self.speed is None:
            return
        grid = self.grid
        along = grid.slope(self.speed)
        unit = {self.speed_name: 1.0} if not self._in_metres() else {}
        targets = {"ax": (along, "dv/dt", unit)}
        if self.turn is not None:
            rate = {"yaw_rate": 1.0} if self.turn_name == "yaw_rate" else {}
            targets["ay"] = (self.speed * self.turn, "speed times turn rate", {**unit, **rate})
        found = []
        for name, (target, text, powers) in targets.items():
            for column, match in best_match(self.free, "accel", name, target, grid):
                found.append((abs(match.alike) + 0.1 * (name in _usual(column)), name, column, match, text, powers))
        for _, name, column, match, text, powers in sorted(found, key=lambda one: -one[0]):
            if name not in self.taken and any(c is column for c in self.free):
                self.take(name, column, match)
                self.relations.append(_relation(text, match, _FORCE, {name: -1.0, **powers}))
        self._gravity()

    def _gravity(self) -> None:
        """A vertical accelerometer beside ax or ay shows 9.81 m/s^2 or 1 g."""
        for name in ("ax", "ay"):
            if name not in self.taken:
                continue
            column = self.taken[name][0]
            for other in self.columns:
                if other.topic == column.topic and other.field == _with_z(column.field):
                    size = abs(float(np.median(other.values)))
                    text = f"{other.field} shows {{ratio:.3g}} m/s^2, which is gravity"
                    self.relations.append(Relation(text, size, 0.1, {name: -1.0}, G))

    def _in_metres(self) -> bool:
        return self.speed_name == "x" and self.path is not None and self.path.is_fix

    def _units(self) -> dict[str, Choice]:
        kinds = {"v": "m/s", "ax": "m/s^2", "ay": "m/s^2", "yaw_rate": "rad/s"}
        kinds = {n: unit for n, unit in kinds.items() if n in self.taken and self.taken[n][0].way != "rate of"}
        if self.path is not None and not self.path.is_fix:
            kinds["x"] = "m"
        stated = {name: self.taken[name][0].unit for name in kinds if self.taken[name][0].unit}
        relations = list(self.relations)
        relations += [*self._steering_relation(kinds, stated), *self._limits(kinds)]
        self.relations += [r for r in relations if r.upper]
        return choose(kinds, stated, relations)

    def _limits(self, kinds: dict[str, str]) -> list[Relation]:
        """No car is faster, turns harder or steers further than so; of positions this excludes many a unit."""
        if self.speed is None or self.speed_name not in kinds:
            return []
        own = self.speed_name
        fast = float(np.nanpercentile(np.abs(self.speed), 98))
        found = [Relation("{ratio:.3g} m/s at most", fast, 0.3, {own: -1.0}, FASTEST, upper=True)]
        if self.turn is not None and self.turn_name != "yaw_rate" and self.wheelbase:
            going = np.where(np.abs(self.speed) > 0.3 * fast, np.abs(self.speed), np.nan)
            bend = float(np.nanpercentile(np.abs(self.turn) / going, 98)) * self.wheelbase
            text = "{ratio:.3g} rad at the road wheel in its sharpest turn, by the wheelbase"
            found.append(Relation(text, bend, 0.2, {own: 1.0}, WIDEST, upper=True))
        return found

    def _steering_relation(self, kinds: dict[str, str], stated: dict[str, str]) -> list[Relation]:
        """The road-wheel angle by the wheelbase: it ties the speed to metres where nothing else does."""
        named = [c for c in self.free if {"steer", "steer_cmd"} & _usual(c)]
        if not named or self._in_metres() or self.turn is None or self.speed is None or not self.wheelbase:
            return []
        column = named[0]
        match = self.grid.match(self.grid.mean(column) * self.speed, self.turn)
        if abs(match.alike) < 0.8:
            return []
        kinds["steer"] = "rad"
        if column.unit:
            stated["steer"] = column.unit
        powers = {"steer": -1.0, self.speed_name: -1.0}
        if self.turn_name == "yaw_rate":
            powers["yaw_rate"] = 1.0
        told = _relation("turn rate over speed", match, _STEER, powers, self.wheelbase)
        return [dataclasses.replace(told, far=HAND_WHEEL)]

    def _motion(self, choices: dict[str, Choice]) -> list[Recognised]:
        found = []
        texts: dict[str, list[str]] = {}
        for relation in self.relations:
            own = next((name for name, power in relation.powers.items() if power < 0.0), next(iter(relation.powers)))
            text = relation.text.format(ratio=_in_units(relation, choices))
            for name in relation.powers:
                texts.setdefault(name, []).append(text if name == own else f"{own} is {text}")
        if self.path is not None:
            for name in ("x", "y"):
                column = self.taken[name][0]
                if self.path.is_fix:
                    unit = self.path.unit if name == "x" else self.path.unit.replace(LONGITUDE, LATITUDE)
                    told = "degrees by name and range" + (
                        ", with minutes as NMEA writes them" if "ddmm" in unit else ""
                    )
                    found.append(Recognised(name, column, unit, evidence=(told,)))
                    continue
                choice = choices["x"]
                found.append(Recognised(name, column, choice.unit, evidence=_said(column, texts.get("x", [])),
                                        decided=choice.decided, rival=choice.rival))  # fmt: skip
        if self.heading is None and self.turn_name == "yaw_rate" and self.turn is not None:
            rate = choices["yaw_rate"]
            turns = headings(self.free, None, self.turn * _scale(rate.unit), self.grid) if rate.decided else []
            if turns:
                self.heading = turns[0]
                self.take("yaw", turns[0].column)
        if self.heading is not None:
            found.append(self._yaw(self.heading))
        for name in ("v", "yaw_rate", "ax", "ay"):
            if name not in self.taken:
                continue
            column, match = self.taken[name]
            choice = choices["x" if column.way == "rate of" else name]
            sign = match.sign if match is not None else 1.0
            evidence = _said(column, texts.get(name, []), match)
            found.append(Recognised(name, column, choice.unit, sign=sign, evidence=evidence, decided=choice.decided,
                                    rival=choice.rival))  # fmt: skip
        return found

    def _yaw(self, heading: Heading) -> Recognised:
        column = heading.column
        unit = column.unit if column.unit else "deg" if heading.degrees else "rad"
        by = "the path" if self.path is not None else "the yaw rate"
        alike = f"({heading.match.ratio:.2f} times, correlation {abs(heading.match.alike):.2f})"
        text = [f"turns with {by} {alike}"]
        if self.path is None and "yaw_rate" not in self.taken:
            text = [f"jumps by a turn of {'360' if heading.degrees else '2 pi'} where it wraps"]
        sign, offset = heading.sign, 0.0
        if self.path is not None:
            text.append(f"course - yaw = {heading.offset:.2f} rad" if sign > 0 else "it counts clockwise")
            if abs(heading.offset) > OFFSET or sign < 0:
                offset = heading.offset
        frame = "flu"
        if sign < 0.0 and abs(offset - 0.5 * math.pi) < OFFSET:
            sign, offset, frame = 1.0, 0.0, "ned"
            text.append("a compass heading")
        return Recognised("yaw", column, unit, sign=sign, offset=round(offset, 4), frame=frame, evidence=tuple(text))

    def _controls(self, choices: dict[str, Choice]) -> list[Recognised]:
        """Wanted values, steering and pedals, by the motion in SI units."""
        v, turn = self.speed, self.turn
        unsure = []
        if v is not None and not self._in_metres():
            v = v * _scale(choices[self.speed_name].unit)
            unsure += [] if choices[self.speed_name].decided else ["v"]
        if turn is not None and self.turn_name == "yaw_rate":
            turn = turn * _scale(choices["yaw_rate"].unit)
            unsure += [] if choices["yaw_rate"].decided else ["yaw_rate"]
        measured = tuple(column for column, _ in self.taken.values())
        motion = Motion(self.grid, v, turn, self.wheelbase, measured)
        driver = driver_of(self.free, self.modes, motion)
        if driver is not None:
            motion = dataclasses.replace(motion, obeyed=driver.obeyed)
        found = wishes(self.free, motion)
        keys = {one.column.key for one in found}
        rest = [c for c in self.free if c.key not in keys]
        steers = steering(rest, motion, [one.column for one in found])
        if unsure:  # its scale was measured in units that are themselves left open
            doubt = f"it follows {' and '.join(unsure)}, whose unit is not decided"
            steers = [s if s.column.unit else dataclasses.replace(s, decided=False, rival=doubt) for s in steers]
        found += steers
        keys |= {one.column.key for one in found}
        found += pedals([c for c in rest if c.key not in keys], motion)
        return [*found, driver.signal] if driver is not None else found


def _scale(unit: str) -> float:
    known = find_unit(unit)
    return known.scale if known is not None else 1.0


def _in_units(relation: Relation, choices: dict[str, Choice]) -> float:
    """The ratio of a relation in SI units, with the units that were chosen: 1 is what is to be expected, not 0.102."""
    scales = [_scale(choices[name].unit) ** power for name, power in relation.powers.items() if name in choices]
    return float(relation.ratio / math.prod(scales))


def _relation(
    text: str, match: Match, sigma: float, powers: dict[str, float], constant: float = 1.0
) -> Relation:  # fmt: skip
    said = f"{{ratio:.3g}} times {text} (correlation {abs(match.alike):.2f})"
    return Relation(said, match.ratio, sigma, powers, constant)


def _said(column: Column, texts: Sequence[str], match: Match | None = None) -> tuple[str, ...]:
    found = ["the file states the unit"] if column.unit and column.unit != QUATERNION else []
    found += list(texts)[:2]
    if match is not None and match.sign < 0.0:
        found.append("turned round")
    return tuple(found)


def _usual(column: Column) -> set[str]:
    """Signals that the column's name is usual for."""
    name = canonical(column.name)
    said = set(words_of(column.name))
    return {name} | ({"yaw_rate"} if said & {"gyro", "yawrate"} or {"yaw", "rate"} <= said else set())


def _is_rate(column: Column, match: Match) -> bool:
    """Whether the size of a turn rate is that of a unit: a steering column turns with the car, too."""
    units = [column.unit] if column.unit else [unit for unit, _ in UNITS["rad/s"]]
    return any(abs(math.log(match.ratio * _scale(unit))) < 3.0 * _TURN for unit in units)


def _wanted(column: Column, match: Match) -> bool:
    """True for a speed that comes before the car's: it was asked for."""
    return column.is_command or match.lag < -0.1


def _other_side(field: str) -> str:
    """The name of the right wheel beside one of the left."""
    for left, right in (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")):
        if left in field:
            return field.replace(left, right)
    found = re.sub(r"([fFrR])([lL])(?![a-z])", lambda m: m[1] + ("R" if m[2] == "L" else "r"), field)
    return found if found != field else ""


def _with_z(field: str) -> str:
    """The name of the vertical column beside one of x or y."""
    places = list(re.finditer(r"[xyXY](?![a-z])", field))
    if not places:
        return ""
    at = places[-1]
    return field[: at.start()] + ("Z" if at[0].isupper() else "z") + field[at.end() :]
