"""A term of a law: where it acts on the car, of which factors it is made, and its coefficient."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from math import prod
from typing import Literal

from pytest_dvp.gap.discover.factors import FACTORS, NUMBER, THRESHOLD, Unit, unit_text

Filter = Literal["", "lag", "highpass"]
FILTERS: tuple[Filter, ...] = ("", "lag", "highpass")
PartOfCar = Literal["steering path", "drive", "brake", "body", "tyres", "sensor"]


@dataclasses.dataclass(frozen=True, slots=True)
class Point:
    """A place in the car at which a term acts. slot and number: which generic effect, and which branch of it; size: of
    a coefficient of 1, in `unit`; odd: it changes its sign when left and right are exchanged; code: in effect files."""

    name: str
    part: PartOfCar
    slot: Literal["command", "force", "body", "sensor"]
    number: int
    size: float
    unit: Unit
    odd: bool
    code: str


POINTS: tuple[Point, ...] = (
    Point("steer", "steering path", "command", 0, 0.01, (0, 0, 1), True, "x.steer += {}"),
    Point("accel", "drive", "command", 1, 0.1, (1, -2, 0), False, "x.accel += {}"),
    Point("drag", "body", "force", 0, 0.1, (1, -2, 0), False, "x.drag += x.mass_ref * ({})"),
    Point("brake", "brake", "force", 1, 0.1, (1, -2, 0), False, "x.brake = max(x.brake + x.mass_ref * ({}), 0.0)"),
    Point("yaw_moment", "body", "body", 0, 0.05, (0, -2, 1), True, "x.yaw_moment += x.yaw_inertia * ({})"),
    Point("fy_front", "tyres", "body", 1, 0.1, (1, -2, 0), True, "x.fy_front += x.mass * ({})"),
    Point("fy_rear", "tyres", "body", 2, 0.1, (1, -2, 0), True, "x.fy_rear += x.mass * ({})"),
    Point("v", "sensor", "sensor", 0, 0.1, (1, -1, 0), False, "x.meas_v += {}"),
    Point("yaw_rate", "sensor", "sensor", 1, 0.01, (0, -1, 1), True, "x.meas_yaw_rate += {}"),
    Point("ax", "sensor", "sensor", 2, 0.1, (1, -2, 0), False, "x.meas_ax += {}"),
    Point("ay", "sensor", "sensor", 3, 0.1, (1, -2, 0), True, "x.meas_ay += {}"),
    Point("yaw", "sensor", "sensor", 4, 0.01, (0, 0, 1), True, "x.meas_yaw += {}"),
)

LAST_ORDER = {  # chosen: order in its slot of what a search tries, after every effect of the catalogue that alters it
    "command": 94, "force": 94, "body": 89, "sensor": 94,  # body: body_roll shows the sway under all forces
}  # fmt: skip


@dataclasses.dataclass(frozen=True, slots=True)
class Form:
    """The shape of a term: the product of `gate`, times `inside` behind a filter. Names are those of FACTORS."""

    gate: tuple[str, ...] = ()
    inside: tuple[str, ...] = ()
    filter: Filter = ""

    @property
    def odd(self) -> bool:
        """Whether it changes its sign when left and right are exchanged."""
        return sum(FACTORS[NUMBER[name]].odd for name in (*self.gate, *self.inside)) % 2 == 1

    @property
    def size(self) -> float:
        """Its usual size in a lively drive, in SI units."""
        return prod(FACTORS[NUMBER[name]].usual for name in (*self.gate, *self.inside))

    @property
    def complexity(self) -> int:
        """Factors, and two more for a filter with its time constant, one for a threshold."""
        names = (*self.gate, *self.inside)
        return len(names) + 2 * bool(self.filter) + sum(NUMBER[name] == THRESHOLD for name in names)

    @property
    def text(self) -> str:
        """As a person writes it: "v d", "a- lag(v a-)"."""
        inside = " ".join(self.inside)
        filtered = {"": inside, "lag": f"lag({inside})", "highpass": f"change({inside})"}[self.filter]
        return " ".join(part for part in (*self.gate, filtered) if part) or "1"


@dataclasses.dataclass(frozen=True, slots=True)
class Term:
    """A term with its values. c: in units of the point's size over the form's; tau [s] of the filter, v0 [m/s]."""

    point: Point
    form: Form
    c: float = 1.0
    tau: float = 1.0
    v0: float = 5.0

    @property
    def coefficient(self) -> float:
        """The coefficient in SI units."""
        return self.c * self.point.size / self.form.size

    @property
    def unit(self) -> str:
        """Unit of the coefficient: what makes the term dimensionally sound."""
        powers = [FACTORS[NUMBER[name]].unit for name in (*self.form.gate, *self.form.inside)]
        m, s, rad = (own - sum(unit[k] for unit in powers) for k, own in enumerate(self.point.unit))
        return unit_text((m, s, rad))

    @property
    def has_threshold(self) -> bool:
        """True if v0 matters."""
        return any(NUMBER[name] == THRESHOLD for name in (*self.form.gate, *self.form.inside))

    def values(self, effect: str) -> dict[tuple[str, str], float]:
        """(effect, key) -> value for the generic effect that plays it."""
        gate = [*(NUMBER[name] for name in self.form.gate), 0, 0, 0][:3]
        inside = [*(NUMBER[name] for name in self.form.inside), 0, 0][:2]
        found: Mapping[str, float] = {
            "point": self.point.number, "g1": gate[0], "g2": gate[1], "g3": gate[2], "h1": inside[0], "h2": inside[1],
            "filter": FILTERS.index(self.form.filter), "c": self.coefficient, "tau": self.tau, "v0": self.v0,
        }  # fmt: skip
        return {(effect, key): float(value) for key, value in found.items()}
