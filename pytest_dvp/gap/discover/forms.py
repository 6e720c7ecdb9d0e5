"""The grammar: which forms are looked at, at which points."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import cache

from pytest_dvp.gap.discover.term import POINTS, Form, Point, Term
from vehicle.model.vehicle_model import VehicleModel

_FREE = ("v", "d", "|d|", "a+", "a-", "ay", "|ay|", "r", "ax", "(v - v0)+", "tanh(r)")
_REMEMBERED = (
    ("v", "a-"), ("v", "a+"), ("a-",), ("a+",), ("v",), ("v", "v"), ("d",), ("v", "d"), ("ay",), ("|ay|",),
    ("v", "|ay|"), ("r",), ("ax",), ("ax", "ay"), ("[brake]",), ("[drive]",),
)  # fmt: skip
_GATES = ((), ("v",), ("d",), ("a+",), ("a-",), ("[drive]",), ("[brake]",), ("ay",), ("r",))
TAUS = (0.1, 0.5, 2.0, 10.0, 60.0)  # s, between which a fit moves on
FAST_TAUS = (0.1, 0.5, 2.0)  # s, of what only changes count of
MOST_OF_A_PULL = 2  # factors of what may act to one side without turning
THRESHOLDS = (4.0, 9.0, 16.0)  # m/s


@cache
def forms() -> tuple[Form, ...]:
    """All forms, the simple ones first."""
    found: dict[Form, None] = {Form(): None}
    for name in _FREE:
        found[Form((name,))] = None
    for pair in itertools.combinations_with_replacement(_FREE, 2):
        if _sensible(pair):
            found[Form(pair)] = None
    for name in _FREE:
        if _sensible(("v", name)):
            found[Form(("v", "v", name))] = None
            found[Form(("v", name, "|ay|"))] = None
    for name in ("d", "ay", "r"):
        found[Form((name, name, name))] = None
        found[Form((name, "a-", "v"))] = None
        found[Form((name, "a+", "v"))] = None
    for names in (("[coast]",), ("[coast]", "v"), ("sqrt(v)",)):  # a motor that holds back, a power between 0 and 1
        found[Form(names)] = None
    for inside, gate in itertools.product(_REMEMBERED, _GATES):
        found[Form(gate, inside, "lag")] = None
        if not gate:
            found[Form(gate, inside, "highpass")] = None
    return tuple(sorted(found, key=lambda form: form.complexity))


def _sensible(pair: tuple[str, ...]) -> bool:
    """Not a product that is always 0, nor |d| |d|, which is d d."""
    return pair not in (("a+", "a-"), ("|d|", "|d|"), ("|ay|", "|ay|"))


def points(model: VehicleModel, channels: tuple[str, ...]) -> tuple[Point, ...]:
    """Points at which a law can act on this model and be seen: tyres have forces only if they slip, a sensor must be
    there, and a speed that is imposed leaves nothing to drive."""
    driven = model.inputs.longitudinal != ("v",)
    return tuple(
        p for p in POINTS
        if (p.slot != "body" or model.base == "dynamic_bicycle") and (p.slot != "sensor" or p.name in channels)
        and (driven or p.name not in ("accel", "drag", "brake"))
    )  # fmt: skip


def terms_at(point: Point) -> Iterator[Term]:
    """Terms to try at a point, each with the time constants and thresholds from which a fit begins.

    A car is the same left and right, so a law of what acts sideways is odd, and one of what acts along is even; only a
    plain pull (c, c a+, c v a-) may act to one side.
    """
    for form in forms():
        pulls = not form.filter and form.complexity <= MOST_OF_A_PULL
        if form.odd != point.odd and not (point.odd and pulls):
            continue
        if point.slot == "sensor" and form.filter and form.gate:
            continue  # a sensor has no heat of brakes
        if form.filter:
            for tau in TAUS if form.filter == "lag" else FAST_TAUS:
                yield Term(point, form, tau=tau)
        elif "(v - v0)+" in form.gate:
            for v0 in THRESHOLDS:
                yield Term(point, form, v0=v0)
        else:
            yield Term(point, form)
