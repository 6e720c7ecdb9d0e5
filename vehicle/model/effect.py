"""What a physical effect is: its description and one function, in one file.

    @effect(
        name="viscous_resistance", slot="force",
        physics="bearings and lubricant resist in proportion to speed",
        equation="a = -c v", source="Wong, Theory of Ground Vehicles, 4th ed., sec. 3.1",
        parameters=(Key("c", "1/s", low=0.005, high=1.0, neutral=0.0, least=0.005, minimum=0.0),),
        reveals="coast down from 15 m/s to standstill",
    )
    def viscous_resistance(x: Bus, p: Any, m: Any) -> None:
        x.drag -= p.c * x.mass_ref * x.vx

`x` is the bus, `p` holds the effect's parameters by key, `m` its own memory (doubles, kept from step to step).
The function is compiled on first use; it may call the helpers of `vehicle.model.step_maths` and `math`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, isnan
from typing import Any, Literal, TypeAlias

from vehicle.model.bus import BUS_FIELDS
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.shown_by import BY_SLOT, ShownBy
from vehicle.model.step_maths import DELAY_LINE

Slot: TypeAlias = Literal["command", "actuator", "force", "body", "road", "sensor", "perception"]
SLOTS: tuple[Slot, ...] = ("command", "actuator", "force", "body", "road", "sensor", "perception")

EffectFunction: TypeAlias = Callable[[Any, Any, Any], Any]  # (bus, p, m), of perception (tracks, p, rng)


@dataclass(frozen=True, slots=True)
class Key:
    """One parameter of an effect.

    `low`..`high` is the range met in practice (where a search looks; a model may hold a value outside);
    `minimum`..`maximum` what the equation allows, outside which a value is refused.
    `neutral` switches the effect off; `least` is the smallest difference from neutral worth naming.
    `late`: says how the effect acts, not how much, and a search fits it only when it can go no further without.
    `where`: says where the effect lies, not how much it does.
    `step`: next to the neutral value nothing moves yet, so what the key does there is seen over this much of it.
    """

    name: str
    unit: str
    low: float
    high: float
    neutral: float
    least: float
    minimum: float = -inf
    maximum: float = inf
    meaning: str = ""
    late: bool = False
    where: bool = False
    step: float = 0.0

    @property
    def allowed(self) -> str:
        """What `check` accepts, in words; the neutral value always passes."""
        return self._allowed("")

    def _allowed(self, unit: str) -> str:
        if self.minimum == -inf:
            return "any" if self.maximum == inf else f"up to {self.maximum:g}{unit}"
        return (
            f"{self.minimum:g}{unit} or more" if self.maximum == inf else f"{self.minimum:g} to {self.maximum:g}{unit}"
        )

    def check(self, value: float) -> float:
        """`value` if it may stand in a model. Raises ModelError."""
        if value != self.neutral and not (isfinite(value) and self.minimum <= value <= self.maximum):
            unit = "" if self.unit == "-" else f" {self.unit}"
            outside = not self.minimum <= self.neutral <= self.maximum or self.neutral == inf
            allowed = self._allowed(unit) + (f", {self.neutral:g} for none" if outside else "")
            raise ModelError("value not allowed", key=self.name, found=f"{value:g}", allowed=allowed)
        return value


@dataclass(frozen=True, slots=True)
class Memory:
    """A double (or `size` of them) that an effect keeps; at reset it takes the bus field `start`, else 0."""

    name: str
    size: int = 1
    start: str = ""


@dataclass(frozen=True)
class Effect:
    """A physical effect: metadata and the function that acts on the bus in its slot."""

    name: str
    slot: Slot
    physics: str
    equation: str
    source: str
    parameters: tuple[Key, ...]
    reveals: str
    function: EffectFunction
    memory: tuple[Memory, ...] = ()
    ties: tuple[str, ...] = ()
    order: int = 50
    base: tuple[str, ...] = ("kinematic_bicycle", "dynamic_bicycle")
    delay: str = ""
    tyres: bool = False
    fine: bool = False
    shown_by: ShownBy = field(default_factory=ShownBy)
    diagnosed: Diagnosed = field(default_factory=Diagnosed)

    def key(self, name: str) -> Key:
        """The parameter called `name`. Raises ModelError with the nearest name."""
        for key in self.parameters:
            if key.name == name:
                return key
        known = [k.name for k in self.parameters]
        raise ModelError(
            f"effect {self.name} has no such parameter",
            key=name,
            found=name,
            allowed=", ".join(known),
            nearest=nearest_name(name, known),
        )

    def neutral(self) -> dict[str, float]:
        """The values that switch the effect off."""
        return {k.name: k.neutral for k in self.parameters}

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """`values` checked, with the keys left out at their neutral value. Raises ModelError."""
        checked = {name: self.key(name).check(float(value)) for name, value in values.items()}
        return {k.name: checked.get(k.name, k.neutral) for k in self.parameters}

    def is_off(self, values: Mapping[str, float]) -> bool:
        """True if `values` are all neutral."""
        return all(values[k.name] == k.neutral for k in self.parameters)


DELAY_MEMORY: tuple[Memory, ...] = (
    Memory("head"),
    Memory("tail"),
    Memory("ring", DELAY_LINE),
    Memory("leads", DELAY_LINE),
    Memory("ends", DELAY_LINE),
    Memory("spans", DELAY_LINE),
)
"""Memory of `maths.delayed`, to which an effect adds Memory("before"), what the input was before the first step."""

HISTORY_MEMORY: tuple[Memory, ...] = (Memory("head"), Memory("tail"), Memory("times", DELAY_LINE))
"""Memory of `maths.remember` and `recall`, to which an effect adds its own lines of DELAY_LINE values."""


def effect(
    *,
    name: str,
    slot: Slot,
    physics: str,
    equation: str,
    source: str,
    parameters: tuple[Key, ...],
    reveals: str,
    memory: tuple[Memory, ...] = (),
    ties: tuple[str, ...] = (),
    order: int = 50,
    base: tuple[str, ...] = ("kinematic_bicycle", "dynamic_bicycle"),
    delay: str = "",
    tyres: bool = False,
    fine: bool = False,
    shown_by: ShownBy | None = None,
    diagnosed: Diagnosed | None = None,
) -> Callable[[EffectFunction], Effect]:
    """Turn a function into an Effect.

    `order` sorts effects within a slot (smaller first, then by name); `ties` names effects that data of the usual kind
    cannot tell from this one; `delay` names the parameter that a delay line of `maths.DELAY_LINE` steps must hold;
    `tyres` says that it acts on tyre forces: a kinematic car with it moves as a single-track car with tyres;
    `fine` that a replay needs steps of 10 ms with it (as with every tyre effect that has a memory), not of 20;
    `shown_by` what a log must hold for it to show (left out: what its slot tells);
    `diagnosed` how a diagnosis tries it on a log.
    Raises ModelError at once if the description is wrong, so that a faulty third-party effect cannot get far.
    """
    if slot not in SLOTS:
        raise ModelError(
            f"effect {name}: no such slot", key="slot", found=str(slot), allowed=", ".join(SLOTS), nearest=slot
        )
    if not parameters:
        raise ModelError(f"effect {name}: needs a parameter with a neutral value", key="parameters")
    for k in parameters:
        if not (isfinite(k.low) and isfinite(k.high) and k.low < k.high and not isnan(k.neutral)):
            raise ModelError(f"effect {name}: range or neutral value is wrong", key=k.name)
        if not 0.0 <= k.step <= k.high - k.low:
            allowed = f"0 to {k.high - k.low:g} {k.unit}"
            raise ModelError(f"effect {name}: step outside its range", key=k.name, found=f"{k.step:g}", allowed=allowed)
    for m in memory:
        if m.start and m.start not in BUS_FIELDS:
            near = nearest_name(m.start, BUS_FIELDS)
            raise ModelError(f"effect {name}: no such bus field", key=m.name, found=m.start, nearest=near)

    def make(function: EffectFunction) -> Effect:
        return Effect(
            name=name,
            slot=slot,
            physics=physics,
            equation=equation,
            source=source,
            parameters=parameters,
            reveals=reveals,
            function=function,
            memory=memory,
            ties=ties,
            order=order,
            base=base,
            delay=delay,
            tyres=tyres,
            fine=fine,
            shown_by=shown_by or BY_SLOT[slot],
            diagnosed=diagnosed or Diagnosed(),
        )

    return make
