"""Effects that play any term: the form is in their parameters, so that thousands of forms need one compilation."""

from __future__ import annotations

from functools import cache
from math import inf
from typing import Any

from numba.extending import register_jitable

from pytest_dvp.gap.discover.factors import value
from pytest_dvp.gap.discover.term import LAST_ORDER, POINTS, Term
from vehicle.model.effect import Effect, Key, Memory, Slot
from vehicle.model.step_maths import lag_end

MOST_TERMS = 3  # of a law, chosen so that a person can read and judge it

_KEYS = (
    *(Key(name, "-", 0.0, 20.0, neutral=0.0, least=1.0) for name in ("point", "g1", "g2", "g3", "h1", "h2", "filter")),
    Key("c", "SI", -inf, inf, neutral=0.0, least=0.0),
    Key("tau", "s", 0.02, 100.0, neutral=1.0, least=0.02, minimum=1e-3),
    Key("v0", "m/s", 0.0, 30.0, neutral=5.0, least=0.1),
)
_MEMORY = (Memory("h"),)


@register_jitable  # type: ignore[untyped-decorator,unused-ignore]
def _term(x: Any, p: Any, m: Any) -> float:
    """The term's value now, in the unit of its point; its memory begins with the log, not while actuators settle."""
    if p.c == 0.0:
        return 0.0
    inside = value(x, int(p.h1), p.v0) * value(x, int(p.h2), p.v0)
    if p.filter > 0.0:
        if x.settle == 0.0:
            m.h = lag_end(m.h, inside, p.tau, x.dt)
        inside = m.h if p.filter == 1.0 else inside - m.h
    gate = value(x, int(p.g1), p.v0) * value(x, int(p.g2), p.v0) * value(x, int(p.g3), p.v0)
    return float(p.c * gate * inside)


def _command(x: Any, p: Any, m: Any) -> None:
    term = _term(x, p, m)
    if p.point == 0.0:
        x.steer += term
    else:
        x.accel += term


def _force(x: Any, p: Any, m: Any) -> None:
    term = _term(x, p, m)
    if p.point == 0.0:
        x.drag += x.mass_ref * term
    else:
        x.brake = max(x.brake + x.mass_ref * term, 0.0)


def _body(x: Any, p: Any, m: Any) -> None:
    term = _term(x, p, m)
    if p.point == 0.0:
        x.yaw_moment += x.yaw_inertia * term
    elif p.point == 1.0:
        x.fy_front += x.mass * term
    else:
        x.fy_rear += x.mass * term


def _sensor(x: Any, p: Any, m: Any) -> None:
    term = _term(x, p, m)
    if p.point == 0.0:
        x.meas_v += term
    elif p.point == 1.0:
        x.meas_yaw_rate += term
    elif p.point == 2.0:
        x.meas_ax += term
    elif p.point == 3.0:
        x.meas_ay += term
    else:
        x.meas_yaw += term


_FUNCTIONS = {"command": _command, "force": _force, "body": _body, "sensor": _sensor}


def _generic(slot: Slot, number: int) -> Effect:
    return Effect(
        name=f"term_{slot}_{number}", slot=slot, physics="any term of a law", equation="c gate filter(inside)",
        source="this project", parameters=_KEYS, reveals="", function=_FUNCTIONS[slot], memory=_MEMORY,
        order=LAST_ORDER[slot],
        tyres=slot == "body",
    )  # fmt: skip


@cache
def generic_effects() -> tuple[Effect, ...]:
    """MOST_TERMS of each slot: `term_command_0`, ..."""
    slots = dict.fromkeys(point.slot for point in POINTS)
    return tuple(_generic(slot, number) for slot in slots for number in range(MOST_TERMS))


def effect_of(term: Term, number: int) -> str:
    """Name of the generic effect that plays a law's term number `number`."""
    return f"term_{term.point.slot}_{number}"


def values_of(terms: tuple[Term, ...]) -> dict[tuple[str, str], float]:
    """(effect, key) -> value of a law."""
    found: dict[tuple[str, str], float] = {}
    for number, term in enumerate(terms):
        found |= term.values(effect_of(term, number))
    return found
