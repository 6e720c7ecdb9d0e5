"""What was found of a column."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.mapping import SignalMap
from pytest_dvp.recognition.columns import Column

ACCELERATIONS = frozenset({"ax", "ay"})


@dataclasses.dataclass(frozen=True, slots=True)
class Recognised:
    """A column as a signal: SI value = sign * scale * (unit -> SI) / ratio + offset, as in a mapping.

    evidence: what the numbers say, one phrase each; decided: they leave no other choice; else `rival` would do as well
    (a unit, or what would decide); when: of a mode, those of its values with which the car obeys.
    """

    name: str
    column: Column
    unit: str
    sign: float = 1.0
    scale: float = 1.0
    ratio: float = 1.0
    offset: float = 0.0
    frame: str = "flu"
    evidence: tuple[str, ...] = ()
    decided: bool = True
    rival: str = ""
    when: tuple[float | str, ...] = ()

    @property
    def signal(self) -> SignalMap:
        """The entry of a mapping."""
        unit = f"{self.column.way} {self.unit}".strip()
        return SignalMap(
            self.name, self.column.topic, self.column.field, unit, scale=self.scale, sign=self.sign,
            offset=self.offset, ratio=self.ratio, frame=self.frame, when=self.when,
        )  # fmt: skip


def otherwise_named(found: Sequence[Recognised]) -> list[str]:
    """A sentence for each acceleration whose column is named after the other one: the sensor may be mounted turned."""
    return [
        f"{one.column.field} is taken as {one.name}, because its numbers follow it, although its name says "
        f"{canonical(one.column.name)}: is the sensor mounted turned by 90 degrees?"
        for one in found
        if one.name in ACCELERATIONS and canonical(one.column.name) in ACCELERATIONS - {one.name}
    ]


@dataclasses.dataclass(frozen=True, slots=True)
class Recognition:
    """The signals of a log; remarks: what else was seen, a sentence each."""

    signals: tuple[Recognised, ...]
    remarks: tuple[str, ...] = ()
