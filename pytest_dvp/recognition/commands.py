"""Steering, pedals and wanted values of a foreign log, by what the car does after them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping import QUATERNION
from pytest_dvp.logs.units import find_unit
from pytest_dvp.recognition.columns import Column
from pytest_dvp.recognition.grid import Grid, Match
from pytest_dvp.recognition.recognised import Recognised
from pytest_dvp.recognition.words import families, words_of

FOLLOWS = 0.6  # correlation of turn rate and steering times speed, from which a named column is the steering
WIDEST = 1.0  # rad of a road wheel: no steering goes further
NORMALISED = 1.02  # largest size of a command from -1 to 1
DEGREES = 180.0 / math.pi
PLAIN = 1.4  # times the road wheel by the curvature: understeer, slipping tyres and a ratio that is not the nominal one
RATIOS = (8.0, 30.0)  # of a steering gear, from the quickest car to a lorry
FIRM = 0.95  # correlation with the turn rate, from which an estimated ratio or scale of the steering is decided
_PRESSURE = {"pressure", "press", "pres", "druck"}  # words of a column that is a pressure, whatever pedal it belongs to
_PERCENT = {"%", "percent", "percentage", "pct"}  # units, and words of a column, of a share of the greatest angle
LEAD = 0.05  # s by which a wanted speed comes before the measured one


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """What is known of the car: v (n,) [m/s] and turn (n,) [rad/s] on the grid, None if unknown; wheelbase [m];
    measured: the columns that these are from; obeyed (n,): where the car follows its commands, None: everywhere."""

    grid: Grid
    v: FloatArray | None
    turn: FloatArray | None
    wheelbase: float | None
    measured: tuple[Column, ...] = ()
    obeyed: NDArray[np.bool_] | None = None

    def mean(self, column: Column) -> FloatArray:
        """A column (n,) on the grid, in its unit; of a command NaN where somebody else drove."""
        values = self.grid.mean(column)
        return values if self.obeyed is None or not column.is_command else np.where(self.obeyed, values, np.nan)

    @property
    def along(self) -> FloatArray | None:
        """dv/dt (n,) [m/s^2]."""
        return None if self.v is None else self.grid.slope(self.v)


def wishes(columns: Sequence[Column], motion: Motion) -> list[Recognised]:
    """A wanted speed and a wanted acceleration."""
    found = []
    if motion.v is not None:
        for column in columns:
            said = families(column.name, column.unit)
            if "speed" not in said and not (column.is_command and not said):
                continue
            match = motion.grid.match(motion.mean(column), motion.v)
            asked = column.is_command or (match.lag < -LEAD and match.alike > FOLLOWS)
            if not asked or match.alike < FOLLOWS:
                continue
            unit, sure = _nearest(match.ratio, (("m/s", 1.0), ("km/h", 3.6)), column.unit)
            text = f"{match.ratio:.3g} times v, {-match.lag:.2f} s before it (correlation {match.alike:.2f})"
            doubt = "" if sure else "km/h or m/s: the car may not reach what is asked"
            found.append(Recognised("speed_cmd", column, unit, evidence=(text,), decided=sure, rival=doubt))
            break
    along = motion.along
    if along is not None:
        for column in columns:
            if not column.is_command or "accel" not in families(column.name, column.unit):
                continue
            match = motion.grid.match(along, motion.mean(column))
            if match.alike < FOLLOWS:
                continue
            unit, sure = _nearest(1.0 / match.ratio, (("m/s^2", 1.0), ("g", 1 / 9.80665)), column.unit)
            text = f"dv/dt is {match.ratio:.3g} times it, {match.lag:.2f} s after it (correlation {match.alike:.2f})"
            found.append(Recognised("accel_cmd", column, unit, evidence=(text,), decided=sure, rival=""))
            break
    return found


def _nearest(ratio: float, units: Sequence[tuple[str, float]], stated: str) -> tuple[str, bool]:
    """The unit whose factor is nearest to a ratio, and whether it is within a factor of 1.5."""
    if stated:
        return stated, True
    unit, factor = min(units, key=lambda one: abs(math.log(max(ratio, 1e-9) / one[1])))
    return unit, abs(math.log(max(ratio, 1e-9) / factor)) < math.log(1.5)


def steering(columns: Sequence[Column], motion: Motion, commands: Sequence[Column]) -> list[Recognised]:
    """Measured and commanded steering. commands: columns that are known to be wanted values; what was written with one
    of them is wanted, too."""
    if motion.v is None or motion.turn is None:
        return []
    found: dict[str, tuple[float, Recognised]] = {}
    fast = moving_speed(motion)
    assert fast is not None
    for column in columns:
        said = families(column.name, column.unit)
        if column.unit == QUATERNION or (said and "steer" not in said):
            continue
        values = motion.mean(column)
        match = motion.grid.match(np.where(np.isfinite(fast), values * fast, np.nan), motion.turn)
        if abs(match.alike) < (FOLLOWS if said else 0.93) or not math.isfinite(match.ratio):
            continue
        apart = not any(_same_stamps(column, other) for other in motion.measured)
        wanted = column.is_command or (apart and any(_same_stamps(column, other) for other in commands))
        one = _scaled(column, match, wanted, motion.wheelbase)
        name = "steer_cmd" if one.name.startswith("steer_cmd") else "steer"
        rank = abs(match.alike) + 0.1 * (canonical(column.name) == name) + 0.1 * bool(said)
        if name not in found or rank > found[name][0]:
            found[name] = (rank, one)
    return [one for _, one in found.values()]


def moving_speed(motion: Motion) -> FloatArray | None:
    """The speed (n,) [m/s], NaN where the car stands or creeps; None if it is not known."""
    if motion.v is None:
        return None
    least = max(0.3, 0.2 * float(np.nanpercentile(np.abs(motion.v), 90)))
    return np.where(np.abs(motion.v) > least, motion.v, np.nan)


def _same_stamps(a: Column, b: Column) -> bool:
    """Whether two columns of one file were written together, while others of the file were not."""
    return a.topic == b.topic and len(a.t) == len(b.t) and bool(np.array_equal(a.t, b.t))


def _scaled(column: Column, match: Match, wanted: bool, wheelbase: float | None) -> Recognised:
    """Unit, ratio or scale of a steering column: `match` holds it times speed against the turn rate."""
    name = "steer_cmd" if wanted else "steer"
    size = float(np.percentile(np.abs(column.values), 99.5))
    sign = match.sign
    text = f"follows the turn rate (correlation {abs(match.alike):.2f})" + (", turned round" if sign < 0.0 else "")
    hits = np.mean(np.abs(np.abs(column.values) - 1.0) < 0.02)
    if column.unit in _PERCENT or _PERCENT & set(words_of(column.name)):
        return _percentage(name, column, match, text, wheelbase)
    if not wheelbase:
        unit = column.unit or ("deg" if size > WIDEST * 1.6 else "rad")
        return Recognised(name, column, unit, sign=sign, evidence=(text,), decided=bool(column.unit) and size < WIDEST,
                          rival="" if column.unit else "give --wheelbase: it tells unit and ratio")  # fmt: skip
    per_radian = match.ratio / wheelbase
    text += f"; {per_radian:.3g} for 1 rad at the road wheel by the wheelbase"
    known = find_unit(column.unit) if column.unit else None
    if known is not None and known.si == "rad":
        gear = per_radian * known.scale
        if 1.0 / 2.0 < gear < 2.0:  # the file states an angle: what is more is for the diagnosis
            return Recognised(name, column, column.unit, sign=sign, evidence=(text,))
        if RATIOS[0] < gear < RATIOS[1]:
            return _hand_wheel(name, column, column.unit, match, gear, text)
    for unit, factor in (("rad", 1.0), ("deg", DEGREES)):
        fits = 1.0 / PLAIN < per_radian / factor < PLAIN
        if fits and not (unit == "rad" and hits > 0.02 and size <= NORMALISED):
            return Recognised(name, column, unit, sign=sign, evidence=(text,))
    if size <= NORMALISED:
        said = f"a command from -1 to 1; {1.0 / per_radian:.3g} rad for 1 by the wheelbase, which a diagnosis fits"
        return Recognised("steer_cmd_norm", column, "-", sign=sign, evidence=(text, said))
    for unit, factor in (("deg", DEGREES), ("rad", 1.0)):
        gear = per_radian / factor
        if RATIOS[0] < gear < RATIOS[1]:
            return _hand_wheel(name, column, unit, match, gear, text)
    return Recognised(name, column, "rad", sign=sign, scale=float(f"{1.0 / per_radian:.3g}"), decided=False,
                      evidence=(text,), rival="no usual unit: its scale is an estimate")  # fmt: skip


def _percentage(name: str, column: Column, match: Match, text: str, wheelbase: float | None) -> Recognised:
    """Steering in percent of the greatest angle, as Apollo's: a command is a share, whose scale a diagnosis fits; what
    was measured needs the car's own angle, and has an estimate of it."""
    full = 100.0 * wheelbase / match.ratio if wheelbase else None
    told = (text,) if full is None else (text, f"100 % are {full:.3g} rad at the road wheel by the wheelbase")
    if name == "steer_cmd":
        return Recognised("steer_cmd_norm", column, "%", sign=match.sign, evidence=told)
    rival = "percent: scale is the greatest angle of the road wheel [rad] / 100" + (
        "" if full else "; give --wheelbase"
    )
    scale = 0.01 if full is None else float(f"{0.01 * full:.3g}")
    return Recognised(name, column, "rad", sign=match.sign, scale=scale, decided=False, evidence=told, rival=rival)


def _hand_wheel(name: str, column: Column, unit: str, match: Match, gear: float, text: str) -> Recognised:
    """A steering column behind a gear, whose ratio is known as well as the column is alike to the turn rate."""
    told = (text, "the hand wheel: its ratio is an estimate, put in the car's")
    firm = abs(match.alike) > FIRM
    rival = "" if firm else "it follows the turn rate too loosely for its ratio"
    return Recognised(
        name, column, unit, sign=match.sign, ratio=round(gear, 1), evidence=told, decided=firm, rival=rival
    )


def pedals(columns: Sequence[Column], motion: Motion) -> list[Recognised]:
    """Throttle and brake by their names; a brake may be a pressure, which without a unit is no percentage."""
    found: dict[str, Recognised] = {}
    for column in sorted(columns, key=lambda one: not one.is_command):  # a car may report its pedals as well
        said = set(words_of(column.name))
        if "pedal" not in families(column.name, column.unit) or len(np.unique(column.values)) < 3:
            continue
        brake = bool(said & {"brake", "brk", "bremse"})
        unit = find_unit(column.unit) if column.unit else None
        if unit is not None and unit.si == "Pa":
            one = Recognised("brake_pressure", column, column.unit, evidence=("the file states the unit",))
            found.setdefault("brake_pressure", one)
            continue
        if unit is not None and unit.si != "-":
            continue
        largest = float(column.values.max())
        if brake and unit is None and said & _PRESSURE:
            text = f"a pressure by its name; goes up to {largest:.3g}"
            rival = "MPa, kPa or psi: put the unit in"
            one = Recognised("brake_pressure", column, "bar", evidence=(text,), decided=False, rival=rival)
            found.setdefault("brake_pressure", one)
            continue
        shown = column.unit or ("%" if 1.5 < largest <= 101.0 else "-")
        text = f"goes up to {largest:.3g}"
        if not column.unit:
            text += f", so it is {'percent' if shown == '%' else 'a share'}"
        name = "brake_cmd" if brake else "throttle_cmd"
        sure = bool(column.unit) or (0.05 < largest <= 1.0 or 1.5 < largest <= 101.0)
        doubt = "" if sure else "no share and no percentage: its scale is unknown"
        found.setdefault(name, Recognised(name, column, shown, evidence=(text,), decided=sure, rival=doubt))
    return list(found.values())
