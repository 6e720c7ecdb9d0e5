"""A law as an effect file of the user's kind: to be read, renamed, used and contributed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count, groupby

from pytest_dvp.gap.discover.factors import FACTORS, NUMBER
from pytest_dvp.gap.discover.law import FoundTerm, Law
from pytest_dvp.gap.discover.term import LAST_ORDER, Term
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import catalogue

_SYMBOL = {"steer": "d", "accel": "a", "drag": "F_x/m", "brake": "F_brake/m", "yaw_moment": "M_z/I"}
_SYMBOL |= {"fy_front": "F_yf/m", "fy_rear": "F_yr/m"}


def law_names(law: Law, beside: Sequence[Effect] = ()) -> tuple[str, ...]:
    """Names of the effects in the file, one for each slot that the law acts in: "law_steer", or, if an effect of the
    catalogue or of `beside` has that name, "law_steer_2"."""
    return tuple(_name(terms, _known(beside)) for terms in _by_slot(law))


def equation(terms: Sequence[FoundTerm]) -> str:
    """Terms as one line: "d += -0.026 v d"."""
    lines = []
    for found in terms:
        term = found.term
        where = _SYMBOL.get(term.point.name, f"{term.point.name} shown")
        text = f"{where} += {term.coefficient:.4g} {term.form.text}"
        text += f", tau = {term.tau:.3g} s" if term.form.filter else ""
        lines.append(text + (f", v0 = {term.v0:.3g} m/s" if term.has_threshold else ""))
    return "; ".join(lines)


def effect_text(law: Law, *, fitted: Sequence[str], held_out: Sequence[str], beside: Sequence[Effect] = ()) -> str:
    """The Python text of the file. fitted, held_out: names of the logs; beside: effects of the user's own with which
    the law was found."""
    fit, judged = law.removed
    kind = "a law" if law.verdict == "LAW" else "a stand-in, whose form is not proven"
    effects = [_effect(terms, _known(beside)) for terms in _by_slot(law)]
    body = "\n".join(effects)
    used = [name for name in ("sqrt", "tanh") if f"{name}(" in body]
    lines = [
        f'"""{equation(law.terms)}',
        "",
        f"Found by dvp discover in {_listed(fitted)}: {kind}. It takes away {fit:.0%} of the error beyond the noise",
        f"there, and {judged:.0%} on {_listed(held_out)}.",
        '"""',
        "",
        *([f"from math import {', '.join(used)}", ""] if used else []),
        f"from vehicle.model.effect import Key, {'Memory, ' if 'Memory(' in body else ''}effect",
        *(["from vehicle.model.step_maths import lag_end"] if "lag_end(" in body else []),
    ]
    return "\n".join([*lines, "", "", body])


def _listed(names: Sequence[str]) -> str:
    """Names of files as they may stand in a docstring, whatever is in them."""
    return ", ".join(name.replace("\\", "\\\\").replace('"', '\\"') for name in names)


def _by_slot(law: Law) -> list[list[FoundTerm]]:
    ordered = sorted(law.terms, key=lambda found: found.term.point.slot)
    return [list(terms) for _, terms in groupby(ordered, key=lambda found: found.term.point.slot)]


def _known(beside: Sequence[Effect]) -> list[Effect]:
    return [*catalogue().values(), *beside]


def _name(terms: Sequence[FoundTerm], known: Sequence[Effect]) -> str:
    name = "law_" + "_".join(dict.fromkeys(found.term.point.name for found in terms))
    taken = {effect.name for effect in known}
    return next(free for k in count(1) if (free := name if k == 1 else f"{name}_{k}") not in taken)


def _order(slot: str, known: Sequence[Effect]) -> int:
    """After all that the search has before its terms, so that the law sees what they saw."""
    last = LAST_ORDER[slot]
    before = max((effect.order for effect in known if effect.slot == slot and effect.order <= last), default=0)
    return min(before + 1, last)


def _effect(terms: Sequence[FoundTerm], known: Sequence[Effect]) -> str:
    keys = [key for number, found in enumerate(terms, 1) for key in _keys(found, number)]
    memory = [f'Memory("h{number}")' for number, found in enumerate(terms, 1) if found.term.form.filter]
    slot, name = terms[0].term.point.slot, _name(terms, known)
    order = f"order={_order(slot, known)},  # after what is known of this slot"
    about = [
        f'name="{name}",', f'slot="{slot}",', order,
        'physics="found in measurements",', f'equation="{equation(terms)}",', 'source="dvp discover",',
        'reveals="the drives that it was found in",', *(["tyres=True,"] if slot == "body" else []),
        "parameters=(", *(f"    {key}," for key in keys), "),",
        *([f"memory=({', '.join(memory)},),"] if memory else []),
    ]  # fmt: skip
    body = [line for number, found in enumerate(terms, 1) for line in _code(found.term, number)]
    lines = ["@effect(", *(f"    {line}" for line in about), ")", f"def {name}(x, p, m):"]
    return "\n".join([*lines, *(f"    {line}" for line in body)]) + "\n"


def _keys(found: FoundTerm, number: int) -> list[str]:
    term = found.term
    reach = 3.0 * max(abs(found.low), abs(found.high), abs(term.coefficient))
    keys = [f'Key("c{number}", "{term.unit}", {-reach:.4g}, {reach:.4g}, neutral=0.0, least={0.02 * reach:.2g})']
    if term.form.filter:
        tau, least = term.tau, 0.05 * term.tau
        span = f"{tau / 5.0:.4g}, {tau * 5.0:.4g}, neutral={tau:.6g}, least={least:.2g}"
        keys.append(f'Key("tau{number}", "s", {span}, minimum=0.001)')
    if term.has_threshold:
        span = f"0.0, {3.0 * term.v0 + 1.0:.4g}, neutral={term.v0:.6g}, least=0.1, minimum=0.0"
        keys.append(f'Key("v0_{number}", "m/s", {span})')
    return keys


def _code(term: Term, number: int) -> list[str]:
    def product(names: Sequence[str]) -> str:
        return " * ".join(FACTORS[NUMBER[name]].code for name in names).replace("p.v0", f"p.v0_{number}")

    lines = []
    inside = product(term.form.inside)
    if term.form.filter:
        step = f"m.h{number} = lag_end(m.h{number}, {inside}, p.tau{number}, x.dt)"
        lines += ["if x.settle == 0.0:", f"    {step}"] if term.point.slot == "command" else [step]
        inside = f"m.h{number}" if term.form.filter == "lag" else f"({inside} - m.h{number})"
    whole = " * ".join(part for part in (f"p.c{number}", product(term.form.gate), inside) if part)
    return [*lines, term.point.code.format(whole)]
